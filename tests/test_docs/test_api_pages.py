import importlib.util
import re
import sys

import pytest


@pytest.fixture(scope="module")
def topics(root):
    path = root / "docs" / "hooks" / "api_topics.py"
    spec = importlib.util.spec_from_file_location("api_topics", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["api_topics"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    module.NAMES = module.public_names()
    yield module
    del sys.modules["api_topics"]


def test_every_public_name_has_one_place_and_a_line_in_the_index(topics, public):
    pages = topics.pages(topics.NAMES)
    index = pages.pop("api/index.md")
    placed = [name for text in pages.values() for name in re.findall(r"^::: ([\w.]+)$", text, re.M)]
    assert sorted(placed) == sorted(public)
    listed = re.findall(r"^\| \[`cf\.([\w.]+)`\]", index, re.M)
    assert sorted(f"crankfem.{name}" for name in listed) == sorted(public)


def test_every_name_and_topic_is_described(topics):
    assert [one.path for one in topics.NAMES if not one.summary] == []
    assert [one.package for one in topics.topics() if not one.summary] == []


def test_every_topic_shows_the_way_in_and_has_a_line_in_the_navigation(topics, root):
    pages = topics.pages(topics.NAMES)
    navigation = (root / "mkdocs.yml").read_text(encoding="utf-8")
    for topic in topics.topics():
        assert f": api/{topic.file}.md\n" in navigation
        if topic.file != "crankfem":
            assert "```pycon\n>>> " in pages[f"api/{topic.file}.md"]
