"""Forty cases: every figure stays on a page with a short legend and without a warning, and the summary is a few lines."""

import pkgutil
import re
from importlib import import_module

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from report.pages import Page
from report.synthetic import synthetic

import stickslip as ss
from stickslip import analyses, laboratory
from stickslip.analyses.stress import with_fatigue
from stickslip.model.structure.stress import COMPONENTS
from stickslip.results.files import SavedResult
from stickslip.results.schema import Result
from stickslip.results.view import representatives, spread
from stickslip.show.plots.look import MOST_ENTRIES, PAGE
from stickslip.show.plots.response_curves import haigh_diagram, stress_curves
from stickslip.show.report.page import page
from stickslip.show.report.responses import figures_of, sentences
from stickslip.show.report.sections import MOST_SHOWN

MANY = 40
BESIDE_CASES = 5  # further entries of a legend: linear curves, failures, "others"


def levels(count: int = MANY) -> xr.Dataset:
    return synthetic(tuple(np.geomspace(1.0, 80.0, count).tolist()), failed=((3, 40, 2),))


def cloud() -> xr.Dataset:
    """Two force levels from twenty start states each; one state of the second level has no solution."""
    data = synthetic((20.0, 80.0)).isel(case=np.repeat([0, 1], 20)).copy(deep=True)
    size = np.tile(1.0 + 0.01 * np.random.default_rng(0).permutation(20), 2)
    for name in ("amplitude", "peak_amplitude"):
        data[name] = data[name] * xr.DataArray(size, dims="case")
    data["outcome"][39] = np.where(data["outcome"][39] == 1, 2, 0)
    return data.assign_coords(start=("case", np.tile(np.arange(20), 2))).assign(
        start_variable=(("case", "variable"), size[:, None])
    )


def repeated(data: xr.Dataset, axis: str = "case") -> xr.Dataset:
    """The same case many times, its force levels apart."""
    data = data.isel({axis: [0] * MANY})
    return data.assign_coords(force_level=(axis, np.geomspace(1.0, 80.0, MANY))) if "force_level" in data.coords else data


def bounds() -> xr.Dataset:
    return repeated(ss.response_bounds(ss.rigs.three_mass_wedge(), [215.0, 222.0], cloud=2, starts=1).dataset)


