"""The memory that a process may take, and has."""

from mmap import mmap

import numpy as np

from stickslip.support import machine


def test_a_container_has_no_more_memory_than_its_limit(tmp_path, monkeypatch):
    limits = [tmp_path / "new", tmp_path / "old"]
    monkeypatch.setattr(machine, "LIMITS", limits)
    whole = machine.memory()
    limits[0].write_text("max\n")
    assert machine.memory() == whole
    limits[1].write_text(f"{whole // 3}\n")
    assert machine.memory() == whole // 3
    limits[1].write_text(f"{2 * whole}\n")
    assert machine.memory() == whole


def test_memory_that_is_taken_counts():
    """Of pages of its own: an array may find room in what the process has and no longer uses."""
    before, size = machine.taken(), 1 << 27
    with mmap(-1, size) as held:
        np.frombuffer(held, dtype=np.uint8)[:] = 1
        assert abs(machine.taken() - before - size) < 0.1 * size
