"""A study of blades from CalculiX and a damper of one's own between them: surfaces, bodies, several structures."""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from each import each

import stickslip as ss
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.readers.model import model_of
from stickslip.model.readers.read import read_content
from stickslip.study import read
from stickslip.support.checks import InputError
from stickslip.support.units import unit_system

DATA = Path(__file__).parents[1] / "data" / "calculix"
STUDY = """
units = "mm-t-s"
[study]
analysis = "forced_response"
[[structure]]
name = "left"
model = "platform_blade.inp"
keep = { tip = [0.0, 122.0, 0.0] }
modes = 6
[[structure]]
name = "right"
model = "platform_blade.inp"
keep = { tip = "TIP", PLATL = "PLATL" }
modes = 6
shift = [40.0, 0.0, 0.0]
[[body]]
name = "damper"
mass = 2e-5
inertia = [1e-3, 2e-3, 2.5e-3]
centre = [20.0, 52.0, 1.0]
axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
pull = [0.0, 60.0, 0.0]
[damping]
modal = 0.002
[[contact]]
name = "L"
law = "macroslip"
surface = "left/PLATR"
against = "damper"
tangent = [1.0, 0.0, 0.0]
kt = 2e4
kn = 4e4
mu = 0.4
[[contact]]
law = "iwan"
surface = "right/PLATL"
against = "damper"
tangent = [1.0, 0.0, 0.0]
kt = 3e4
kn = 5e4
mu = 0.3
mean_pressure = 0.1
[[force]]
direction = "left/tip.x"
amplitude = 1.0
[sweep]
frequency = [400.0, 700.0]
outputs = ["left/tip.x", "damper/centre.y"]
"""


