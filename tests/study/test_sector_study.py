"""A sector of the user's own disk in a study: the same problem as in Python, what is refused, and what is said of it."""

import re

import numpy as np
import pytest
from each import each

import stickslip as ss
from stickslip.cli import main
from stickslip.model.readers.read import read_model
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation import continuation
from stickslip.study import job, read
from stickslip.study.run_time import model_summary
from stickslip.study.templates import write_new
from stickslip.support.checks import InputError


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The template's study with the model of a sector beside it."""
    folder = tmp_path_factory.mktemp("disk")
    write_new("bladed_disk", folder / "wheel.toml")
    return folder


@pytest.fixture(scope="module")
def study(folder):
    return read(folder / "wheel.toml")


def changed(folder, *pairs):
    text = (folder / "wheel.toml").read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return job(text, folder, "wheel")


def in_python(folder, **options):
    """The problem of the template, written with the functions of the package."""
    tip = re.search(r"tip = (\[.*?\])", (folder / "wheel.toml").read_text())[1]
    keep = {"tip": [float(c) for c in tip.strip("[]").split(",")], "R": "PLATFORM_RIGHT", "L": "PLATFORM_LEFT"}
    disk = ss.read_sector(
        folder / "wheel_sector.npz",
        names=folder / "wheel_sector.csv",
        units="mm-t-s",
        sectors=12,
        faces=("LOW", "HIGH"),
        keep=keep,
        modes=12,
        **options,
    )
    wedge = ss.RigidBody(1.2e-2, np.diag([6e-7, 6e-7, 5e-7]), (0.117, 0.03135, 0.0))
    whole = ss.with_bodies(disk, {"wedge": wedge.structure()}).with_damping(ss.ModalDamping(1e-3))
    law = ss.Macroslip(kt=40e6, kn=60e6, mu=0.3)
    right = ss.NodeSurface.of(disk, "R", opposite=wedge.centre)
    left = ss.NodeSurface.of(disk, "L", towards=(-1.0, 0.0, 0.0)).following(disk)
    contacts = [
        contact
        for name, surface in (("right", right), ("left", left))
        for contact in ss.surface_contacts(name, law, surface, lambda point: wedge.at(point, "wedge"), points=6)
    ]
    forces = (
        ss.Force("tip.y", 1.0),
        *(ss.Force(f"wedge/centre.{axis}", static=pull) for axis, pull in (("x", 386.4), ("y", 103.5))),
    )
    springs = (ss.Spring({"wedge/centre.z": 1.0}, 1e4),)
    return ss.TunedDisk(whole, contacts, forces, ("tip.y",), mean_springs=springs, engine_order=3)


def test_a_study_is_the_problem_of_python(folder, study):
    """Matrices, contact rows and loads at every nodal diameter that three harmonics excite."""
    given, python = study.sweep.problem, in_python(folder)
    assert isinstance(given, ss.TunedDisk)
    assert (given.sectors, given.engine_order) == (12, 3)
    for harmonic in range(4):
        for ours, theirs in zip(given.systems.at(harmonic), python.systems.at(harmonic), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12 * np.abs(theirs).max())
    np.testing.assert_allclose(given.static_load, python.static_load, rtol=1e-12)
    assert [repr(contact.law) for contact in given.contacts] == [repr(contact.law) for contact in python.contacts]


def test_a_check_says_what_was_found(study):
    notes = "\n".join(study.notes)
    assert re.search(r"LOW and HIGH: 21 pairs of nodes, at most \S+ mm apart, 1 of 12 sectors", notes)
    assert "6 points of 13 nodes on next/PLATFORM_LEFT against wedge, 531.1 mm2; mean normal -0.707, -0.707, 0" in notes
    summary = "\n".join(model_summary(study.sweep))
    for n in (0, 6):
        assert f"At nodal diameter {n}, without contacts: 6 rigid motions" in summary


def test_the_soft_spring_that_a_wedge_needs_is_proposed(folder):
    spring = (
        "[[mean_spring]]                   # only friction holds the wedge along the axis: a soft spring on its mean position\n"
    )
    loose = changed(folder, (spring, ""), ('direction = "wedge/centre.z"\nk = 10.0                          # N/mm\n', ""))
    assert 'affect the vibration: direction = { "wedge/centre.z" = 1 }, k of about' in "\n".join(model_summary(loose.sweep))


