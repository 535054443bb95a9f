"""[rotation] in a study: blades that contacts hold alone, dampers pulled by their own mass, mean stress; what is refused."""

import re
from dataclasses import replace

import numpy as np
import pytest
from problem.test_centrifugal_load import FOOT, LENGTH, OMEGA, SIDE, bar
from scipy import linalg
from study.test_surfaces_study import STUDY as BLADES
from study.test_surfaces_study import folder as blades  # noqa: F401

import stickslip as ss
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.problem.speed import inertia_along
from stickslip.model.readers.read import read_model
from stickslip.model.readers.stress_places import spin_softening
from stickslip.model.structure.centrifugal import CentrifugalLoads, RotationAxis, softening
from stickslip.model.structure.solid import STEEL
from stickslip.study import job, structure

STUDY = """
units = "mm-t-s"
[study]
analysis = "forced_response"
[structure]
model = "bar.npz"
names = "bar.csv"
keep = { tip = "TIP" }
modes = 4
[rotation]
speed = 3000.0
[damping]
modal = 0.01
[[contact]]
name = "root"
law = "macroslip"
surface = "FOOT"
against = "ground"
facing = [0.0, 1.0, 0.0]
kt = 1e6
kn = 2e6
mu = 0.5
[[force]]
direction = "tip.x"
amplitude = 1.0
[sweep]
at = [50.0]
force_levels = [1e-3]
harmonics = 1
samples = 64
outputs = ["tip.x"]
"""


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def folder(tmp_path):
    """The bar in mm, t, s, with the names of its nodes and sets."""
    model, body = bar(3)
    nodes = np.column_stack([np.arange(1, len(body.points) + 1), 1e3 * body.points])
    np.savez(tmp_path / "bar.npz", M=1e-3 * model.M.toarray(), K=1e-3 * model.K.toarray(), dofs=np.array(model.dofs), nodes=nodes)
    sets = {node: name for name, members in model.sets.items() for node in members}
    lines = [f"{node:.0f},{x},{y},{z},{sets.get(f'{node:.0f}', '')}" for node, x, y, z in nodes.tolist()]
    (tmp_path / "bar.csv").write_text("\n".join(["node,x,y,z,set", *lines]))
    return tmp_path


def mean_forces(problem):
    """Of all contacts at their normals, N."""
    data = ss.forced_response(problem, [50.0], [1e-3], harmonics=1, samples=64).dataset
    return data["contact_force"].sel(direction="n", harmonic=0, part="re").values.ravel()


@pytest.mark.parametrize("from_mesh", [False, True])
def test_a_blade_is_pulled_into_a_root_of_contacts(folder, from_mesh, monkeypatch):
    """ΣN = Ω² ∫ρ y dV, which is said, too; K keeps its rigid motions free."""
    if from_mesh:
        monkeypatch.setattr(structure, "WHOLE_SIZE", 50)
        monkeypatch.setattr(structure, "MANY_KEPT", 10)
    made = job(STUDY, folder, "bar")
    problem = made.sweep.problem
    assert (problem.mesh is not None) == from_mesh
    load = OMEGA**2 * STEEL.density * SIDE**2 * LENGTH * (FOOT + 0.5 * LENGTH)
    said = " ".join(made.remarks)
    assert f"centrifugal load {load:.6g} N along (0, 1, 0). Coriolis forces" in said
    assert "K contains no spin softening of 3000 rev/min: none is added to a model that only contacts restrain" in said
    data = ss.forced_response(problem, [50.0], [1e-3], harmonics=1, samples=64).dataset
    forces = data["contact_force"].sel(direction="n", harmonic=0, part="re").values
    assert forces.sum() == pytest.approx(load, rel=1e-6)
    (acting,) = (force for force in problem.forces if isinstance(force, ss.CentrifugalLoad))
    np.testing.assert_allclose(acting.resultant, [0.0, load, 0.0], rtol=1e-9, atol=1e-9 * load)