FURTHER_SETS = """*NSET, NSET=SIDES
166,168,170,172,174,184,194,192,190,188,186
*NSET, NSET=APART
166,170,174,186,190,194
"""
"""Of the grid 166, 168, ... 174; 176, ... 184; 186, ... 194 of PLATR: three of its sides, and nodes that no side joins."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("blades")
    for name in ("inp", "dof"):
        deck = (DATA / f"platform_blade.{name}").read_text()
        (place / f"platform_blade.{name}").write_text(deck.replace("*NSET, NSET=TIP\n", FURTHER_SETS + "*NSET, NSET=TIP\n"))
    for name in ("sti", "mas"):
        packed = DATA / f"platform_blade.{name}.gz"
        (place / f"platform_blade.{name}").write_bytes(gzip.decompress(packed.read_bytes()))
    return place


def study(folder, text):
    path = folder / "study.toml"
    path.write_text(text)
    return read(path)


@pytest.fixture(scope="module")
def job(folder):
    return study(folder, STUDY)


def test_the_mesh_says_which_sets_cover_an_area(folder):
    """All nodes of PLATR are corners of faces in the set; of its sides none is; nodes apart say nothing."""
    content, _ = read_content(folder / "platform_blade.inp", {})
    sets = {
        **content.sets,
        "ALONE": ("166",),
        "SOME JOINED": ("166", "168", "190"),
        "WITH ONE MORE": (*content.sets["PLATR"], "157"),
    }
    model = model_of(content, unit_system("mm-t-s"), {}, (), "")
    found = {name: model.covers(members) for name, members in sets.items()}
    assert found["PLATR"]
    assert found["PLATL"]
    assert found["SIDES"] is False
    assert [found[name] for name in ("APART", "ALONE", "SOME JOINED", "WITH ONE MORE", "TIP")] == [None] * 5


def test_sides_of_a_surface_share_their_length_where_they_are_declared_a_line(folder):
    """Two sides of four steps of 7.5 mm, one between them. Their coordinates alone could be those of a strip of long elements."""
    sides = STUDY.replace("left/PLATR", "left/SIDES").replace("tangent = [1.0", "preload = 10.0\ntangent = [1.0", 1)
    with pytest.raises(
        InputError, match=r"\[\[contact\]\] 1: Surface 'left/SIDES' must cover an area, but is 'a line of 11 nodes'"
    ):
        study(folder, sides)
    found = study(folder, sides.replace("preload = 10.0", "preload = 10.0\nline = true"))
    loads = {each.name: each.law.preload for each in found.sweep.problem.contacts if each.name.startswith("L ")}
    length = 60.0 + 9.0 / np.cos(ANGLE)
    between = [0.5 * step / np.cos(ANGLE) for step in (4.0, 5.0)]
    ends, corners = 3.75 * 10.0 / length, [(3.75 + half) * 10.0 / length for half in between]
    expected = {166: ends, 168: 2 * ends, 172: 2 * ends, 186: ends, 174: corners[0], 184: sum(between) * 10.0 / length}
    for node, load in (expected | {194: corners[1]}).items():
        assert loads[f"L {node}"] == pytest.approx(load, rel=1e-6)
    (note,) = (
        note for note in found.notes if note.startswith("L: 11 contacts on left/SIDES against damper, a line; mean normal")
    )
    assert note.endswith("The normals of a line point to the middle of damper: give `facing` for another direction")
    spread = STUDY.replace('direction = "left/tip.x"', 'surface = "left/SIDES"\ndirection = "x"')
    with pytest.raises(InputError, match=r"\[\[force\]\] 1: Surface 'left/SIDES' must cover an area"):
        study(folder, spread)
    assert study(folder, spread.replace('direction = "x"', 'direction = "x"\nline = true')).sweep.problem.forces


ANGLE = np.radians(35.0)
STRIPS = {8: 2.0, 12: 4.5, 17: 2.5}
"""x of the nodes of an underside from the middle of its blade, and half the way to their neighbours, mm."""


def by_hand(blade):
    """Both surfaces contact by contact, from the drawing: place, outward normal, t1 and share of each node."""
    for side, sign, origin in (("left/PLATR", 1.0, 0.0), ("right/PLATL", -1.0, 40e-3)):
        normal = np.array([sign * np.sin(ANGLE), -np.cos(ANGLE), 0.0])
        t1 = np.array([np.cos(ANGLE), sign * np.sin(ANGLE), 0.0])
        for node in blade.sets[side.partition("/")[2]]:
            x, y, z = blade.nodes[node]
            depth = 7.5 if abs(z) < 14e-3 else 3.75
            share = STRIPS[round(abs(1e3 * x))] / 9.0 * depth / 30.0
            yield f"{side}/{node}", (x + origin, y, z), np.stack([t1, np.cross(normal, t1), normal]), share


def test_contacts_are_those_of_the_drawing(job, folder):
    """The stiffness that all contacts add when they stick, against the same assembled by hand from the deck."""
    problem = job.sweep.problem
    blade = ss.read_model(folder / "platform_blade.inp", units="mm-t-s")
    added, expected = problem.stuck_stiffness - problem.structure.K, np.zeros_like(problem.structure.K)
    centre = np.array([20e-3, 52e-3, 1e-3])
    totals = {"left": (2e7, 4e7), "right": (3e7, 5e7)}
    for name, point, frame, share in by_hand(blade):
        kt, kn = totals[name.partition("/")[0]]
        for axis, stiffness in zip(frame, (kt, kt, kn), strict=True):
            arm = np.cross(np.array(point) - centre, axis)
            row = problem.structure.row(
                {f"{name}.{d}": v for d, v in zip("xyz", axis, strict=True)}
                | {f"damper/centre.{d}": -v for d, v in zip("xyz", axis, strict=True)}
                | {f"damper/centre.r{d}": -v for d, v in zip("xyz", arm, strict=True)}
            )
            expected += share * stiffness * np.outer(row, row)
    np.testing.assert_allclose(added, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())


def test_the_body_and_its_pull(job):
    structure, forces = job.sweep.problem.structure, job.sweep.problem.forces
    rows = [structure.index(f"damper/centre.{name}") for name in ("x", "y", "z", "rx", "ry", "rz")]
    mass = structure.M[np.ix_(rows, rows)]
    np.testing.assert_allclose(mass, np.diag([0.02, 0.02, 0.02, 2e-6, 1e-6, 2.5e-6]), atol=1e-15)  # x of the body is y here
    (pull,) = [force for force in forces if force.static]
    assert (pull.direction, pull.static) == ("damper/centre.y", 60.0)


def test_preload_of_a_mean_pressure_is_shared_by_area(job):
    laws = [contact.law for contact in job.sweep.problem.contacts if contact.name.startswith("contact 2 ")]
    area = 9e-3 / np.cos(ANGLE) * 30e-3
    assert sum(law.preload for law in laws) == pytest.approx(0.1e6 * area, rel=1e-6)
    assert {type(law).__name__ for law in laws} == {"Iwan"}


def test_loads_at_rest_hold_the_pull(folder):
    """Contacts that stick: a linear equilibrium, solved here from the drawing; forces of both sides carry the pull."""
    sticking = STUDY.replace("mu = 0.4", "mu = 9.0").replace("mu = 0.3", "mu = 9.0").replace("mean_pressure = 0.1\n", "")
    problem = study(folder, sticking.replace('"iwan"', '"macroslip"')).sweep.problem
    loads = np.array(list(normal_loads_at_rest(problem).values()))
    load = problem.structure.row({"damper/centre.y": 60.0})
    moved = np.linalg.solve(problem.stuck_stiffness, load)
    normals = [-contact.law.kn * problem.structure.row(contact.normal) @ moved for contact in problem.contacts]
    np.testing.assert_allclose(loads, np.abs(normals), rtol=1e-6)
    lifted = sum(
        stiffness * (problem.structure.row(direction) @ moved) * problem.structure.row(direction)
        for contact in problem.contacts
        for direction, stiffness in zip(contact.directions, (contact.law.kt, contact.law.kt, contact.law.kn), strict=True)
    )
    assert lifted[problem.structure.index("damper/centre.y")] == pytest.approx(60.0, rel=1e-9)


def test_notes_say_what_was_found(job):
    assert "L: 15 contacts on left/PLATR against damper, 329.6 mm2; mean normal 0.574, -0.819, 0" in job.notes


def test_points_of_a_surface_stand_for_its_nodes(folder):
    """4 points for the 15 nodes of one side; on the other, where 99 are asked for, all 15. Patches are softer."""
    text = STUDY.replace('name = "L"', 'name = "L"\npoints = 4').replace('law = "iwan"', 'law = "iwan"\npoints = 99')
    found = study(folder, text)
    contacts = found.sweep.problem.contacts
    assert [contact.name for contact in contacts[:4]] == ["L 1", "L 2", "L 3", "L 4"]
    assert (len(contacts), sum(len(contact.nodes) for contact in contacts)) == (4 + 15, 15)
    assert sum(contact.law.kt for contact in contacts[:4]) == pytest.approx(2e7)
    assert any(note.startswith("L: 4 points of 15 nodes on left/PLATR against damper, 329.6 mm2") for note in found.notes)
    (areas,) = [re.search(r"Areas in mm2: (.*?)(\. |$)", note)[1] for note in found.notes if note.startswith("L: ")]
    assert [part.rpartition(" ")[0] for part in areas.split(", ")] == ["L 1", "L 2", "L 3", "L 4"]
    assert sum(float(part.rpartition(" ")[2]) for part in areas.split(", ")) == pytest.approx(329.6, abs=0.2)
    assert sum(contact.area for contact in contacts[:4]) == pytest.approx(329.6e-6, rel=1e-4)
    (other,) = [note for note in found.notes if note.startswith("contact 2: 15 contacts on right/PLATL")]
    assert "points = 99 are more than its nodes" in other
    with pytest.raises(InputError, match=r"'damper/centre.r.' is held by nothing .* More points of a surface hold rotations"):
        study(folder, STUDY.replace('name = "L"', 'name = "L"\npoints = 1').replace('law = "iwan"', 'law = "iwan"\npoints = 1'))
    every, patched = (job.sweep.problem.frequencies(stuck=True)[:4] for job in (study(folder, STUDY), found))
    assert np.all((0.95 * every < patched) & (patched < every))


@each(("value", "words"), (("0", "at least 1"), ("-1", "at least 1"), ("2.5", "whole number"), ('"a"', "whole number")))
def test_points_of_a_surface_are_a_whole_number_from_1(value, words, folder):
    with pytest.raises(InputError) as error:
        study(folder, STUDY.replace('name = "L"', f'name = "L"\npoints = {value}'))
    assert "points" in str(error.value)
    assert words in str(error.value)


def test_nodes_of_one_deck_that_face_each_other(folder):
    """Undersides of two blades moved together: each node of one meets its image; the edge that reaches beyond gets none."""
    text = STUDY.partition("[[body]]")[0] + STUDY[STUDY.index("[damping]") : STUDY.index("[[contact]]")]
    text = text.replace("PLATL", "PLATR").replace("shift = [40.0, 0.0, 0.0]", "shift = [0.05735764, -0.0819152, 7.5]")
    text += '[[contact]]\nname = "j"\nlaw = "macroslip"\nsurface = "left/PLATR"\nagainst = "right/PLATR"\n'
    text += "facing = [0.574, -0.819, 0.0]\nkt = 1e4\nkn = 1e4\nmu = 0.3\n"
    text += STUDY[STUDY.index("[[force]]") :].replace(', "damper/centre.y"', "")
    found = study(folder, text)
    assert any(note.startswith("j: 12 contacts on left/PLATR against right/PLATR") for note in found.notes)
    lost = "3 of 15 nodes of left/PLATR have nothing opposite on right/PLATR: 13 % of the area (41.2 mm2)"
    remedy = "Select the nodes that touch, or divide kt, kn and loads by 0.875 if they are those of the contact as it is."
    assert f"Warning: j: {lost} and of the stiffness is lost. {remedy}" in found.notes
    pressed = study(folder, text.replace("mu = 0.3", "mu = 0.3\npreload = 40.0\nmean_pressure = 0.01"))
    load = 0.125 * (40.0 + 0.01 * 329.614)
    assert f"{lost}, of the stiffness and of the normal load ({load:.4g} N) is lost. {remedy}" in "".join(pressed.notes)
    assert sum(each.law.preload for each in pressed.sweep.problem.contacts) == pytest.approx(7.0 * load, rel=1e-5)
    whole = study(folder, text.replace(", 7.5]", ", 0.0]"))
    assert not any("nothing opposite" in note for note in whole.notes)

    assert all(len(contact.normal) == 4 for contact in found.sweep.problem.contacts)


def test_normals_far_from_the_stated_direction_are_said(folder):
    """The undersides are inclined by 35 degrees, and so are their normals to (0, -1, 0)."""
    stated = STUDY.replace("tangent = [1.0", "facing = [{}]\ntangent = [1.0", 1)

    def said(facing, text=stated):
        return [note for note in study(folder, text.replace("{}", facing)).notes if "`facing`" in note]

    right = ", ".join(f"{part:.9f}" for part in (np.sin(ANGLE), -np.cos(ANGLE), 0.0))
    turned = [", ".join(f"{part:.9f}" for part in (np.sin(each), -np.cos(each), 0.0)) for each in np.radians([20.5, 19.5])]
    assert (said(right), said(turned[0])) == ([], [])
    assert len(said(turned[1])) == 1
    (mean,) = said("0.0, -2.0, 0.0")
    assert mean.startswith("Warning: L: the mean normal of left/PLATR differs by 35 degrees from `facing`, up to 35 at node 1")
    assert mean.endswith("Write `facing = [0.574, -0.819, 0]` if the mesh is right, else check the set.")


def test_a_node_with_another_normal_is_named(folder, tmp_path):
    """The corner 166 lies 2 mm deeper: the mean of the triangles around it is turned by more than 15 degrees."""
    for file in folder.glob("platform_blade.*"):
        (tmp_path / file.name).write_bytes(file.read_bytes().replace(b"166,8,52.80083,-15", b"166,6.852,54.4391,-15"))
    (note,) = (
        note
        for note in study(tmp_path, STUDY.replace("tangent = [1.0", "facing = [0.574, -0.819, 0.0]\ntangent = [1.0", 1)).notes
        if "`facing`" in note
    )
    assert re.match(r"Warning: L: \d of the 15 normals of left/PLATR differ by more than 15 degrees from `facing`, up to", note)
    assert "at node 166. Contacts act along the normals of the mesh. Take out nodes of other faces" in note


def test_laws_without_a_start_state_are_not_warned_of_one(folder):
    """Nobody gave a start state: neither on a surface nor in a single contact."""
    single = '[[contact]]\nlaw = "dahl"\nbetween = ["left/tip.z", "ground"]\nkt = 1.0\nmu = 0.3\nnormal_load = 1.0\n'
    found = study(folder, STUDY.replace('"iwan"', '"dahl"').replace("[[force]]", single + "[[force]]", 1))
    assert not any("Start states without effect" in note for note in found.notes)
    given = study(folder, STUDY.replace('"iwan"', '"dahl"\nstart = { slider_offset = 1e-3 }'))
    assert any("Start states without effect" in note for note in given.notes)


def test_a_stop_without_friction_and_what_is_likely_a_slip(folder):
    """A gap law takes surfaces too; a body 20 m away, is said to be far."""
    stop = '[[contact]]\nlaw = "gap"\nsurface = "left/PLATR"\nagainst = "damper"\nkn = 1e4\ngap = 0.01\n'
    found = study(folder, STUDY.replace("[[force]]", stop + "[[force]]"))
    stops = [contact for contact in found.sweep.problem.contacts if contact.name.startswith("contact 3 ")]
    assert {contact.direction_names for contact in stops} == {("n",)}
    assert sum(contact.law.kn for contact in stops) == pytest.approx(1e7)
    with pytest.raises(
        InputError, match=r"cannot carry the static load.* L: .* is 1.99e\+04 mm away, .* the size: check units\."
    ):
        study(folder, STUDY.replace("centre = [20.0, 52.0, 1.0]", "centre = [20.0, 20000.0, 1.0]").replace("PLATL", "PLATR"))


FITTED = """[[body]]
name = "damper"
shape = "wedge"
between = ["left/PLATR", "right/PLATL"]
pull = [0.0, 60.0, 0.0]
"""


def fitted(text=FITTED):
    """The study with a damper between the platforms."""
    before, _, after = STUDY.partition("[[body]]")
    return f"{before}{text}[damping]{after.partition('[damping]')[2]}"


def test_a_wedge_is_fitted_between_two_platforms(folder):
    """Its faces lie in the surfaces of the contacts, its edges where both platforms end, and it is as deep as they are."""
    found = study(folder, fitted())
    (note,) = [note for note in found.notes if "fitted between" in note]
    assert note.startswith(
        "damper: fitted between left/PLATR and right/PLATL: width 24 mm, height 6.302 mm, depth 30 mm, left_angle 35"
    )
    assert note.endswith("axes = [[1, 0, 0], [0, 1, 0]]")
    # Nodes 166 and 186 of the left platform lie at (8, 52.80) and (17, 59.10) mm.
    assert any("corners of its section (8, 52.8, 0), (32, 52.8, 0), (23, 59.1, 0), (17, 59.1, 0)" in note for note in found.notes)
    assert not any("Contacts do not follow the shape" in note for note in found.notes)
    for given, said in (
        ("{ width = 10.0, height = 2.0 }", "width 10 mm, height 2 mm, depth 30 mm"),
        ("{ width = 20.0 }", "width 20 mm, height 4.901 mm, depth 30 mm"),  # 4 mm less are 2 mm tan 35° in height
    ):
        notes = study(folder, fitted(FITTED + f"dimensions = {given}\n")).notes
        assert any(said in note for note in notes)
    turning = FITTED.replace("pull = [0.0, 60.0, 0.0]", "[rotation]\nspeed = 3000.0\naxis = { direction = [0.0, 0.0, 1.0] }")
    (note,) = [note for note in study(folder, fitted(turning)).notes if "fitted between" in note]
    # Radial in the middle between both platforms, at (20, 55.95) mm: it leans by 19.7° to the right.
    assert "left_angle 54.71" in note
    assert "right_angle 15.29" in note


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("pull =", "centre = [1.0, 0.0, 0.0]\npull =", "between and centre must not be given together"),
        (
            "pull =",
            "dimensions = { left_angle = 30.0 }\npull =",
            "dimensions must be those of the shape 'wedge', but is 'left_angle'",
        ),
        ('"left/PLATR"', '"lft/PLATR"', r"set of nodes 'lft/PLATR' does not exist. Did you mean 'left'"),
        ('"left/PLATR"', '"left/PLAT"', r"'left/PLAT' must be a surface of a contact or a force, or be kept"),
        ("pull = [0.0, 60.0, 0.0]\n", "", r"between needs a pull, or \[rotation\]"),
        ("[0.0, 60.0, 0.0]", "[0.0, 0.0, 60.0]", "The pull must point to the ridge of the platforms"),
        ('"left/PLATR"', '"next/left/PLATR"', "must belong to a sector"),
        ("[0.0, 60.0, 0.0]", "[0.0, -60.0, 0.0]", r"must lie in \[0, 90\) degrees"),
        ('shape = "wedge"', "mass = 1.0\ninertia = [1.0, 1.0, 1.0]", "between and mass must not be given together"),
    ],
)
def test_what_does_not_fit_is_refused(folder, before, after, words):
    with pytest.raises(InputError, match=words):
        study(folder, fitted(FITTED.replace(before, after)))


def test_a_node_of_a_surface_may_be_kept_under_a_name_of_its_own(folder):
    """The reduction has it once; the surface counts it all the same."""
    text = STUDY.replace("keep = { tip = [0.0, 122.0, 0.0] }", "keep = { tip = [0.0, 122.0, 0.0], corner = 166 }")
    found = study(folder, text).sweep.problem
    assert len([contact for contact in found.contacts if contact.name.startswith("L ")]) == 15
    assert "left/corner.x" in found.structure.dofs
    assert "left/PLATR/166.x" not in found.structure.dofs


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('surface = "left/PLATR"', 'surface = "left/PLATX"', r"\[\[contact\]\] 1: Set of nodes 'left/PLATX' does not exist"),
        ('against = "damper"', 'against = "dampr"', "'dampr' does not exist. Did you mean 'damper'"),
        ('against = "damper"', 'against = "ground"', "facing must be given where a surface lies against the ground"),
        ('against = "damper"\n', "", "surface and against must be given together"),
        ("kn = 4e4\n", "normal_load = 3.0\nmean_pressure = 1.0\n", "mean_pressure must go with kn"),
        ('surface = "left/PLATR"', 'surface = "left/PLATR"\nnormal = ["left/tip.x", "ground"]', "must not be given together"),
        ("tangent = [1.0, 0.0, 0.0]", "tangent = [1.0, 0.0]", "tangent must have 3 entries"),
        ('name = "right"', 'name = "left"', r"\[\[structure\]\] 2: name must be another one for each"),
        ('name = "right"\n', "", r"\[\[structure\]\] 2: name must be given where there are several structures"),
        ('name = "damper"', 'name = "left"', r"\[\[body\]\] 1: name must be another one for each"),
        ("mass = 2e-5\n", "", "must be given"),
        ("mass = 2e-5\n", 'mass = 2e-5\nshape = "wedge"\n', "mass and shape must not be given together"),
        ("inertia = [1e-3, 2e-3, 2.5e-3]", "inertia = [1e-3, 2e-3, 9e-3]", "positive principal moments"),
        ("[-1.0, 0.0, 0.0]]", "[-1.0, 0.5, 0.0]]", "axes must be two directions at right angles"),
        ("keep = { tip = [0.0, 122.0, 0.0] }", 'rig = "single_mass"', "must"),
        (
            'direction = "left/tip.x"',
            'direction = "tip.x"',
            "degree of freedom 'tip.x' does not exist. Did you mean 'left/tip.x'",
        ),
        ('[[body]]\nname = "damper"', '[body]\nname = "damper"', r"\[body\] must be written with double brackets"),
    ],
)
def test_wrong_input(folder, before, after, words):
    assert before in STUDY
    with pytest.raises(InputError, match=words):
        study(folder, STUDY.replace(before, after, 1))


def test_a_body_beside_a_rig_is_refused(folder):
    rig = '[study]\nanalysis = "forced_response"\n[structure]\nrig = "single_mass"\n[sweep]\nat = [0.1]\n'
    with pytest.raises(InputError, match="body must go with matrices"):
        study(folder, rig + '[[body]]\nname = "b"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n')


def test_a_force_spread_over_a_surface(folder):
    """The whole force arrives; the set is kept without being named, and reduction needs no `keep` beside it."""
    spread = STUDY.replace(
        'direction = "left/tip.x"\namplitude = 1.0', 'surface = "left/PLATL"\ndirection = { x = 1.0, y = -2.0 }\namplitude = 3.0'
    )
    assert spread != STUDY
    problem = study(folder, spread).sweep.problem
    force = next(each for each in problem.forces if each.amplitudes[1])
    assert {dof.rpartition(".")[2] for dof in force.coefficients} == {"x", "y"}
    for axis, total in (("x", 1.0), ("y", -2.0)):
        assert sum(c for dof, c in force.coefficients.items() if dof.endswith(axis)) == pytest.approx(total)
    assert all(dof.startswith("left/PLATL/") for dof in force.coefficients)


@pytest.mark.parametrize(
    ("direction", "message"),
    [
        ('"left/tip.x"', r"direction with surface must be x, y or z, or a table of these, but is 'left/tip.x'"),
        ("{ w = 1.0 }", r"direction with surface must be x, y or z, or a table of these, but is 'w'"),
    ],
)
def test_a_force_on_a_surface_has_a_direction_in_space(folder, direction, message):
    with pytest.raises(InputError, match=message):
        study(folder, STUDY.replace('direction = "left/tip.x"', f'surface = "left/PLATL"\ndirection = {direction}'))


def test_a_model_held_by_its_surface_alone_may_be_reduced(folder):
    """Contact surfaces are places enough; without any, the modes have nothing to go with."""
    named = study(folder, STUDY).sweep.problem.structure
    node = next(dof for dof in named.dofs if dof.startswith("left/PLATR/") and dof.endswith(".x"))
    alone = STUDY.replace("keep = { tip = [0.0, 122.0, 0.0] }\n", "").replace("left/tip.x", node)
    assert alone.count("keep") == STUDY.count("keep") - 1
    assert len(study(folder, alone).sweep.problem.structure.dofs) == len(named.dofs) - 3