def test_a_damper_that_touches_one_sector_alone_is_asked_for_the_next_one(folder):
    said = "No contact joins two sectors: a damper between neighbours must touch next/SET."
    with pytest.raises(InputError, match=f"cannot carry the static load.*{said}"):
        changed(folder, ("next/PLATFORM_LEFT", "PLATFORM_LEFT"))


def test_a_surface_of_the_next_sector_stands_in_its_place(folder):
    """A platform turned by 30° does not lie on itself: nothing of it touches. Two sectors on there is no name."""
    text = re.sub(
        r"(?s)\[\[body\]\].*?(?=\[\[force\]\])|\[\[mean_spring\]\].*?(?=\[sweep\])", "", (folder / "wheel.toml").read_text()
    )
    shroud = '[[contact]]\nlaw = "gap"\nkn = 1e3\nsurface = "PLATFORM_RIGHT"\nagainst = "next/PLATFORM_RIGHT"\n'
    assert "does not exist" in fault_of(folder, text + shroud.replace("next/", "next/next/"))
    assert "must touch what lies opposite" in fault_of(folder, f"{text}{shroud}facing = [-0.97, 0.26, 0.0]\n")


def fault_of(folder, text):
    with pytest.raises(InputError) as error:
        job(text, folder, "wheel")
    return str(error.value)


@pytest.mark.slow
def test_a_study_runs_to_its_report(folder, tmp_path):
    """From the command line: peaks of both force levels are those of the problem in Python, and the report names the disk."""
    text = (folder / "wheel.toml").read_text().replace("harmonics = 15", "harmonics = 1")
    (folder / "short.toml").write_text(text)
    with pytest.raises(SystemExit) as end:
        main(["run", str(folder / "short.toml"), "--out", str(tmp_path / "out"), "--workers", "1"])
    assert not end.value.code
    found = ss.ForcedResponse(ss.open_results(tmp_path / "out" / "results.nc"), ss.read_problem(folder / "short.toml")).peaks()
    python = ss.forced_response(in_python(folder), ss.hertz(1030.0, 1130.0), force=[1.0, 5.0], harmonics=1, samples=144).peaks()
    np.testing.assert_allclose(found["amplitude"], python["amplitude"], rtol=1e-12)
    assert "engine order 3" in (tmp_path / "out" / "report.html").read_text()


def test_a_study_reduces_the_nodal_diameters_that_its_engine_orders_can_excite(folder, study):
    """Of twelve sectors engine order 3 excites 0, 3 and 6; several orders excite the multiples of their greatest common divisor,
    to which N/2 is added. Mistuned disks, gas forces and `whole_disk` take all."""
    orders = ("engine_order = 3 ", "orders = { 4 = 1.0, 8 = 0.5 } ")
    gas = "[aerodynamics]\ndirection = 'tip.y'\nfrequency = 1000.0\ninfluence = [[0, 0.0, 1.0]]\n[excitation]"
    population = [('"forced_response"', '"mistuned_population"'), ("force_levels = [1.0, 5.0]", "force_levels = [1.0]")]
    population.append(("[sweep]", "[mistuned_population]\nblade_scatter = 0.003\n[sweep]"))
    held = {
        "one": study.sweep.problem,
        "several": changed(folder, orders).sweep.problem,
        "gas": changed(folder, ("[excitation]", gas)).sweep.problem,
        "population": changed(folder, *population).sweep.problem,
        "whole": ss.read_problem(folder / "wheel.toml", whole_disk=True),
    }
    every = tuple(range(7))
    expected = {"one": (0, 3, 6), "several": (0, 4, 6), "gas": every, "population": every, "whole": every}
    assert {name: problem.disk.diameters.held for name, problem in held.items()} == expected
    for n in (3, -3, 6):
        np.testing.assert_array_equal(held["one"].disk.at(n).K, held["whole"].disk.at(n).K)
    with pytest.raises(InputError, match="must hold all nodal diameters from 0 to 6, but is '0, 3, 6'"):
        held["one"].full()


def test_another_engine_order_reduces_what_it_does_not_share(folder, tmp_path, monkeypatch):
    """And finds the rest where an earlier study left it, 0 and N/2 of all."""
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path))
    done = []
    for order in (3, 2, 3):
        said = []
        text = (folder / "wheel.toml").read_text().replace("engine_order = 3 ", f"engine_order = {order} ")
        job(text, folder, "wheel", lambda share, words, said=said: said.append(words))
        done.append([int(re.search(r"diameter (\d+)", words)[1]) for words in said if words.startswith("reducing")])
    assert done == [[0, 3, 6], [2, 4], []]


