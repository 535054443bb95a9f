"""The table with which a report without response curves opens: the numbers of the result, and no sentence that repeats a row."""

import re

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.damper_alone.cycle import damper_cycle, damper_evolution, steady_cycles
from stickslip.model.dampers import in_phase, out_of_phase
from stickslip.model.rigs import laboratory_damper
from stickslip.show.plots.damper_cycle import damper_cycles
from stickslip.show.report import page
from stickslip.show.report.free_decay import stepped_tables
from stickslip.show.report.markup import NOT_ESTIMATED, Charts, Presentation, presentation_of, presentations
from stickslip.show.report.page import overview


def shown(analysis, dataset):
    """As a study reports its result: headline, numbers in the rows of the table, and the items of the list below the chart."""
    html = overview({"a": dataset.assign_attrs(analysis=analysis)}, Charts(["a"]))
    rows = re.findall(r"<tr>(.*?)</tr>", html.partition("<tbody>")[2].partition("</tbody>")[0])
    cells = [[float(value) for value in re.findall(r'data-value="([^"]+)"', row)] for row in rows]
    return re.search(r'class="headline">(.*?)</p>', html)[1], cells, re.findall(r"<li>(.*?)</li>", html)


def damper():
    return laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32))


def test_a_cycle_opens_with_its_contacts():
    dataset = damper_cycle(damper(), in_phase(30e-6), steps=100).dataset
    headline, cells, items = shown("damper_cycle", dataset)
    assert headline.startswith(f"{1e6 * float(dataset.loop_energy):.4g} µJ a cycle")
    assert np.array(cells)[:, 0] == pytest.approx(1e6 * dataset.friction_work.values)
    assert np.array(cells)[:, 1:4] == pytest.approx(100.0 * dataset.share.values)
    assert np.array(cells)[:, 4] == pytest.approx(dataset.normal_force.max("sample").values)
    assert not [item for item in items if item.startswith(("L1", "L2", "R"))]


def test_several_cycles_open_with_a_row_each():
    evolution = damper_evolution(damper(), out_of_phase(20e-6), [0.3, 0.9], steps=100).dataset
    starts = steady_cycles(damper(), out_of_phase(0.3e-6), starts=3, steps=100).dataset
    begins = {"damper_evolution": "2 cycles, ", "steady_cycles": f"{starts.sizes['cycle']} steady cycle"}
    for (analysis, begin), dataset in zip(begins.items(), (evolution, starts), strict=True):
        headline, cells, items = shown(analysis, dataset)
        assert headline.startswith(begin)
        assert [row[0] for row in cells] == list(dataset.cycle.values)
        assert [row[1] for row in cells] == pytest.approx(1e6 * dataset.loop_energy.values, abs=1e-6)
        assert not [item for item in items if item.startswith("cycle ")]


def test_an_evolution_names_its_jammed_cycles_and_does_not_call_one_cycle_a_failure():
    """With one cycle for each friction none can be steady; that some jam is said beside what was computed."""
    dataset = damper_evolution(damper(), out_of_phase(20e-6), [0.3, 1.2], cycles=1, steps=100).dataset
    assert list(dataset["outcome"].values) == ["not_steady", "jammed"]
    results = {"a": dataset.assign_attrs(analysis="damper_evolution")}
    html = overview(results, Charts(["a"])) + page.failures(results, Charts(["a"]))
    assert "1 of them jammed (µ = 1.2)" in html
    assert ">after 1 cycle</td>" in html
    assert ">jammed</td>" in html
    assert "Nothing failed" not in html
    assert "not steady" not in html


def test_dwells_that_do_not_settle_are_named_as_they_lie():
    """Going up and back, settled ones between others: no range includes them, and a distance of 12.3 is 1230 %."""
    frequencies = [14.0, 15.0, 16.0, 17.0, 18.0, 17.0, 16.0, 15.0]
    dwells = ss.stepped_sine(one_mass(friction=1.0, load=1.0), frequencies, 4.0, 2, steps_per_period=50).dataset
    dwells["distance"] = "step", np.array([12.3, np.inf, 1e-4, 2e-2, 1e-9, 0.0, 0.5, 1e-5])
    headline, _, _ = shown("stepped_sine", dwells)
    assert "4 end within 0.1 % of the steady motion" in headline
    assert "The others (upwards 14.00 to 15.00, 17.00 Hz; downwards 16.00 Hz) do not" in headline
    every = stepped_tables(dwells)["dwells"]["estimated distance from the steady motion [%]"]
    assert every[0] == pytest.approx(1230.0)
    assert every[3] == pytest.approx(2.0)


