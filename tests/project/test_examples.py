"""Every example runs, and one number of each is pinned. An example keeps its number in a variable that the table names."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))

# File: variable, expected value, relative tolerance.
PINNED: dict[str, tuple[str, float, float]] = {
    "one_mass_and_a_slider.py": ("smallest_amplitude_per_newton", 3.144588784, 1e-6),
}


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path, monkeypatch, tmp_path):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(tmp_path)
    variable, expected, tolerance = PINNED[path.name]
    assert float(runpy.run_path(str(path), run_name="__main__")[variable]) == pytest.approx(expected, rel=tolerance)


def test_no_pinned_number_is_left_over():
    assert set(PINNED) == {path.name for path in EXAMPLES}