def test_spin_softening_counts_once(folder):
    """A clamped K that has it stays as it is, and is that to which it is added; its speed must be that of the study."""
    arrays = dict(np.load(folder / "bar.npz"))
    free = np.array([dof.rpartition(".")[0] not in bar(3)[0].sets["FOOT"] for dof in arrays["dofs"]])
    arrays |= {"dofs": arrays["dofs"][free]} | {name: arrays[name][np.ix_(free, free)] for name in "MK"}
    text = STUDY[: STUDY.index("[[contact]]")] + STUDY[STUDY.index("[[force]]") :]
    across = np.array([not dof.endswith(".z") for dof in arrays["dofs"]])
    found, said = [], []
    for K in (arrays["K"], arrays["K"] - OMEGA**2 * arrays["M"] * across):
        np.savez(folder / "bar.npz", **arrays | {"K": K})
        made = job(text, folder, "bar")
        found.append(made.sweep.problem.structure.K)
        said.append(" ".join(made.remarks))
    assert "K contains no spin softening of 3000 rev/min: it is added" in said[0]
    assert "K contains the spin softening of 3000 rev/min" in said[1]
    np.testing.assert_allclose(*found, rtol=1e-9, atol=1e-9 * np.abs(found[0]).max())
    at_rest = job(text.replace("[rotation]\nspeed = 3000.0\n", ""), folder, "bar").sweep.problem.structure.K
    np.testing.assert_allclose(at_rest, found[0], rtol=1e-9, atol=1e-9 * np.abs(found[0]).max())
    with pytest.raises(ss.InputError, match="must be that whose spin softening its K contains, 3000 rev/min"):
        job(text.replace("speed = 3000.0", "speed = 4000.0"), folder, "bar")
    np.savez(folder / "bar.npz", **arrays)
    with pytest.raises(ss.InputError, match=r"speed of \[rotation\] must leave K positive definite after spin softening"):
        job(text.replace("speed = 3000.0", "speed = 1e6"), folder, "bar")


def test_what_spin_softening_takes_of_a_frequency_is_said(folder):
    """Bending across the axis falls to (f² − n²)^½ at n turns a second; warned of below 0.9 f."""
    arrays = dict(np.load(folder / "bar.npz"))
    free = np.array([dof.rpartition(".")[0] not in bar(3)[0].sets["FOOT"] for dof in arrays["dofs"]])
    M, K = (arrays[name][np.ix_(free, free)] for name in "MK")
    np.savez(folder / "bar.npz", **arrays | {"dofs": arrays["dofs"][free], "M": M, "K": K})
    text = STUDY[: STUDY.index("[[contact]]")] + STUDY[STUDY.index("[[force]]") :]
    at_rest = float(np.sqrt(linalg.eigvalsh(K, M)[0])) / (2.0 * np.pi)
    for share in (0.1, 0.42, 0.45, 0.98):
        turns = share * at_rest
        made = job(text.replace("speed = 3000.0", f"speed = {60.0 * turns}"), folder, "bar")
        (note,) = (note for note in made.remarks if "it is added" in note)
        said = [
            float(part) for part in re.search(r"lowers the lowest natural frequency from ([\d.]+) to ([\d.]+) Hz", note).groups()
        ]
        assert said == pytest.approx([at_rest, np.sqrt(at_rest**2 - turns**2)], rel=2e-3 / np.sqrt(1.0 - share))
        warned = [note for note in made.notes if note.startswith("Warning: spin softening of")]
        assert len(warned) == (share > 0.436)
        assert all(f"from {said[0]:.4g} to {said[1]:.4g} Hz, and K has no stress stiffening" in note for note in warned)
    with pytest.raises(ss.InputError, match="must leave K positive definite after spin softening"):
        job(text.replace("speed = 3000.0", f"speed = {60.0 * 1.01 * at_rest}"), folder, "bar")


