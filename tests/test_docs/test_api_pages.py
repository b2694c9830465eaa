import importlib.util
import re
import sys

import pytest

import crankfem as cf


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


def test_every_public_name_has_one_place_and_a_line_in_the_index(topics):
    pages = topics.pages(topics.NAMES)
    index = pages.pop("api/index.md")
    placed = [
        name for text in pages.values() for name in re.findall(r"^::: crankfem\.(\w+)$", text, re.M)
    ]
    assert sorted(placed) == sorted(cf.__all__)
    assert sorted(re.findall(r"^\| \[`(\w+)`\]", index, re.M)) == sorted(cf.__all__)


def test_every_name_is_described(topics):
    assert [one.name for one in topics.NAMES if not one.summary] == []


def test_every_topic_has_names_and_a_line_in_the_navigation(topics, root):
    used = {topics.topic_of(one.module).file for one in topics.NAMES}
    assert used == {topic.file for topic in topics.TOPICS}
    navigation = (root / "mkdocs.yml").read_text(encoding="utf-8")
    for name in used:
        assert f": api/{name}.md\n" in navigation


def test_a_module_without_topic_is_told(topics):
    with pytest.raises(ValueError, match=r"fem\.magic: has public names but no topic"):
        topics.topic_of("fem.magic")