@pytest.mark.slow
def test_one_sector_is_the_whole_wheel(folder, tmp_path):
    """All sectors of a reduced sector, slipping: amplitudes of every blade are those of the one, to rounding."""
    text = (folder / "wheel.toml").read_text().replace("points = 6", "points = 2")
    (folder / "two_points.toml").write_text(text)
    disk = ss.read_problem(folder / "two_points.toml", whole_disk=True)
    one, all_sectors = (ss.forced_response(each, [1090.0], force=5.0, harmonics=1, samples=96) for each in (disk, disk.full()))
    assert one.dataset["loss_factor"].item() > 0.02
    amplitudes = all_sectors.dataset["amplitude"].values.ravel()
    assert amplitudes.size == 12
    np.testing.assert_allclose(amplitudes, one.dataset["amplitude"].item(), rtol=1e-9)


def test_a_response_is_found_from_start_offsets_far_from_the_stuck_state(folder):
    """Newton's method, the ramp of the force level and patience all fail from these; offsets that are raised from zero do not."""
    problem = changed(folder, ("points = 6", "points = 2")).sweep.problem
    balance, omega = HarmonicBalance(problem, 1, 96), 2.0 * np.pi * 1030.0
    solved = {"at once": 0, "in the end": 0}
    for seed in range(6):
        drawn = 2e-5 * np.random.default_rng(seed).normal(size=balance.table.start_value.size)
        moved = balance.with_starts(drawn)
        solved["at once"] += continuation.solve_cold(moved, omega, 5.0).converged
        found = continuation.first_point(moved, omega, 5.0)
        solved["in the end"] += found.converged and moved.evaluate(found.evaluation.point).error < 1e-8
    assert solved["at once"] <= 2
    assert solved["in the end"] >= 5


def test_several_engine_orders(folder):
    problem = changed(folder, ("engine_order = 3 ", "orders = { 3 = 1.0, 6 = [0.0, 0.3] } ")).sweep.problem
    assert problem.excited_orders == (3, 6)
    assert problem.forces[0].amplitudes == {1: 1.0, 2: 0.3j}


def test_a_ready_disk_takes_engine_orders(tmp_path):
    text = (
        '[study]\nanalysis = "forced_response"\n[structure]\nrig = "lumped_blisk"\n[excitation]\norders = { 2 = 1.0, 3 = 0.5 }\n'
    )
    problem = job(f"{text}[sweep]\nfrequency = [45.0, 80.0]\nharmonics = 9\n", tmp_path, "x").sweep.problem
    assert problem.excited_orders == (2, 3)


SECTOR = "sectors = 12\n"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (SECTOR, "sectors = 10\n", "they match for sectors = 12. Check sectors and the axis."),
        ('low = "LOW" ', 'low = "HIGH" ', "must have no node in common, but is '21 nodes'. low and high are one set."),
        ("[excitation]\nengine_order = 3 ", "# ", "[excitation] must be given for a bladed disk"),
        ("engine_order = 3 ", "orders = { three = 1.0 } ", "must be a whole number, but is 'three'"),
        ("[excitation]", "[base]\ndirection = 'x'\nacceleration = 1.0\n[excitation]", "base cannot be used with a sector"),
        (SECTOR, f"{SECTOR}at_speeds = [{{ speed = 0.0, model = 'x.npz' }}]\n", "at_speeds needs an analysis over the speed"),
        (SECTOR, f"{SECTOR}speed = 6000.0\n", ""),
        ("next/PLATFORM_LEFT", "next/PLATFORM_LOFT", "does not exist. Did you mean 'next/PLATFORM_LEFT'?"),
        ('low = "LOW" ', 'low = "LOWS" ', "must be a set of nodes of the model, but is 'LOWS'. Did you mean 'LOW'?"),
        ('"PLATFORM_RIGHT"', '"PLATFORMRIGHT"', "Did you mean 'PLATFORM_RIGHT'?"),
        ("modes = 12 ", "shift = [1.0, 0.0, 0.0] # ", "shift must go with a whole structure"),
        ('direction = "tip.y"', 'direction = "next/tip.y"', "must act on the sector itself"),
        ("keep = { tip", 'keep = { face = "LOW", tip', "Keep nodes beside the faces"),
    ],
)
def test_what_does_not_fit_is_refused(folder, old, new, words):
    if not words:
        assert "contains no spin softening" in "\n".join(changed(folder, (old, new)).notes)
        return
    with pytest.raises(InputError, match=re.escape(words)):
        changed(folder, (old, new))


