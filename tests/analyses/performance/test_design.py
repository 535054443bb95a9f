"""Design of a damper: against a brute search, with constraints that bite, and the constraints against their closed forms."""

from math import pi, sqrt, tan

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.performance import design as design_module
from stickslip.analyses.performance import worst_case
from stickslip.analyses.performance.design import AllStarts, Designs, DesignSettings, design_ranges
from stickslip.analyses.performance.worst_case import LargestForce, NoJamming, NoLiftOff, Trial
from stickslip.show.plots.performance_curve import design_space
from stickslip.show.report.performance import design_failures as failures
from stickslip.show.report.performance import design_sentences as sentences
from stickslip.show.report.performance import design_tables as tables
from stickslip.solve.peaks import climb
from stickslip.solve.peaks.climb import NoPeakError

KD = 0.5


def one_mass(*, friction: float, load: float) -> ss.Problem:
    """Slip limit load x friction on a Jenkins spring, viscous damping ζ = 0.005."""
    return ss.rigs.single_mass(damping=0.01, kt=KD, limit=load * friction)


def small(**changed):
    settings = {"designs": 8, "refinements": 14, "starts": 0, "harmonics": 1, "samples": 256}
    settings |= {"force": (1.0, 1.0), "levels": 1, "friction": 0.4}
    return ss.damper_design(one_mass, {"load": (1.0, 8.0)}, **(settings | changed))


def test_known_friction_and_force_give_the_known_optimum():
    """μN/F = 1.47424, A = 5.870724: independent script of this project."""
    found = small(friction_factor=1.0, refinements=20)
    assert float(found.dataset.optimum_peak) == pytest.approx(5.870724, rel=1e-3)
    assert 0.4 * found.optimum["load"] == pytest.approx(1.47424, rel=0.03)
    assert np.all(np.abs(found.dataset.sensitivity[0] - 0.05) < 0.05)


@pytest.mark.nightly
def test_uncertain_friction_balances_both_ends():
    """Against a scan of solved peaks at μ/√2 and μ√2, the larger of which is least."""
    found = small(refinements=20)
    scan = np.linspace(2.5, 6.0, 36)
    ends = (0.4 * scan / sqrt(2.0), 0.4 * scan * sqrt(2.0))
    curve = ss.performance_curve(one_mass(friction=1.0, load=1.0), np.concatenate(ends), harmonics=1).dataset
    peaks = [np.interp(end, curve.force_ratio.values, curve.amplitude_per_force.values[0]) for end in ends]
    worst = np.max(peaks, axis=0)
    assert float(found.dataset.optimum_peak) == pytest.approx(worst.min(), rel=1e-2)
    assert found.optimum["load"] == pytest.approx(scan[int(np.argmin(worst))], rel=0.05)


def test_a_constraint_that_bites_moves_the_optimum_to_its_edge():
    found = small(friction_factor=1.0, constraints={"load": lambda trial: 1.0 - trial.variables["load"] / 3.0}, refinements=20)
    assert found.optimum["load"] == pytest.approx(3.0, rel=0.05)
    assert found.optimum["load"] < 3.0
    assert set(found.dataset.allowed.values.tolist()) == {0, 1}


@pytest.mark.parametrize("constraint", [lambda trial: -1.0, NoJamming(89.9)], ids=["solved", "not solved"])
def test_where_no_design_is_allowed_all_are_kept_and_there_is_no_optimum(constraint):
    """Hours of work are not thrown away, and nobody takes a forbidden design for the best one."""
    found = small(constraints={"impossible": constraint}, refinements=3)
    said = r"of \d+ designs must meet all constraints, but none does; the nearest, load = [\d.]+, breaks impossible"
    with pytest.raises(ss.InputError, match=said):
        _ = found.optimum
    dataset = found.dataset
    assert dataset.sizes["design"] >= 8
    assert not dataset.allowed.values.any()
    assert all(np.isnan(dataset[name].values).all() for name in ("optimum", "optimum_peak", "sensitivity", "near_low"))
    assert sentences(dataset) == [f"{dataset.sizes['design']} designs, {dataset.sizes['design']} of them break a constraint"]
    assert "must meet all constraints" in failures(dataset)[0]
    labels = [text.get_text() for text in found.plot().legends[0].get_texts()]
    assert labels == ["breaks a constraint"]