@pytest.mark.parametrize(("offset", "warns"), [(0.0, False), (0.8, False), (1.2, True)])
def test_a_shaft_about_its_own_axis_is_no_blade_without_stress_stiffening(folder, offset, warns):
    """A bar about its own axis, or beside it by a share of the radius of gyration: from one on, r_G² is half of the mean r²."""
    arrays = dict(np.load(folder / "bar.npz"))
    free = np.array([dof.rpartition(".")[0] not in bar(3)[0].sets["FOOT"] for dof in arrays["dofs"]])
    M, K = (arrays[name][np.ix_(free, free)] for name in "MK")
    np.savez(folder / "bar.npz", **arrays | {"dofs": arrays["dofs"][free], "M": M, "K": K})
    at_rest = float(np.sqrt(linalg.eigvalsh(K, M)[0])) / (2.0 * np.pi)
    place, moved = {row[0]: row[1:] for row in arrays["nodes"]}, []
    for dof in arrays["dofs"][free]:
        node, _, along = dof.rpartition(".")
        moved.append([along == "x", place[float(node)]["xz".index(along) * 2] if along in "xz" else 0.0])
    mass, _, _, spread = (np.array(moved, dtype=float).T @ M @ np.array(moved, dtype=float)).ravel()
    offset = offset * np.sqrt(spread / mass)
    axis = f"axis = {{ point = [{offset}, 0.0, 0.0], direction = [0.0, 1.0, 0.0] }}"
    text = STUDY[: STUDY.index("[[contact]]")] + STUDY[STUDY.index("[[force]]") :]
    made = job(text.replace("speed = 3000.0", f"speed = {60.0 * 0.6 * at_rest}\n{axis}"), folder, "bar")
    assert any(note.startswith("Warning: spin softening") for note in made.notes) == warns
    assert ("needs coriolis = true" in " ".join(made.remarks)) != warns


def test_what_a_higher_mode_loses_is_warned_of(folder):
    """The lowest mode moves along the axis and loses little; the next one, across it, f to (f² − n²)^½."""
    arrays = dict(np.load(folder / "bar.npz"))
    free = np.array([dof.rpartition(".")[0] not in bar(3)[0].sets["FOOT"] for dof in arrays["dofs"]])
    M, K = (arrays[name][np.ix_(free, free)] for name in "MK")
    across = np.array([dof.endswith(".x") for dof in arrays["dofs"][free]]).astype(float)
    K = K + 1e-5 * np.abs(K).max() * np.diag(across)
    np.savez(folder / "bar.npz", **arrays | {"dofs": arrays["dofs"][free], "M": M, "K": K})
    first, second = np.sqrt(linalg.eigvalsh(K, M)[:2]) / (2.0 * np.pi)
    text = STUDY[: STUDY.index("[[contact]]")] + STUDY[STUDY.index("[[force]]") :]
    made = job(text.replace("speed = 3000.0", f"speed = {60.0 * 0.7 * second}"), folder, "bar")
    (warned,) = (note for note in made.notes if note.startswith("Warning: spin softening"))
    said = [float(part) for part in re.search(r"mode 2 from ([\d.]+) to ([\d.]+) Hz", warned).groups()]
    assert said == pytest.approx([second, np.sqrt(1.0 - 0.7**2) * second], rel=0.02)
    assert f"lowest natural frequency from {first:.4g} to" in warned


ROTATION = "[rotation]\nspeed = 3000.0\naxis = { point = [20.0, -300.0, 0.0] }\n"
PULL = "pull = [0.0, 60.0, 0.0]\n"


def test_a_damper_between_blades_is_pulled_by_its_own_mass(blades):  # noqa: F811
    """m Ω² r of the damper of 20 g at r = 0.352 m; the contacts carry it, and each blade has its own load."""
    made = job(BLADES.replace(PULL, "") + ROTATION, blades, "blades")
    damper = 0.02 * OMEGA**2 * 0.352
    blade = read_model(blades / "platform_blade.inp", units="mm-t-s")
    # Nodes without a place are the incompatible modes of C3D8I, which a linear field leaves at rest.
    outward = np.array([float(dof.endswith(".y") and dof[:-2] in blade.nodes) for dof in blade.dofs])
    radius = np.array([blade.nodes.get(dof[:-2], (0.0, 0.0, 0.0))[1] + 0.3 for dof in blade.dofs])
    (said,) = (note for note in made.remarks if note.startswith("Rotation at"))
    sizes = {name: float(size) for name, size in re.findall(r"load of (\w+) ([\d.e+]+) N", said)}
    assert sizes["damper"] == pytest.approx(damper, rel=1e-4)
    assert sizes["left"] == sizes["right"]
    problem = made.sweep.problem
    (left,) = (force for force in problem.forces if force.name.endswith("left"))
    assert left.resultant[1] == pytest.approx(OMEGA**2 * outward @ blade.M @ (outward * radius), rel=1e-9)
    (pull,) = (force for force in problem.forces if force.name.endswith("damper"))
    assert pull.resultant == pytest.approx((0.0, damper, 0.0), abs=1e-9 * damper)
    (arrows,) = (drawn for drawn in problem._view().arrows if drawn.label == "static forces")
    np.testing.assert_allclose(arrows.feet, [[0.02, 0.052, 0.001]], rtol=1e-12)  # those of the blades act everywhere
    assert arrows.texts == [f"centrifugal load of damper: {damper:g} N"]
    normals = normal_loads_at_rest(problem)
    assert sum(normals.values()) > 0.5 * damper
    with pytest.raises(ss.InputError, match=r"\[\[body\]\] 1: pull must not stand beside \[rotation\]"):
        job(BLADES + ROTATION, blades, "blades")