def test_a_speed_sweep_goes_between_models_at_two_speeds(folder):
    """K₁ of the study is that between the disks of Python, at every nodal diameter; mass and contacts are the same."""
    with np.load(folder / "wheel_sector.npz") as arrays:
        np.savez(folder / "fast.npz", **{**arrays, "K": 1.02 * arrays["K"]})
    text = (folder / "wheel.toml").read_text()
    text = text.replace(SECTOR, f'{SECTOR}speed = 0.0\nat_speeds = [{{ speed = 6000.0, model = "fast.npz" }}]\n')
    text = text.replace('analysis = "forced_response"', 'analysis = "speed_sweep"')
    text = re.sub(r"\[excitation\]\n.*\n|frequency = .*\n", "", text)
    sweep = "[speed_sweep]\nspeed = [5000.0, 7000.0]\nengine_orders = [9]\nreference_speed = 6000.0\n"
    with pytest.raises(InputError, match="reference_speed must be the speed of the sector's model, 0 rev/min"):
        job(text + sweep, folder, "wheel")
    text = text.replace(
        'speed = 0.0\nat_speeds = [{ speed = 6000.0, model = "fast.npz" }]',
        'speed = 6000.0\nat_speeds = [{ speed = 0.0, model = "wheel_sector.npz" }]',
    ).replace('model = "wheel_sector.npz"  ', 'model = "fast.npz"  ')
    plan = job(text + sweep, folder, "wheel").plan
    at_rest, fast = (plan.works[""].parts[0].problem.at_speed(speed).structure for speed in (0.0, 200.0 * np.pi))
    for n in range(7):
        np.testing.assert_allclose(fast.at(n).K, 1.02 * at_rest.at(n).K, rtol=1e-9, atol=1e-9 * np.abs(fast.at(n).K).max())
    diagram = re.sub("force_levels = .*", "", f"{text}{sweep}".replace("speed_sweep", "campbell"))
    models = job(diagram, folder, "wheel").plan.works[""].models.models
    assert sorted(models) == [0.0, 6000.0]
    for speed, model in models.items():
        assert model.structure.turns
        np.testing.assert_allclose(model.structure.at(3).K, (at_rest if speed == 0.0 else fast).at(3).K, rtol=1e-9, atol=1.0)
    with pytest.raises(InputError, match="takes its engine orders from"):
        job(f"{text}{sweep}[excitation]\nengine_order = 3\n", folder, "wheel")


def test_a_model_at_another_speed_than_that_of_the_band_is_warned_of(folder):
    """Engine order EO excites a band in Hz at 60/EO times as many rev/min; of several orders their divisor counts."""
    text = (folder / "wheel.toml").read_text()
    order = int(re.search(r"engine_order = (\d+)", text)[1])
    low, high = (float(end) for end in re.search(r"frequency = \[(.*)\]", text)[1].split(","))
    inside = 0.5 * (low + high) * 60.0 / order
    found = changed(folder, (SECTOR, f"{SECTOR}speed = 6000.0\n"))
    (warned,) = [note for note in found.notes if "another speed" in note]
    assert f"engine order {order} excites at {order * 100.0:.5g} Hz" in warned
    assert f"{low * 60.0 / order:.5g} to {high * 60.0 / order:.5g} rev/min" in warned
    found = changed(folder, (SECTOR, f"{SECTOR}speed = {inside}\n"))
    assert not any("another speed" in note for note in found.notes)
    several = "engine_order = 3 ", "orders = { 4 = 1.0, 6 = 0.3 } "
    found = changed(folder, (SECTOR, f"{SECTOR}speed = 6000.0\n"), several)
    assert any("engine order 2 excites at 200 Hz" in note for note in found.notes)


def test_a_check_says_how_many_samples_are_used(folder):
    """Delays between twelve sectors under engine order 4 are whole numbers of samples."""
    plan = changed(folder, ("engine_order = 3 ", "engine_order = 4 "), ("samples = 144", "samples = 256")).plan
    assert plan.works[""].samples == 258
    assert plan.summary.endswith("15 harmonics, 258 samples")