class Kept(dict):
    """Keeps results in memory, and counts what is asked for."""

    def load(self, name):
        return self.get(name)

    def save(self, name, arrays):
        assert name not in self
        self[name] = arrays


def test_designs_of_the_search_are_kept_too():
    """Those of differential evolution, of the simplex and around the optimum, and the searches of start states."""
    kept, asked = Kept(), {"generations": 1, "refinements": 4, "designs": 4, "starts": 1, "samples": 64, "friction_factor": 1.0}
    asked["search"] = False
    found = small(**asked, checkpoint=kept)
    assert len([name for name in kept if name.startswith("design at")]) >= found.dataset.sizes["design"] + 2
    assert any(name.startswith("all start states") for name in kept)
    again = Kept(kept)
    assert small(**asked, checkpoint=again).dataset.identical(found.dataset)
    assert len(again) == len(kept)


def one_level(make, level, **settings):
    """Settings of designs at one force level and friction coefficient, whose start states are not all searched."""
    met = {"friction_factor": 1.0, "search": False, "levels": 1, "designs": 4}
    return DesignSettings(make, {"load": (1.0, 8.0)}, (level, level), 0.4, **met | settings)


@pytest.mark.nightly
@pytest.mark.parametrize("side_by_side", [(2, 1), (1, 2)], ids=["designs", "searches"])
def test_designs_and_searches_of_their_start_states_are_the_same_side_by_side(side_by_side, monkeypatch):
    monkeypatch.setattr(design_module, "WORTH", 0.0)
    work = one_level(one_mass, 1.0, starts=1, harmonics=1, samples=64).work
    found = []
    for workers in ((1, 1), side_by_side):
        designs = Designs(work, [], None, workers[0], lambda fraction, text: None, 1)
        designs.at([[0.3], [0.6]])
        designs.workers = workers[1]
        starts = AllStarts(designs, work.conditions.frictions)
        starts.best(2)
        found.append((starts.each, [record.place for record in designs.records]))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])


def test_a_known_design_is_computed_once():
    found = small(known=[{"load": 2.0}, {"load": 2.0}], refinements=0)
    assert int(found.dataset.attrs["known"]) == 1
    assert np.count_nonzero(found.dataset.value.values == 2.0) == 1


@pytest.mark.nightly
def test_start_states_can_only_make_it_worse():
    def wedge(*, friction: float, angle: float) -> ss.Problem:
        return ss.rigs.blade_and_wedge(platform_angle=angle, mu=friction)

    sizes = []
    for starts in (0, 2):
        effort = {"levels": 1, "designs": 4, "refinements": 0, "starts": starts, "search": False, "harmonics": 1, "samples": 64}
        found = ss.damper_design(wedge, {"angle": (25.0, 40.0)}, (4.0, 4.0), 0.4, **effort)
        sizes.append(found.dataset.worst_peak.values)
    assert np.all(sizes[1] >= sizes[0])
    assert np.any(sizes[1] > 1.001 * sizes[0])


def test_constraints_against_closed_forms():
    wave = 100.0 + 60.0 * np.cos(np.linspace(0.0, 2.0 * pi, 64, endpoint=False))
    trial = Trial({"angle": 40.0}, 0.5, 1.0, {"left cylinder 1": wave, "left cylinder 2": wave, "left flat 1": 0.5 * wave})
    assert NoJamming("angle")(trial) == pytest.approx(1.0 - 0.5 * tan(40.0 * pi / 180.0))
    assert NoJamming(60.0)(Trial({}, 1.0 / tan(pi / 3.0), 1.0, {})) == pytest.approx(0.0, abs=1e-12)
    assert NoLiftOff()(trial) == pytest.approx(0.4)
    assert NoLiftOff(0.5)(trial) == pytest.approx(-0.1)
    assert LargestForce(200.0)(trial) == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"friction_factor": 0.5}, "friction_factor must be at least 1"),
        ({"force": (2.0, 1.0)}, "force must be"),
        ({"objective": "mass"}, "objective must be"),
        ({"designs": 1}, "designs must be at least 4"),
    ],
)
def test_wrong_input_is_said(changed, words):
    with pytest.raises(ss.InputError, match=words):
        small(**changed)