def test_spin_softening_is_found_beside_incompatible_modes(blades):  # noqa: F811
    """A rigid translation leaves the inner rows of each C3D8I at rest."""
    blade, axis = read_model(blades / "platform_blade.inp", units="mm-t-s"), RotationAxis()
    softened = replace(blade, K=blade.K - OMEGA**2 * softening(blade.M, blade.dofs, axis))
    assert spin_softening(softened, axis) == pytest.approx(OMEGA, rel=1e-6)
    assert spin_softening(blade, axis) == 0.0


MATRICES = 'matrices = { M = [[1.0]], K = [[1e4]] }\ndofs = ["tip.x"]\n'


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("modes = 4\n", "modes = 4\nspeed = 3000.0\n", "speed must be left out with [rotation]"),
        ("speed = 3000.0", "speed = -3000.0", "[rotation]: speed must"),
        (
            "speed = 3000.0",
            "speed = 3000.0\naxis = { direction = [0.0, 0.0, 0.0] }",
            "The direction of the axis must not be zero",
        ),
        (
            'model = "bar.npz"\nnames = "bar.csv"\nkeep = { tip = "TIP" }\nmodes = 4\n',
            MATRICES,
            "must have coordinates, but is 'none'",
        ),
        ('model = "bar.npz"\nnames = "bar.csv"\nkeep = { tip = "TIP" }\nmodes = 4\n', 'rig = "single_mass"\n', "beside a rig"),
    ],
)
def test_what_has_no_load_of_rotation_is_refused(folder, old, new, said):
    assert old in STUDY
    text = STUDY.replace(old, new)
    if "matrices" in new or "rig" in new:
        text = text[: text.index("[[contact]]")] + text[text.index("[[force]]") :]
    with pytest.raises(ss.InputError) as raised:
        job(text, folder, "bar")
    assert said in str(raised.value)


def test_a_speed_sweep_begins_from_the_speed_of_the_rotation(folder):
    """The load goes with the square of the speed."""
    text = STUDY.replace('"forced_response"', '"speed_sweep"').replace("at = [50.0]\n", "")
    sweep = "[speed_sweep]\nspeed = [2000.0, 4000.0]\nengine_orders = [1]\nreference_speed = {}\n"
    problem = job(text + sweep.format("3000.0"), folder, "bar").plan.works[""].parts[0].problem.at_speed(0.5 * OMEGA)
    load = OMEGA**2 * STEEL.density * SIDE**2 * LENGTH * (FOOT + 0.5 * LENGTH)
    assert sum(normal_loads_at_rest(problem).values()) == pytest.approx(0.25 * load, rel=1e-3)
    with pytest.raises(ss.InputError, match=r"speed must be the reference_speed of \[speed_sweep\], 4000 rev/min, but is 3000"):
        job(text + sweep.format("4000.0"), folder, "bar")


