"""Free memory, of the machine and of containers, and work that is refused for want of it.

The control groups' files are as Linux writes them (kernel documentation, cgroup-v2 and memory v1).
"""

import psutil
import pytest

from comparing import close
from crankbase import memory
from crankbase.errors import InputError, NotEnoughMemoryError
from crankbase.memory import check_memory, free_memory


@pytest.fixture
def group(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "CONTROL_FOLDER", tmp_path)
    (tmp_path / "memory").mkdir()
    return tmp_path


def test_without_a_limit_it_is_the_machines(group):
    machine = psutil.virtual_memory().available
    assert free_memory() == close(machine, rel=0.2)
    (group / "memory.max").write_text("max\n")
    assert free_memory() == close(machine, rel=0.2)


@pytest.mark.parametrize(
    ("limit", "use", "cached"),
    [
        ("memory.max", "memory.current", "inactive_file"),
        ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes", "total_inactive_file"),
    ],
)
def test_a_containers_limit_less_what_is_used_but_for_the_cache(group, limit, use, cached):
    (group / limit).write_text("50000000\n")
    (group / use).write_text("40000000\n")
    (group / limit).with_name("memory.stat").write_text(f"anon 10000000\n{cached} 30000000\n")
    assert free_memory() == 40e6


def test_what_does_not_fit_is_refused_with_both_figures(monkeypatch):
    monkeypatch.setattr(memory, "free_memory", lambda: 2.4e9)
    check_memory(2.3e9, "accuracy: given 0.001, whose mesh takes", "ask for a larger one")
    with pytest.raises(NotEnoughMemoryError) as refused:
        check_memory(5.1e9, "accuracy: given 0.001, whose mesh takes", "ask for a larger one")
    assert isinstance(refused.value, InputError)
    assert str(refused.value) == (
        "accuracy: given 0.001, whose mesh takes about 5.1 GB of memory; allowed is what fits into the 2.4 "
        "GB that are free, so ask for a larger one."
    )