def test_the_stuck_blade_and_wedge_has_its_closed_form_frequency():
    """k_H = kt kn/(2 (kt sin²α + kn cos²α)) with a massless damper."""
    kt, kn, alpha = 8e5, 1.2e6, np.radians(35.0)
    stiffness = kt * kn / (2.0 * (kt * np.sin(alpha) ** 2 + kn * np.cos(alpha) ** 2))
    found = ss.rigs.blade_and_wedge(damper_mass=1e-7).frequencies(stuck=True)[0]
    assert found == pytest.approx(sqrt((2e6 + stiffness) / 0.5) / (2.0 * pi), rel=1e-6)


def test_a_design_that_jams_is_refused_before_it_is_computed():
    """At 60 degrees 1 − μ tan α is negative with μ = 0.6 and 1.2 alike: no problem is made beyond the check of the middle."""
    made = []

    def wedge(*, friction: float, angle: float) -> ss.Problem:
        made.append(angle)
        return ss.rigs.blade_and_wedge(platform_angle=angle, mu=friction)

    limits = {"no jamming": NoJamming("angle"), "no lift-off": NoLiftOff()}
    effort = {"levels": 1, "designs": 4, "refinements": 0, "starts": 0, "samples": 64}
    found = ss.damper_design(wedge, {"angle": (58.0, 65.0)}, (4.0, 4.0), 0.8, constraints=limits, **effort)
    assert failures(found.dataset)[0].endswith("breaks no jamming. Widen the variables or the constraints.")
    assert len(made) == 1


@pytest.mark.slow
def test_designs_without_a_peak_in_some_condition_are_named_and_come_last(monkeypatch):
    """Start states from which no peak is solved are failures of the design, by force level, friction and start."""

    def fails_with_much_friction(search, mu, level, start, *rest):
        if search.variables["load"] > 3.0:
            search.failed.append((level, mu, start))

    monkeypatch.setattr(worst_case._Search, "_from_start", fails_with_much_friction)
    found = small(friction_factor=1.0, designs=4, refinements=0, starts=1).dataset
    loads = found.value.values[:, 0]
    assert np.array_equal(found.failed.values > 0, loads > 3.0)
    assert found.optimum.values[0] < 3.0
    failed = found.isel(design=int(np.argmax(loads)))
    assert (failed.failed_force.values[0], failed.failed_friction.values[0], failed.failed_start.values[0]) == (1.0, 0.4, 1.0)
    assert any(
        f"load = {loads.max():.4g}: no peak solved at force level 1 with friction 0.4" in words for words in failures(found)
    )
    assert "only where a peak was solved" in sentences(found)[-1]
    assert set(tables(found)["designs"]["constraints"]) == {"met", "met where a peak was solved"}


def test_no_design_is_computed_twice():
    value = small(friction_factor=1.0).dataset.value.values[:, 0]
    assert np.unique(value).size == value.size


def test_a_peak_is_followed_to_a_drawn_start_state_where_no_curve_of_it_can_be_solved(monkeypatch):
    """The way there in steps ends on the peak that the leap finds where it succeeds, but for another cusp of the samples."""
    conditions = one_level(one_mass, 8.0, starts=1, harmonics=3, samples=128).conditions

    met, shares, sizes = worst_case._Search._met, [], {}

    def kept(search, mu, level, start, peak, balance):
        sizes[start] = peak.amplitude
        met(search, mu, level, start, peak, balance)

    monkeypatch.setattr(worst_case._Search, "_met", kept)

    def worst():
        sizes.clear()
        found = worst_case.worst_case(lambda mu: ss.rigs.blade_and_wedge(mu=mu), {}, conditions, {})
        return found.failed, sizes.get(1)

    def without(lost):
        def followed(solver_at, known):
            def at(share):
                shares.append(share)
                if len(shares) <= lost:
                    raise NoPeakError
                return solver_at(share)

            return climb.followed(at, known)

        return followed

    failed, leapt = worst()
    assert failed == ()
    monkeypatch.setattr(worst_case._Search, "_swept", lambda *_: None)
    monkeypatch.setattr(worst_case._Search, "_climbed", lambda *_: None)
    monkeypatch.setattr(worst_case, "followed", without(1))
    failed, followed = worst()
    assert shares == [0.25, 0.125, 0.25, 0.5, 1.0]
    assert failed == ()
    assert followed == pytest.approx(leapt, rel=60.0 / 128**2)
    monkeypatch.setattr(worst_case, "followed", without(np.inf))
    assert worst() == (((8.0, 0.4, 1),), None)