@pytest.mark.parametrize("alone", [True, False])
def test_spin_softening_goes_with_the_speed_in_a_speed_sweep(folder, alone):
    """In the plane of rotation a clamped blade meets an engine order where (EO Ω)² = ω² − Ω², ω at rest."""
    arrays = dict(np.load(folder / "bar.npz"))
    free = np.array([dof.rpartition(".")[0] not in bar(3)[0].sets["FOOT"] for dof in arrays["dofs"]])
    M, K = (arrays[name][np.ix_(free, free)] for name in "MK")
    np.savez(folder / "bar.npz", **arrays | {"dofs": arrays["dofs"][free], "M": M, "K": K})
    text = STUDY[: STUDY.index("[[contact]]")] + STUDY[STUDY.index("[[force]]") :]
    at_rest = float(np.sqrt(linalg.eigvalsh(K, M)[0])) / (2.0 * np.pi)
    rate = {order: 60.0 * at_rest / np.sqrt(order**2 + 1.0) for order in (1, 4)}
    sweep = "[speed_sweep]\nspeed = [{}, {}]\nengine_orders = [{}]\nreference_speed = {}\n"
    text = text.replace('"forced_response"', '"speed_sweep"').replace("at = [50.0]\n", "")
    if not alone:
        own = text[text.index("[structure]") : text.index("[rotation]")]
        blades = [own.replace("[structure]", f'[[structure]]\nname = "{name}"') for name in ("left", "right")]
        text = text.replace(own, "".join(blades)).replace('"tip.x"', '"left/tip.x"')
    for order, reference in ((1, 0.3 * rate[1]), (4, 1.2 * rate[4])):
        stated = sweep.format(0.98 * rate[order], 1.02 * rate[order], order, reference)
        made = job(text.replace("speed = 3000.0", f"speed = {reference}") + stated, folder, "bar")
        problem = made.plan.works[""].parts[0].problem
        for turns in (0.5 * rate[order] / 60.0, rate[order] / 60.0):
            at = problem.at_speed(2.0 * np.pi * turns).structure
            found = np.sqrt(np.sort(abs(linalg.eigvals(at.K, at.M)))) / (2.0 * np.pi)
            assert found[0] == pytest.approx(np.sqrt(at_rest**2 - turns**2), rel=2e-3)
            assert found[1 if alone else 2] == pytest.approx(at_rest, rel=2e-3)  # along the axis


@pytest.mark.parametrize("reduced", [True, False])
def test_a_blade_that_turns_about_itself_whirls_at_two_frequencies(folder, reduced):
    """f₀ − n and f₀ + n at n turns a second, of a square bar whose K has its spin softening; refused over speeds."""
    arrays = dict(np.load(folder / "bar.npz"))
    free = np.array([dof.rpartition(".")[0] not in bar(3)[0].sets["FOOT"] for dof in arrays["dofs"]])
    M, K = (arrays[name][np.ix_(free, free)] for name in "MK")
    np.savez(folder / "bar.npz", **arrays | {"dofs": arrays["dofs"][free], "M": M, "K": K})
    text = STUDY[: STUDY.index("[[contact]]")] + STUDY[STUDY.index("[[force]]") :]
    text = text if reduced else re.sub(r"keep = .*\nmodes = .*\n", "", text)
    at_rest = float(np.sqrt(linalg.eigvalsh(K, M)[0])) / (2.0 * np.pi)
    turning = f"speed = {6.0 * at_rest}\ncoriolis = true\naxis = {{ point = [0.0, 0.0, 0.0], direction = [0.0, 1.0, 0.0] }}"
    text = text.replace("speed = 3000.0", turning)
    if not reduced:
        text = text.replace("tip.x", "1.x" if "1.x" in arrays["dofs"][free] else str(arrays["dofs"][free][0]))
    made = job(text, folder, "bar")
    frequencies = made.sweep.problem.frequencies(stuck=True)[:2]
    np.testing.assert_allclose(frequencies, [0.9 * at_rest, 1.1 * at_rest], rtol=2e-3)
    assert "Spin softening of bodies is neglected" in " ".join(made.remarks)
    assert "centrifugal load has no resultant" in " ".join(made.remarks)
    sweep = "[speed_sweep]\nspeed = [2000.0, 4000.0]\nengine_orders = [1]\nreference_speed = 3000.0\n"
    over_speeds = text.replace('"forced_response"', '"speed_sweep"').replace("at = [50.0]\n", "") + sweep
    with pytest.raises(ss.InputError, match=r"coriolis must be false with \[speed_sweep\]"):
        job(re.sub("speed = [0-9.]+\ncoriolis", "speed = 3000.0\ncoriolis", over_speeds), folder, "bar")
    campbell = f"[campbell]\nspeed = [0.0, {12.0 * at_rest}]\nengine_orders = [9]\npoints = 3\n"
    over_speeds = re.sub("force_levels.*\n", "", over_speeds).replace(sweep, campbell).replace("speed_sweep", "campbell")
    diagram = job(over_speeds, folder, "bar").plan.works[""]
    found = diagram.gathered([diagram.solve(0, lambda share: None)]).dataset.sel(state="stuck", engine_order=9)
    expected = at_rest * np.array([[1.0, 0.9, 0.8], [1.0, 1.1, 1.2]])
    np.testing.assert_allclose(found["frequency"].values[:2], expected, rtol=3e-3)
    np.testing.assert_allclose(found["whirl"].values[:2, 1:], [[1.0, 1.0], [-1.0, -1.0]], rtol=0.01)
    np.testing.assert_allclose(found["crossing_speed"].values[0], 60.0 * at_rest / 10.0, rtol=3e-3)


