"""Figures: every one drawn, saved whole, with the data in it; strange datasets do not break them."""

import subprocess
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from report.synthetic import KINDS, poor

from stickslip.results.schema import Result
from stickslip.show.plots.contacts import hysteresis_loops
from stickslip.show.plots.paper import write_figures
from stickslip.show.plots.response_curves import response_curves
from stickslip.show.report.responses import FIGURES, figures_of
from stickslip.support.checks import InputError
from stickslip.support.renderers import FIGURES as REGISTERED


@pytest.mark.parametrize("name", FIGURES)
def test_figures_are_drawn_and_not_blank(name, dataset_with_failures, tmp_path):
    figure = FIGURES[name](dataset_with_failures).plot()
    figure.savefig(tmp_path / "f.png", dpi=60)
    pixels = imread(tmp_path / "f.png")[..., :3]
    inked = np.mean(np.any(pixels < 0.97, axis=-1))
    assert 0.02 < inked < 0.9


@pytest.mark.nightly
def test_figures_are_written_alike_each_time(dataset, tmp_path):
    first, second = (write_figures(figures_of(dataset), dataset, tmp_path / folder, ("svg",)) for folder in "ab")
    assert [path.stem for path in first] == list(FIGURES)
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    assert not list(tmp_path.glob("*/.*"))


def test_curves_hold_the_data_in_micrometres(dataset):
    axes = response_curves(dataset).plot().axes[0]
    line = next(line for line in axes.lines if line.get_label() == "force × 80")
    amplitude = dataset.amplitude.values[3, :, 0]
    assert np.allclose(line.get_ydata(), 1e6 * amplitude[np.isfinite(amplitude)])
    assert axes.get_yscale() == "log"
    assert "µm" in axes.get_ylabel()
    assert "Hz" in axes.get_xlabel()


def test_per_force_divides_by_the_level(dataset):
    axes = response_curves(dataset, output="root.x", log=False, per_force=True).plot().axes[0]
    line = next(line for line in axes.lines if line.get_label() == "force × 20")
    assert np.nanmax(line.get_ydata()) == pytest.approx(1e6 * float(dataset.amplitude[2, :, 1].max()) / 20.0)


def test_loops_hold_the_data(dataset):
    panels = hysteresis_loops(dataset).plot().axes
    line = panels[3].lines[0]
    assert np.allclose(line.get_ydata()[:-1], dataset.loop_force.values[3, 0, 0])
    assert np.allclose(line.get_xdata()[:-1], 1e6 * dataset.loop_motion.values[3, 0, 0])


def test_unknown_output_is_refused(dataset):
    with pytest.raises(InputError, match=r"must be an output.*tip\.x"):
        response_curves(dataset, output="tip.y")


def test_a_result_draws_its_figures_by_name(dataset):
    curves = type("Curves", (Result,), {"dataset": dataset})()
    REGISTERED.of("Curves")(response_curves)
    REGISTERED.of("Curves", "loops")(hysteresis_loops)
    assert isinstance(curves.plot(log=False), Figure)
    assert len(curves.plot("loops").axes) == len(hysteresis_loops(dataset).panels)
    with pytest.raises(InputError, match=r"figure must be a known one, but is 'loop'\. Did you mean 'loops'"):
        curves.plot("loop")


@pytest.mark.parametrize(
    "kind",
    [
        "nothing converged",
        "folded",
        *(pytest.param(kind, marks=pytest.mark.nightly) for kind in sorted({*KINDS} - {"nothing converged", "folded"})),
    ],
)
def test_poor_datasets_are_drawn(kind, tmp_path):
    assert all(path.stat().st_size > 1000 for path in write_figures(figures_of(poor(kind)), poor(kind), tmp_path, ("png",)))


def test_plots_load_matplotlib_late():
    code = (
        "import sys, stickslip.show.plots, stickslip.results.files; sys.exit(bool({'matplotlib', 'xarray'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