def percentiles() -> xr.Dataset:
    data = ss.response_samples(ss.rigs.three_mass_wedge(), [215.0, 222.0], starts=2).dataset
    data = data.isel(case=[0, 1] * (MANY // 2))
    return data.assign_coords(force_level=("case", np.repeat(np.geomspace(1.0, 80.0, MANY // 2), 2)))


def performance() -> xr.Dataset:
    return repeated(ss.performance_curve(ss.rigs.blade_and_wedge(), [10.0, 20.0], friction=0.4, harmonics=1).dataset)


def controlled() -> xr.Dataset:
    data = ss.controlled_response(ss.rigs.single_mass(), ss.hertz(0.1, 0.3), 1.0, harmonics=1, samples=64).dataset
    return data.isel(case=[0] * MANY).assign_coords(held_amplitude=("case", np.geomspace(1.0, 80.0, MANY), {"units": "m/s2"}))


def response_identification() -> xr.Dataset:
    curve = ("test", "point"), np.broadcast_to(1.0 + np.arange(32.0), (MANY, 32))
    names = ("frequency", "measured", "computed", "measured_phase", "computed_phase")
    data = dict.fromkeys(names, curve) | {name: (("test",), np.ones(MANY)) for name in ("misfit", "held_out")}
    data |= {"value": ("parameter", [1.0]), "low": ("parameter", [0.9]), "high": ("parameter", [1.1])}
    coords = {"test": [f"test {k}" for k in range(MANY)], "parameter": ["kt"]}
    return xr.Dataset(data, coords | {"quantity": ("test", ["acceleration"] * MANY)})


def response_prediction() -> xr.Dataset:
    frequency = ("level", "point"), np.broadcast_to(1.0 + np.arange(32.0), (MANY, 32))
    one = ("level",), np.ones(MANY), {"units": "m/s2"}
    data = {"frequency": frequency} | {f"amplitude{end}": (*frequency, {"units": "m/s2"}) for end in ("", "_low", "_high")}
    data |= {f"peak_{key}{end}": one for key in ("amplitude", "frequency") for end in ("", "_low", "_high")}
    coords = {"level": ("level", np.geomspace(1.0, 80.0, MANY), {"units": "N", "long_name": "force level"})}
    return xr.Dataset(data, coords, {"quantity": "acceleration", "held": "force", "draws": 40})


def history() -> xr.Dataset:
    return repeated(ss.response_history(ss.rigs.three_mass_wedge(), [222.0], [1.0]).dataset, "run").assign_coords(
        force_level=("run", [1.0] * MANY)
    )


def identification() -> xr.Dataset:
    loop = np.cos(2.0 * np.pi * np.arange(32) / 32)
    shape = (MANY, 2, 32)
    data = {name: (("case", "channel", "sample"), np.broadcast_to(loop, shape)) for name in ("measured", "fitted")}
    data |= {"zero": (("case", "channel"), np.zeros((MANY, 2)))}
    data |= {"platform_motion": (("case", "axis", "sample"), np.broadcast_to(loop, shape))}
    names = [f"case {k}" for k in range(MANY)]
    return xr.Dataset(data, {"case": names, "channel": ["force_x", "force_y"]})


def contact_law() -> xr.Dataset:
    loop = np.broadcast_to(np.cos(2.0 * np.pi * np.arange(32) / 32), (MANY, 32))
    data = dict.fromkeys(("displacement", "force_measured", "force_fitted"), (("loop", "sample"), loop))
    of_cycles = ("kt", "kt_error", "mu", "mu_error", "number")
    data |= {f"cycle_{name}": (("cycle",), np.arange(1.0, MANY + 1.0)) for name in of_cycles}
    data |= {name: (("cycle",), np.ones(MANY)) for name in ("plateau", "energy_measured", "energy_fitted")}
    data |= {name: (("law",), np.ones(2)) for name in ("misfit", "held_out")}
    names = [f"cycle {k}" for k in range(MANY)]
    return xr.Dataset(data, {"loop": names, "law": ["jenkins", "iwan"]}, attrs={"best": "iwan"})


def rounds() -> xr.Dataset:
    loop = np.broadcast_to(np.cos(2.0 * np.pi * np.arange(32) / 32)[:, None], (MANY, 32, 2))
    data = dict.fromkeys(("platform_motion", "force_on_right"), (("cycle", "sample", "axis"), loop))
    data |= {name: (("cycle",), np.ones(MANY)) for name in ("loop_energy", "rotation")}
    return xr.Dataset(data | {"friction": (("cycle", "contact"), np.full((MANY, 3), 0.4))}, attrs={"title": "rounds"})


def modes() -> xr.Dataset:
    return repeated(ss.nonlinear_modes(ss.rigs.single_mass(), amplitude=(0.9, 3.0), harmonics=1, samples=64).dataset)


def limit_cycles() -> xr.Dataset:
    return repeated(ss.limit_cycles(ss.rigs.single_mass(), -0.05, amplitude=(0.9, 3.0), harmonics=1, samples=64).dataset)


def speed_sweep() -> xr.Dataset:
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), 0.1 * np.eye(1))
    slider = ss.Contact("slider", ss.Macroslip(kt=0.3, mu=0.5, normal_load=1.0), tangential=(ss.between("1.x", "ground"),))
    speed = ss.SpeedDependence(2, 0.5 * np.eye(1))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",), speed=speed)
    return repeated(ss.speed_sweep(problem, (3.0, 9.0), [1, 2], harmonics=1, samples=64).dataset)


OF_MANY = {
    "ForcedResponse": levels,
    "ResponseSamples": percentiles,
    "ResponseBounds": bounds,
    "ControlledResponse": controlled,
    "ResponseIdentification": response_identification,
    "ResponsePrediction": response_prediction,
    "ResponseHistory": history,
    "PerformanceCurve": performance,
    "NonlinearModes": modes,
    "LimitCycles": limit_cycles,
    "SpeedSweep": speed_sweep,
    "Identification": identification,
    "ContactLaw": contact_law,
    "SteadyCycles": rounds,
    "DamperEvolution": rounds,
}
OF_ONE = {
    *("NodalDiameters", "ContactStiffness", "PerformanceBand", "DamperCycle", "TimeResponse"),
    *("DamperDesign", "SensitivityIndices", "MistunedPopulation", "PhaseResonance", "DampingByNodalDiameter", "Campbell"),
    *("InterferenceDiagram", "RunUp", "FreeDecay", "MeasuredDecay", "SteppedSine", "DecayPrediction"),
}
"""Their figures have no axis of cases."""
DRAWN_ON_EVERY_CHANGE = {"ForcedResponse", "ContactLaw"}
NOT_DRAWN = {"posterior", "stress", "haigh"}
"""Of one case, with arguments of their own; of stress, which `test_stress_at_forty_places` draws."""


def assert_fits_a_page(figure: Figure) -> None:
    """Drawing is part of the test: warnings are errors."""
    assert max(figure.get_size_inches()) <= PAGE + 1e-9
    for legend in [axes.get_legend() for axes in figure.axes] + figure.legends:
        assert legend is None or len(legend.get_texts()) <= MOST_ENTRIES + BESIDE_CASES
    figure.draw_without_rendering()
    for axes in figure.axes:
        box = axes.get_window_extent()
        assert min(box.width, box.height) > 0.02 * figure.bbox.width


def classes() -> dict[str, type[Result]]:
    """Every class of results, found by importing all analyses and identifications."""
    for room in (analyses, laboratory):
        for module in pkgutil.walk_packages(room.__path__, f"{room.__name__}."):
            import_module(module.name)
    kinds = {*Result.__subclasses__(), *SavedResult.__subclasses__()} - {SavedResult}
    return {found.__name__: found for found in kinds if found.__module__.startswith("stickslip.")}


def test_every_figure_is_tried():
    assert {*OF_MANY} | OF_ONE == {*classes()}


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", [kind if kind in DRAWN_ON_EVERY_CHANGE else pytest.param(kind, marks=pytest.mark.nightly) for kind in OF_MANY]
)
def test_forty_cases_fit_a_page(kind):
    data = OF_MANY[kind]()
    result = type(kind, (Result,), {"dataset": data})()
    assert "" in result.figures
    for figure in {*result.figures} - NOT_DRAWN:
        assert_fits_a_page(result.plot(figure))


PARTS_ALONE = {"ResponseIdentification", "ResponsePrediction", "Identification", "ContactLaw", "SteadyCycles", "DamperEvolution"}
"""Of these only what figures read is made up."""


@pytest.mark.parametrize("kind", sorted({*OF_MANY} - PARTS_ALONE))
def test_every_result_prints(kind):
    data = OF_MANY[kind]()
    result = type(kind, (Result,), {"dataset": data})()
    lines = str(result).splitlines()
    assert 2 <= len(lines) <= 2 * MANY + 2
    assert not any(re.search(r"\bnan\b", line) for line in lines)


@pytest.mark.nightly
@pytest.mark.parametrize("data", [levels(), cloud()], ids=["levels", "cloud"])
def test_forty_curves_fit_a_page(data):
    for name, draw in figures_of(data).items():
        chart = draw(data)
        assert_fits_a_page(chart.plot())
        if name in ("loops", "states"):
            assert "of 20 start states those with" in chart.note or " of 40 force levels" in chart.note


@pytest.mark.slow
def test_stress_at_forty_places():
    data = levels()
    stress = data["amplitude"].isel(output=0).expand_dims(place=MANY, axis=-1) * np.linspace(1e9, 2e12, MANY)
    data = data.assign(stress_von_mises=stress).assign_coords(place=[f"place {k}" for k in range(MANY)])
    figure = stress_curves(data).plot()
    assert_fits_a_page(figure)
    assert figure.axes[-1].get_title(loc="left") == "place 39"
    assert "4 of 40 places, the most stressed" in figure.get_suptitle().lower()
    mean = xr.zeros_like(stress).expand_dims(component=list(COMPONENTS), axis=-1)
    data = with_fatigue(data.assign(stress_alternating=stress, stress_mean=mean), ss.FatigueLimit(4e8, 9e8))
    assert_fits_a_page(haigh_diagram(data).plot())


def test_a_cloud_is_represented_by_its_lowest_median_and_highest():
    data = cloud()
    chosen = representatives(data, 6)
    sizes = data["peak_amplitude"].values[:, 0, 0]
    order = np.argsort(sizes[:20])
    assert chosen.cases[:3] == [order[0], order[10], order[19]]
    assert 39 not in chosen.cases
    assert chosen.words == "of 20 start states those with the lowest, median and highest response"
    assert representatives(data, 40).words == ""
    assert representatives(levels(), 8).words == "8 of 40 force levels"


def test_the_level_of_the_largest_response_is_among_those_shown():
    """It was left out of the first table where it stood between the levels that are evenly spread."""
    data = levels()
    highest = int(np.nanargmax(np.nanmax(data["amplitude"].values, axis=(1, 2))))
    place = next(k for k in range(40) if k not in spread(40, 8))
    order = np.arange(40)
    order[[place, highest]] = order[[highest, place]]
    chosen = representatives(data.isel(case=order), 8)
    assert place in chosen.cases
    assert len(chosen.cases) == 8


def test_places_are_spread():
    assert spread(40, 4) == [0, 13, 26, 39]
    assert [spread(3, 5), spread(0, 3), spread(7, 1)] == [[0, 1, 2], [], [6]]


def test_the_summary_is_a_few_lines():
    lines = sentences(cloud())
    assert len(lines) == 1 + 2 * 4
    assert lines[1] == "  force × 20, 20 start states, 20 of them solved"
    assert [line.split()[0] for line in lines[2:5]] == ["lowest", "median", "highest"]
    assert lines[5] == "  force × 80, 20 start states, 19 of them solved"
    *found, rest, lifting = sentences(levels())
    assert rest == "  12 of 40 force levels; the report shows all"
    assert lifting.startswith("Detached curves were not sought")
    assert len(found) == 13


@pytest.mark.nightly
@pytest.mark.parametrize("data", [levels(), cloud()], ids=["levels", "cloud"])
def test_the_report_shows_a_few_of_many(data):
    text = page({"many": data})
    shown = Page(text)
    curves, loops, states = (next(iter(shown.charts(f"chart-{name}").values())) for name in ("curves", "loops", "states"))
    assert len({trace["yaxis"] for trace in states["data"]}) <= MOST_SHOWN
    assert len(loops["data"]) <= MOST_SHOWN
    assert 2 <= sum(trace["showlegend"] for trace in curves["data"]) <= MOST_ENTRIES + BESIDE_CASES
    peaks = text.split('id="peaks-section"')[1].split("<section")[0]
    assert 2 <= len(re.findall("<li>", peaks)) <= MOST_SHOWN
    assert "Shown: " in peaks