def test_known_designs_are_computed_first_and_compared():
    found = small(friction_factor=1.0, known=[{"load": 7.0}], refinements=4).dataset
    assert found.value.values[0] == pytest.approx([7.0])
    assert found.attrs["known"] == 1
    assert found.sizes["design"] > 9
    compared = next(line for line in sentences(found) if "known design load = 7" in line)
    assert f"{100.0 * (1.0 - float(found.optimum_peak / found.worst_peak[0])):.0f} % lower" in compared
    labels = list(design_space(found).entries)
    assert "known design" in labels


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ([{"load": 9.0}], r"known\[0\], load must be 1 to 8, but is 9"),
        ([{"mass": 2.0}], r"known\[0\] must give load, and nothing else"),
        ({"load": 2.0}, "known must be"),
        ([{"load": 2.0}, 2.0], r"known\[1\] must give load"),
        ([{"load": float("nan")}], r"known\[0\], load must be"),
    ],
)
def test_wrong_known_designs_are_said(known, words):
    with pytest.raises(ss.InputError, match=words):
        small(known=known)


def edge_of_jamming():
    class Edge(NoJamming):
        def __call__(self, trial):
            return 1.0 if trial.variables["load"] <= 3.0 else -1.0

    return one_mass, {"edge": Edge()}


def edge_of_what_can_be_made():
    def cannot(*, friction, load):
        if 3.0 < load < 4.0:
            raise ValueError("too much load")
        return one_mass(friction=friction, load=load)

    return cannot, {}


@pytest.mark.parametrize("edge", [edge_of_jamming, edge_of_what_can_be_made])
def test_beside_what_cannot_be_there_is_one_slope_and_the_range_ends(edge):
    """The slope of the worst-case peak towards smaller loads is that of two designs; there is none to the other side."""
    make, constraints = edge()
    work = one_level(make, 1.0, starts=0, constraints=constraints, harmonics=1).work
    designs = Designs(work, [], None, 1, lambda fraction, text: None, 1)
    at, below = designs.solved_where_possible([np.array([load]) for load in (3.0, 2.86)])
    found, size = design_ranges(designs, at), float(at.place[0])
    rise = (float(below.place[0]) - size) / size
    assert found.slopes[0, 0] == pytest.approx(rise / (0.14 / 3.0), rel=1e-9)
    assert np.isnan(found.slopes[0, 1])
    assert found.high == pytest.approx([3.0])
    assert 1.0 < found.low[0] < 3.0


def test_slopes_to_both_sides_and_the_range_are_those_of_the_problem():
    """Of μ uncertain by two, the larger of a falling and a rising peak: one mass, solved independently, gives the worst-case peak
    at most 5 % higher for limits of 1.478 to 1.706, whatever designs the search saw.
    """
    found = small(refinements=20).dataset
    assert 0.4 * found.near_low.values[0] == pytest.approx(1.478, abs=0.005)
    assert 0.4 * found.near_high.values[0] == pytest.approx(1.706, abs=0.005)
    less, more = found.sensitivity.values[0]
    assert min(less, more) > 0.3
    line = next(line for line in sentences(found) if "  load = " in line)
    assert f"1 % less: {less:+.2g} %, 1 % more: {more:+.2g} %" in line


def test_a_variable_that_does_nothing_may_be_anything_and_slopes_stay_within_the_box():
    """The box ends below the optimum at 3.69, so the best design is at its end, and beyond it no problem is asked for."""

    def make(*, friction, load, idle):
        assert 1.0 <= load <= 3.0
        assert -2.0 <= idle <= 5.0
        return one_mass(friction=friction, load=load)

    settings = {"designs": 4, "refinements": 12, "starts": 0, "levels": 1, "friction_factor": 1.0, "harmonics": 1}
    known = [{"load": 3.0, "idle": 5.0}]
    found = ss.damper_design(make, {"load": (1.0, 3.0), "idle": (-2.0, 5.0)}, (1.0, 1.0), 0.4, known=known, **settings).dataset
    assert found.optimum.values == pytest.approx([3.0, 5.0])
    assert np.isnan(found.sensitivity.values).tolist() == [[False, True], [False, True]]
    assert found.sensitivity.values[0, 0] > 0.01
    assert found.sensitivity.values[1, 0] == pytest.approx(0.0, abs=1e-9)
    assert (found.near_low.values[1], found.near_high.values[1]) == (-2.0, 5.0)
    lines = sentences(found)
    assert any("its whole range, -2 to 5, stays within 5 %" in line for line in lines)
    assert any("it is the best" in line for line in lines)
    assert any("more: not allowed" in line for line in lines)