def at_two_speeds(folder, name):
    """The study with the model at rest in another file."""
    text = (folder / "wheel.toml").read_text()
    text = text.replace(SECTOR, f'{SECTOR}speed = 6000.0\nat_speeds = [{{ speed = 0.0, model = "{name}" }}]\n')
    text = text.replace('analysis = "forced_response"', 'analysis = "speed_sweep"')
    text = re.sub(r"\[excitation\]\n.*\n|frequency = .*\n", "", text)
    return text + "[speed_sweep]\nspeed = [5000.0, 7000.0]\nengine_orders = [9]\nreference_speed = 6000.0\n"


def without_row(arrays):
    kept = np.flatnonzero(arrays["dofs"] != "9.y")
    return {**arrays, "dofs": arrays["dofs"][kept]} | {name: arrays[name][np.ix_(kept, kept)] for name in "MK"}


def on_stiff_springs(arrays):
    held = np.isin(arrays["dofs"], ("77.x", "77.y", "77.z"))
    return {**arrays, "K": arrays["K"] + np.diag(1e14 * held)}


def taken_out(arrays):
    free = (arrays["dofs"] != "77.x").astype(float)
    return {**arrays, "K": arrays["K"] * np.outer(free, free) + np.diag(1.0 - free)}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (without_row, "must have the same rows, but is '9.y in wheel_sector.npz alone'. Fix the same nodes"),
        (on_stiff_springs, "must be held at the same nodes, but is '77.x, 77.y, 77.z with "),
        (taken_out, "must be held at the same nodes, but is '77.x with "),
    ],
)
def test_models_at_two_speeds_with_other_supports_are_refused(folder, change, said):
    with np.load(folder / "wheel_sector.npz") as arrays:
        np.savez(folder / "rest.npz", **change({**arrays}))
    with pytest.raises(InputError, match=re.escape(said)):
        job(at_two_speeds(folder, "rest.npz"), folder, "wheel")


def test_supports_that_a_cyclic_step_leaves_out_on_one_face_are_those_of_the_other_speed(folder):
    """A node of HIGH is free in one file alone, and its partner held in both: frequencies are those with both held in both."""
    model = read_model(folder / "wheel_sector.npz", units="mm-t-s", names=folder / "wheel_sector.csv")
    low = model.sets["LOW"][-1]
    turn = np.pi / 6.0
    turned = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]) @ model.nodes[low]
    high = min(model.sets["HIGH"], key=lambda node: np.linalg.norm(turned - model.nodes[node]))
    with np.load(folder / "wheel_sector.npz") as arrays:
        given = {**arrays}
    for name, held in (("both", (low, high)), ("one", (low,))):
        free = np.flatnonzero([dof.rpartition(".")[0] not in held for dof in given["dofs"]])
        K, M = (given[key][np.ix_(free, free)] for key in "KM")
        np.savez(folder / f"{name}.npz", dofs=given["dofs"][free], K=K, M=M)
    text = at_two_speeds(folder, "both.npz")
    found = [
        job(text.replace('model = "wheel_sector.npz"', f'model = "{name}.npz"'), folder, "wheel").plan.works[""].parts[0].problem
        for name in ("both", "one")
    ]
    np.testing.assert_array_equal(found[0].structure.stiffnesses, found[1].structure.stiffnesses)


def test_models_at_two_speeds_stand_beside_the_rotation_each_with_its_own_softening(folder):
    """K at the speed of [rotation] gets −Ω² M (1 − d dᵀ), that at rest nothing; loads go with the square of the speed."""
    text = re.sub("pull = .*", "", at_two_speeds(folder, "wheel_sector.npz")).replace("speed = 6000.0\nat_speeds", "at_speeds")
    with pytest.raises(InputError, match="must have K at two speeds for a sector over the speed"):
        job(re.sub("at_speeds.*", "", text) + "[rotation]\nspeed = 6000.0\n", folder, "wheel")
    problem = job(text + "[rotation]\nspeed = 6000.0\n", folder, "wheel").plan.works[""].parts[0].problem
    still, half, turning = (problem.at_speed(share * 200.0 * np.pi) for share in (0.0, 0.5, 1.0))
    plain = job(text.replace("at_speeds", "speed = 6000.0\nat_speeds"), folder, "wheel").plan.works[""].parts[0].problem
    for n in (0, 3, 6):
        a, b, c = (each.structure.at(n).K for each in (still, half, turning))
        np.testing.assert_allclose(b - a, 0.25 * (c - a), atol=1e-9 * np.abs(a).max())
        free, softened = (each.disk.at(n) for each in (plain, turning))
        own = [np.sort(np.linalg.eigvals(np.linalg.solve(each.M, each.K)).real)[6] for each in (free, softened)]
        assert 0.0 < own[0] - own[1] < 1.001 * (200.0 * np.pi) ** 2
    assert 0.0 < np.abs(half.static_load).max() == pytest.approx(0.25 * np.abs(turning.static_load).max(), rel=1e-9)


