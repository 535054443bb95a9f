"""The notebooks run from top to bottom, are kept without outputs, and show what they promise."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parents[2] / "examples" / "notebooks").glob("*.ipynb"))


@pytest.fixture(scope="module")
def start():
    """The outputs of the first notebook by the first words of its cells."""
    path = next(path for path in NOTEBOOKS if path.stem == "start")
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    return {cell.source: cell.outputs for cell in notebook.cells if cell.cell_type == "code"}


def shown(outputs, kind):
    """What the outputs of a cell show of a kind, e.g. "text/html"."""
    return [output.data[kind] for output in outputs if "data" in output and kind in output.data]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell for cell in code if cell.outputs or cell.execution_count is not None] == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Proactor event loop:RuntimeWarning")  # of pyzmq on Windows
def test_the_first_notebook_shows_peaks_curves_a_bar_and_a_wedge_in_motion(start):
    """The peak at 1 N by one harmonic: the energy balance 4 µN (X − s) + π c ω X² = π F X with s = µN/kt,
    m ω² = k + kt (θ − ½ sin 2θ)/π and cos θ = 1 − 2s/X gives X = 102.63 µm; the table shows 103."""
    assert not [output for outputs in start.values() for output in outputs if output.output_type in ("error", "stream")]
    peaks = next(outputs for source, outputs in start.items() if source.endswith("mode.peaks()"))
    first = shown(peaks, "text/plain")[-1].splitlines()[1].split()
    assert float(first[5]) == pytest.approx(102.63e-6, rel=5e-3)
    for name in ("mode.plot()", "response.plot()", 'response.plot("loops")'):
        assert shown(start[name], "image/png")
    (bar, *_) = shown(next(outputs for source, outputs in start.items() if "progress_bar" in source), "text/plain")
    assert bar.startswith("Blade and wedge ")
    assert "%" not in bar  # finished: the time that it took
    (film,) = shown(start["response.animate(case=1)"], "text/html")
    assert film.startswith("<iframe")