def test_coriolis_forces_act_on_blades_and_dampers(blades):  # noqa: F811
    """2 Ω m along y of each body that moves along x, Ω along z, by both reduced blades and the damper of 20 g."""
    made = job(BLADES.replace(PULL, "") + ROTATION.replace("speed", "coriolis = true\nspeed", 1), blades, "blades")
    problem = made.sweep.problem
    assert problem.structure.coriolis is not None
    dofs = problem.structure.dofs
    along = {d: np.array([float(dof == f"damper/centre.{d}") for dof in dofs]) for d in "xy"}
    G = problem.structure.coriolis
    assert along["y"] @ G @ along["x"] == pytest.approx(2.0 * OMEGA * 0.02, rel=1e-9)
    np.testing.assert_allclose(G, -G.T, atol=1e-12 * np.abs(G).max())
    left = [k for k, dof in enumerate(dofs) if dof.startswith("left/")]
    assert np.abs(G[np.ix_(left, left)]).max() > 0.0
    blade = read_model(blades / "platform_blade.inp", units="mm-t-s")
    with pytest.raises(ss.InputError, match="must be left out beside a sector, whose Coriolis forces are neglected"):
        structure._rotating(blade, (3000.0, RotationAxis(), True), True)


def test_the_base_of_a_reduced_model_moves_all_of_it(folder):
    """Also what is not kept: the response is that of the whole model; a base that turns, or one of several models, is refused."""
    arrays = dict(np.load(folder / "bar.npz"))
    free = np.array([dof.rpartition(".")[0] not in bar(3)[0].sets["FOOT"] for dof in arrays["dofs"]])
    M, K = (arrays[name][np.ix_(free, free)] for name in "MK")
    np.savez(folder / "bar.npz", **arrays | {"dofs": arrays["dofs"][free], "M": M, "K": K})
    force = STUDY[STUDY.index("[[force]]") : STUDY.index("[sweep]")]
    text = STUDY.replace(force, '[base]\ndirection = "x"\nacceleration = 1000.0\n').replace("[rotation]\nspeed = 3000.0\n", "")
    text = text[: text.index("[[contact]]")] + text[text.index("[base]") :]
    reduced = job(text.replace("modes = 4", "modes = 20"), folder, "bar").sweep.problem
    corner = next(dof for dof in reduced.structure.dofs if dof.endswith(".x"))
    node = next(name for name, place in bar(3)[0].nodes.items() if place == pytest.approx(reduced.structure.nodes[corner[:-2]]))
    whole = re.sub(r"keep = .*\nmodes = .*\n", "", text).replace("tip.x", f"{node}.x")
    found = [
        ss.forced_response(problem, [5.0, 40.0], 1.0, harmonics=1, samples=16).dataset["amplitude"].values.ravel()
        for problem in (replace(reduced, outputs=(corner,)), job(whole, folder, "bar").sweep.problem)
    ]
    np.testing.assert_allclose(*found, rtol=1e-4)
    with pytest.raises(ss.InputError, match="must move a reduced model as a whole along x, y and z"):
        inertia_along(replace(reduced.structure, centrifugal=None), np.ones(reduced.structure.size))
    loads = CentrifugalLoads(np.zeros((9, 6)), 3)
    two = ss.Structure(np.eye(3), np.eye(3), ("1.x", "2.x", "mode/1.q"), centrifugal=loads)
    with pytest.raises(ss.InputError, match="as a whole along x, y and z, but is 'another motion'"):
        inertia_along(two, np.array([1.0, 2.0, 0.0]))
