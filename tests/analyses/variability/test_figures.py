"""Every figure of response variability draws what it says, from small results."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.analyses.variability.bounds import response_bounds
from stickslip.analyses.variability.samples import response_history, response_samples
from stickslip.model.rigs import three_mass_wedge
from stickslip.show.plots.time_response import Cycles, contact_forces, force_ratios, loops, sample_cycles
from stickslip.show.plots.variability import loss_factors, response_cloud, response_percentiles, start_states
from stickslip.show.report.responses import bounds_table, percentiles_table
from stickslip.support.checks import InputError
from stickslip.support.units import hertz
from verify.force_plane import force_plane, paths_in, plane_chart


@pytest.fixture(scope="module")
def bounds():
    return response_bounds(three_mass_wedge(), [215.0, 222.0], [0.5, 1.0], cloud=4)


def test_bounds(bounds):
    figure = bounds.plot()
    assert len(figure.axes) == 2
    upper = figure.axes[1].lines[2]
    assert upper.get_ydata()[-1] == pytest.approx(62.28618, rel=1e-5)


def test_peaks_and_loss_factors(bounds):
    peak = response_bounds(three_mass_wedge(), hertz(200.0, 235.0), [0.5, 1.0], "peak", cloud=2, starts=1)
    amplitude, frequency = peak.plot().axes
    assert amplitude.get_ylabel().startswith("peak amplitude")
    assert frequency.lines[0].get_xdata().tolist() == [0.5, 1.0]
    assert len(loss_factors(bounds.dataset).panels[0].layers) == 4


def test_forces_and_start_states(bounds):
    chosen = contact_forces(bounds.dataset, 1, 222.0, ["blade 1 n"])
    assert chosen.panels[0].title == "blade 1 n"
    assert len(contact_forces(bounds.dataset, 1, 222.0).panels) == 4
    ratios = force_ratios(bounds.dataset, 1, 222.0).panels[0].layers
    assert max(abs(line.y).max() for line in ratios) <= 0.5 * (1.0 + 1e-9)
    assert len(start_states(bounds.dataset).panels) == 2
    with pytest.raises(InputError, match="row must be a known one"):
        contact_forces(bounds.dataset, rows=["blade 3 n"])


def test_cloud_with_bounds(bounds):
    samples = response_samples(three_mass_wedge(), hertz(210.0, 230.0), 1.0, 3)
    assert len(samples.plot(bounds=bounds.dataset).axes[0].lines) == 5
    assert len(response_cloud(samples.dataset).panels[0].layers) == 3


def test_history_and_freedom():
    history = response_history(three_mass_wedge(), [215.0, 222.0], [0.3, 2.0, 0.3])
    assert history.plot().axes[0].lines
    with pytest.raises(InputError, match="more than once"):
        history.plot(level=2.0)


def test_forces_and_loops_with_samples_behind(bounds):
    """Samples solved at one frequency bring their cycles there, whose first harmonic is the one reported."""
    samples = response_samples(three_mass_wedge(), [222.0], 1.0, 4)
    cycles = sample_cycles(samples.dataset, 1.0)
    assert cycles.rows == ("blade 1 t1", "blade 1 n", "blade 2 t1", "blade 2 n")
    first = 2.0 * np.abs(np.fft.rfft(cycles.force[:, 0])[:, 1]) / cycles.force.shape[-1]
    harmonic = np.hypot(*np.moveaxis(samples.dataset.contact_force.values[:, 0, 0, 0, 1], -1, 0))
    np.testing.assert_allclose(first, harmonic, rtol=1e-9)
    assert len(contact_forces(bounds.dataset, 1, 222.0, samples=samples.dataset).panels[0].layers) == 6
    assert len(loops(bounds.dataset, 1, 222.0, samples=samples.dataset).panels[0].layers) == 6


def test_points_of_a_surface_are_summed():
    names = ("left flat 1 t1", "left flat 1 n", "left flat 2 t1", "left flat 2 n", "blade t1")
    values = np.arange(10.0).reshape(1, 5, 2)
    found = Cycles(names, values, values).summed()
    assert found.rows == ("left flat t1", "left flat n", "blade t1")
    np.testing.assert_array_equal(found.force[0], [[4.0, 6.0], [8.0, 10.0], [8.0, 9.0]])
    np.testing.assert_array_equal(found.motion[0, 0], [2.0, 3.0])


def test_limit_lines_of_a_wedge():
    """A rigid wedge, both sides at T: N between C_F/(2 (cos a ± μ sin a)) (balance by hand); T = ±μN on the lines."""
    wedge = three_mass_wedge()
    plane = force_plane(wedge, ("D.x", "D.y"), ("blade 1", "blade 2"))
    mu, angle = 0.5, np.pi / 6.0
    normal = plane.normal(plane.corners())
    ends = 120.0 / (2.0 * (np.cos(angle) + np.array([1.0, -1.0]) * mu * np.sin(angle)))
    symmetric = [k for k in range(4) if normal[k, 0] == pytest.approx(normal[k, 1])]
    np.testing.assert_allclose(sorted(normal[symmetric, 0]), sorted(ends))
    np.testing.assert_allclose(np.abs(plane.corners()), mu * normal)
    along = np.linspace(-30.0, 30.0, 5)
    for side in (0, 1):
        points = plane.limit(side, 1, along)
        np.testing.assert_allclose(points[:, side], mu * plane.normal(points)[:, side])
        np.testing.assert_array_equal(points[:, 1 - side], along)
    assert plane.inside(np.zeros(2))
    assert not plane.inside(np.array([100.0, 0.0]))
    with pytest.raises(InputError, match="side must name contacts"):
        force_plane(wedge, ("D.x", "D.y"), ("blade 1", "blade 3"))


def test_the_plane_is_drawn(bounds):
    plane = force_plane(three_mass_wedge(), ("D.x", "D.y"), ("blade 1", "blade 2"))
    (panel,) = plane_chart(bounds.dataset, plane, 1, 222.0).panels
    assert len(panel.layers) == 4 + 1 + 4
    assert panel.x.quantity == "tangential force of blade 1"


def test_a_figure_by_its_name(bounds):
    for name in bounds.figures:
        assert bounds.plot(figure=name).axes
    with pytest.raises(InputError, match="figure must be a known one"):
        bounds.plot(figure="loop")


def light_wedge():
    """The wedge with next to no mass and no other spring than its contacts: what the static picture is about."""
    wedge = three_mass_wedge()
    M, K = wedge.structure.M.copy(), wedge.structure.K.copy()
    M[4:, 4:] *= 1e-6
    K[4:, 4:] = 0.0
    return wedge.with_structure(replace(wedge.structure, M=M, K=K))


@pytest.mark.parametrize("problem", [light_wedge(), three_mass_wedge()], ids=["light", "heavy"])
def test_the_plane_is_right_for_a_light_damper_only(problem):
    """Without inertia and other springs the normal forces are those of the plane, and nothing leaves its lines."""
    plane = force_plane(problem, ("D.x", "D.y"), ("blade 1", "blade 2"))
    samples = sample_cycles(response_samples(problem, [222.0], 1.0, 3, harmonics=15).dataset, 1.0)
    paths = paths_in(samples, plane)
    loads = np.stack([samples.force[:, samples.row(f"{side} n")] for side in plane.sides], axis=-1)
    error = float(np.abs(plane.normal(paths) - loads).max()) / 120.0
    assert error < 0.01 if problem.structure.M[4, 4] < 0.01 else error > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("quantity", "label"), [("mobility", "ω|X₁|/F in m/s per unit level"), ("acceleration", "ω²|X₁| in m/s²")]
)
def test_bounds_samples_and_percentiles_are_of_the_quantity(quantity, label):
    """At one frequency an amplitude is ω^k times that of the displacement, and per force level divided by it."""
    level, order = 0.5, {"mobility": 1, "acceleration": 2}[quantity]
    own, other = (
        response_bounds(three_mass_wedge(), [222.0], level, cloud=3, quantity=q).dataset for q in ("displacement", quantity)
    )
    factor = (2.0 * np.pi * 222.0) ** order / (level if quantity == "mobility" else 1.0)
    for name in ("amplitude", "sampled_amplitude"):
        np.testing.assert_allclose(other[name], factor * own[name], rtol=1e-6)
    figure = response_bounds(three_mass_wedge(), [215.0, 222.0], level, cloud=3, quantity=quantity).plot()
    assert " ".join(figure.axes[0].get_ylabel().split()) == f"amplitude {label}"
    table = bounds_table(other)
    assert table[f"upper amplitude [{other.amplitude.attrs['units']}]"][0] == float(other.amplitude[0, 1, 0])
    samples = response_samples(three_mass_wedge(), [222.0], level, 3, quantity=quantity)
    plain = response_samples(three_mass_wedge(), [222.0], level, 3)
    np.testing.assert_allclose(samples.percentiles(), plain.percentiles() * (2.0 * np.pi * 222.0) ** order, rtol=1e-12)
    assert samples.percentiles().attrs["units"] == ("m/s" if quantity == "mobility" else "m/s2")
    expected = {"mobility": "amplitude ω|X₁| in mm/s", "acceleration": "amplitude ω²|X₁| in m/s²"}[quantity]
    assert samples.plot().axes[0].get_ylabel() == expected
    assert response_percentiles(samples.dataset).panels[0].y.label == expected
    assert "% [m/s" in " ".join(percentiles_table(samples.dataset).columns)


def test_the_bounds_of_an_rms_are_at_least_those_of_its_samples():
    bounds = response_bounds(three_mass_wedge(), [222.0], 0.5, cloud=6, quantity="acceleration", measure="rms").dataset
    low, high = bounds.amplitude.values[0, :, 0]
    assert low <= float(bounds.sampled_amplitude.min())
    assert high >= float(bounds.sampled_amplitude.max())
    alone = response_bounds(three_mass_wedge(), [222.0], 0.5, cloud=6, quantity="acceleration").dataset.amplitude.values[0, 1, 0]
    assert high > alone / np.sqrt(2.0)