@pytest.mark.parametrize(("angle", "modes", "warns"), [(0.0, 12, ""), (0.03, 12, "K goes"), (0.3, 1, "In the shapes")])
def test_models_whose_soft_motions_differ_are_warned_of(folder, angle, modes, warns, tmp_path, monkeypatch):
    """K turned by an angle about the axis has the same frequencies and other soft motions: both have theirs in shapes of both,
    unless these are few, and K on the straight line between them, as in a sweep, has neither."""
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path))
    with np.load(folder / "wheel_sector.npz") as arrays:
        given = {**arrays}
    turn, rows = np.eye(len(given["dofs"])), {str(dof): row for row, dof in enumerate(given["dofs"])}
    for x, row in rows.items():
        if x.endswith(".x"):
            both = [row, rows[f"{x[:-2]}.y"]]
            turn[np.ix_(both, both)] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    np.savez(folder / "turned.npz", **given | {"K": turn @ given["K"] @ turn.T})
    text = at_two_speeds(folder, "turned.npz").replace("modes = 12 ", f"modes = {modes} ")
    said = " ".join(job(text, folder, "wheel").notes)
    assert ("Warning: K goes straight" in said) == (angle > 0.0)
    assert ("Warning: In the reduction basis" in said) == (warns == "In the shapes")
    assert "In the reduction basis that all speeds share, the 3 lowest frequencies at nodal diameter 0" in said


def test_engine_orders_of_other_models_are_refused(tmp_path):
    text = '[study]\nanalysis = "forced_response"\n[structure]\nmatrices = { M = [[1.0]], K = [[1.0]] }\ndofs = ["1.x"]\n'
    with pytest.raises(InputError, match=re.escape("[excitation] needs a bladed disk")):
        job(f'{text}[excitation]\nengine_order = 2\n[sweep]\nfrequency = [0.1, 0.3]\noutputs = ["1.x"]\n', tmp_path, "x")


POPULATION = [
    ('"forced_response"', '"mistuned_population"'),
    ("[sweep]", "[mistuned_population]\nblade_scatter = 0.003\n[sweep]"),
]
FATIGUE = "[fatigue]\nfatigue_strength = 1.0\nultimate_strength = 2.0\n[sweep]"
SPEEDS = [
    ("sectors = 12", "sectors = 12\nspeed = 9000.0"),
    ('"forced_response"', '"speed_sweep"'),
    ("[excitation]\nengine_order = 3", ""),
    ("[sweep]", "[speed_sweep]\nspeed = [1.0, 2.0]\nengine_orders = [3]\nreference_speed = 8000.0\n[sweep]"),
]


@each(
    ("pairs", "message"),
    [
        ([("[sweep]", FATIGUE)], "[fatigue] must go with places of stress"),
        ([("outputs", "#")], "[sweep]: outputs must be given"),
        ([*POPULATION, ("harmonics = 15", 'harmonics = "auto"')], "[sweep]: mistuning must have a number of harmonics"),
        (POPULATION, "[sweep]: mistuning must have one force level"),
        ([("harmonics = 15", "harmonics = 200")], "[sweep]: samples must"),
        ([("engine_order = 3", "engine_order = 13")], "must be a whole number and lie between 0 and the number of sectors, 12"),
        ([("engine_order = 3", "orders = { three = 1.0 }")], "[excitation]: orders, an engine order must be a whole number"),
        (SPEEDS, "reference_speed must be the speed of the sector's model, 9000 rev/min, but is 8000.0."),
        (
            [SPEEDS[1], SPEEDS[2], ("[sweep]", SPEEDS[3][1]), ("modes = 12", 'stress = { foot = "BORE" }')],
            "stress needs analysis",
        ),
    ],
)
def test_what_the_text_says_wrongly_is_refused_before_the_sector_is_reduced(pairs, message, folder, monkeypatch):
    """The reduction of a large sector takes minutes."""
    monkeypatch.setattr("stickslip.study.structure.disks_of", None)  # cannot be called
    with pytest.raises(InputError) as refused:
        changed(folder, *pairs)
    assert message in str(refused.value)