@pytest.mark.parametrize("search", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_the_best_design_is_that_with_the_lowest_peak_over_all_start_states(monkeypatch, search):
    """With a made-up search that finds the more, the higher the slip limit; sampled peaks alone favour another design, and those
    that cannot be the best are not searched.
    """
    calls = []

    def made_up(problem, level, conditions):
        calls.append(level)
        return made_up_at(problem.contacts[0].law.normal_load)

    monkeypatch.setattr(worst_case, "searched_peak", made_up)
    monkeypatch.setattr(design_module, "searched_peak", made_up)
    settings = {"designs": 8, "refinements": 4, "starts": 1, "samples": 64, "known": [{"load": 2.5}, {"load": 7.0}]}
    found = small(search=search, **settings).dataset
    loads = found.value.values[:, 0]
    over_all = np.max([found.sampled_peak.values, *(made_up_at(mu * loads) for mu in found.frictions)], axis=0)
    best = int(found.optimum_design)
    assert best == int(np.argmin(over_all))
    assert float(found.optimum_peak) == pytest.approx(over_all[best])
    assert np.all(found.searched_peak.values[:2] == over_all[:2])
    assert np.array_equal(np.isfinite(found.searched_peak.values), found.searches.values > 0)
    if not search:
        assert best != int(np.argmin(found.worst_peak.values))
        assert len(calls) < 3 * loads.size
    compared = next(line for line in sentences(found) if "known design load = 7" in line)
    assert f"the best is {100.0 * (1.0 - over_all[best] / over_all[1]):.0f} % lower" in compared
    assert "over all start states" in compared
    assert "over all start states, where searched [m]" in tables(found)["designs"]


def made_up_at(limit):
    return 9.0 * np.maximum(limit, 1.0) + 4.0 * limit


def test_friction_is_no_variable():
    with pytest.raises(ss.InputError, match=r"variables must not hold friction.*within `friction_factor`"):
        ss.damper_design(one_mass, {"friction": (0.2, 0.4)}, (1.0, 1.0), 0.4, levels=1)


def test_a_constraint_that_fails_is_named():
    with pytest.raises(
        ss.InputError, match=r"Constraint 'clearance' must return a number, but raises ZeroDivisionError at load="
    ):
        small(constraints={"clearance": lambda trial: 1 / 0})


def sharp_at_the_edge(*, friction: float, load: float) -> ss.Problem:
    """The optimum lies near the end of the box, where the problem cannot be made."""
    if load >= 3.0:
        raise ValueError("too much")
    return one_mass(friction=friction, load=load)


def test_a_search_goes_on_where_a_design_at_the_edge_cannot_be_made():
    found = ss.damper_design(
        sharp_at_the_edge,
        {"load": (1.0, 3.0)},
        (1.0, 1.0),
        0.4,
        friction_factor=1.0,
        levels=1,
        designs=4,
        refinements=12,
        starts=0,
        harmonics=1,
    )
    assert 2.8 < found.optimum["load"] < 3.0


def test_what_is_kept_belongs_to_the_problem_that_made_it():
    """Two functions of one name, as after an edit: nothing of the one is given to the other."""
    kept = Kept()

    def optimum(damping):
        def made(*, friction: float, load: float) -> ss.Problem:
            return ss.rigs.single_mass(damping=damping, kt=KD, limit=load * friction)

        effort = {"levels": 1, "designs": 4, "refinements": 0, "starts": 0, "harmonics": 1, "samples": 64}
        return float(
            ss.damper_design(made, {"load": (1.0, 8.0)}, (1.0, 1.0), 0.4, checkpoint=kept, **effort).dataset.optimum_peak
        )

    assert optimum(0.05) < 0.9 * optimum(0.01)