@pytest.mark.parametrize("name", ["tip", "harmonic"])
def test_a_row_is_not_known_by_its_words(name):
    """An output that has the name with which other sentences begin: all of these stay, its own row does not."""
    structure = ss.Structure(np.eye(1), np.array([[1e4]]), ("1.x",), C=np.array([[4.0]]))
    contact = ss.Contact("slider", ss.Macroslip(2e3, 1.0, normal_load=1.0), ({"1.x": 1.0},))
    problem = ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), (ss.Output(name, {"1.x": 1.0}),), "One mass")
    test = ss.stepped_sine(problem, [15.0, 16.0], 4.0, 5, steps_per_period=200)
    beside = test.with_response(ss.forced_response(problem, [15.0, 16.0], 4.0, harmonics=3))
    _, cells, items = shown("stepped_sine", beside.dataset)
    assert len(cells) == 1
    assert len([item for item in items if item.startswith("harmonic balance: ")]) == 2
    assert not [item for item in items if item.startswith(f"{name}: ") and "highest amplitude" in item]


def one_mass(*, friction: float, load: float) -> ss.Problem:
    return ss.rigs.single_mass(damping=0.01, kt=0.5, limit=load * friction)


def test_a_design_opens_with_its_variables_beside_the_known_design():
    settings = {"designs": 4, "refinements": 6, "starts": 0, "harmonics": 1, "samples": 64, "friction": 0.4, "levels": 1}
    found = ss.damper_design(
        one_mass, {"load": (1.0, 8.0)}, force=(1.0, 1.0), friction_factor=1.0, known=[{"load": 7.0}], **settings
    )
    headline, cells, items = shown("damper_design", found.dataset)
    near = [float(found.dataset[f"near_{end}"].values[0]) for end in ("low", "high")]
    changes = found.dataset.sensitivity.values[0]
    assert cells == [pytest.approx([found.optimum["load"], 7.0, *near, *changes])]
    lower = 100.0 * (1.0 - float(found.dataset.optimum_peak / found.dataset.worst_peak[0]))
    assert f"{lower:.0f} % lower than the known design" in headline
    assert not [item for item in items if item.startswith("load")]


def test_a_design_without_an_optimum_opens_without_a_table():
    found = ss.damper_design(
        one_mass,
        {"load": (1.0, 8.0)},
        force=(1.0, 1.0),
        friction=0.4,
        friction_factor=1.0,
        levels=1,
        designs=4,
        refinements=2,
        starts=0,
        harmonics=1,
        samples=64,
        constraints={"impossible": lambda trial: -1.0},
    )
    headline, cells, _ = shown("damper_design", found.dataset)
    assert "break a constraint" in headline
    assert cells == []


def test_warnings_of_curves_stand_before_the_chart(monkeypatch):
    """As speed sweeps and nonlinear modes word them on the console, behind the numbers."""
    lines = ["highest peak 1 mm", "  curve 1: 1 mm", "  warning, curve 1: Too few samples. Take 512."]
    shown = Presentation("Curves", lambda _: lines, lambda _: {"damper_cycles": damper_cycles}, lambda _: {})
    monkeypatch.setattr(page, "presentation_of", lambda _: shown)
    dataset = steady_cycles(damper(), out_of_phase(0.3e-6), starts=1, steps=50).dataset
    html = overview({"a": dataset}, Charts(["a"]))
    warning = '<details class="warning"><summary>Curve 1: Too few samples.</summary>Take 512.</details>'
    assert html.index(warning) < html.index('class="place"') < html.index("<li>curve 1: 1 mm</li>")


def test_every_page_says_how_sure_it_is():
    """An analysis shows an error, or is among those that say why there is none: below the answer, and on the console."""
    shows_errors = {"campbell", "contact_law", "decay_prediction", "forced_response", "identification", "measured_decay"}
    shows_errors |= {"response_bounds", "response_identification", "response_prediction"}
    assert set(NOT_ESTIMATED) == set(presentations()) - shows_errors
    cycle = damper_cycle(damper(), in_phase(30e-6), steps=100).dataset.assign_attrs(analysis="damper_cycle")
    said = "The error of the time steps is not estimated: double `steps` to see it"
    assert presentation_of(cycle).sentences(cycle)[-1] == said
    html = overview({"a": cycle}, Charts(["a"]))
    assert html.count(f'<p class="note">{said}.</p>') == 1
    assert html.index("</table>") < html.index(said) < html.index('class="place"')
