"""The memory that a process may take, and has."""

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
    before = machine.taken()
    held = np.ones(1 << 24)
    assert abs(machine.taken() - before - held.nbytes) < 0.1 * held.nbytes
