"""What can be computed but is hardly what was meant: directions, friction coefficients, damping ratios."""

import tomllib

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.contact.point import OnSurface
from stickslip.study import job
from stickslip.study.templates import write_new

COS, SIN = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
ALONG = {"D.x": COS, "D.y": SIN, "1.x": -COS, "1.y": -SIN}
ACROSS = {"D.x": -SIN, "D.y": COS, "1.x": SIN, "1.y": -COS}


def problem(contact=None, damping=None, dofs=("1.x", "1.y", "D.x", "D.y")):
    contact = contact or ss.Contact("pad", ss.Macroslip(kt=1.0, mu=0.3, normal_load=1.0), (ALONG,))
    structure = ss.Structure(np.eye(len(dofs)), 3.0 * np.eye(len(dofs)), dofs, damping=damping)
    return ss.Problem(structure, (contact,), (ss.Force(dofs[0], 1.0),), (dofs[0],))


def pad(tangential, normal=None, **changed):
    law = {"kt": 1.0, "mu": 0.3} | ({"normal_load": 1.0} if normal is None else {"kn": 1.0, "preload": 1.0}) | changed
    return ss.Contact("pad", ss.Macroslip(**law), (tangential,), normal, balanced=normal is not None)


@pytest.mark.parametrize(
    "contact",
    [
        pad(ALONG, ACROSS),
        pad(ss.between("1.x", "D.x"), ss.between("1.y", "D.y")),
        pad(ss.between("1.x", "ground"), ss.between("1.y", "ground")),
        pad({"1.x": 0.5, "D.x": 0.5}),  # the mean of two nodes against the ground
        pad({"D.x": 0.87, "D.y": 0.5, "1.x": -0.87, "1.y": -0.5}),  # cosines of two digits
    ],
)
def test_sound_directions(contact):
    assert problem(contact).warnings == ()


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        (pad(ALONG | {"1.x": COS}), "pad, t1): Where both sides move alike by 1, the relative displacement must be 0"),
        (pad({"D.x": 0.5, "D.y": COS, "1.x": 0.5, "1.y": -COS}), "Where both sides move alike by 1"),  # 1 is left, by chance
        (pad({"1.x": -7.0}), "but is 7. Check signs and sizes"),
        (pad(ALONG, {dof: 7.0 * value for dof, value in ACROSS.items()}), r"pad, n): The coefficients must be those of a unit"),
        (pad(ALONG, ss.between("D.x", "1.x")), "pad, t1 and n): The directions must be perpendicular"),
        (pad(ALONG, mu=50.0), "Large friction coefficients (pad): up to mu = 50. Measured"),
    ],
)
def test_what_is_hardly_meant_is_named(contact, said):
    (warning,) = problem(contact).warnings
    assert said in warning


def test_rotations_and_modal_coordinates_are_no_translations():
    """A lever arm may be any length, and of a mode nobody knows how far its node goes."""
    dofs = ("1.x", "D.x", "D.rz", "blade.mode")
    for direction in ({"1.x": 1.0, "D.x": -1.0, "D.rz": 0.02}, {"D.x": 1.0, "blade.mode": -0.3}, {"blade.mode": 40.0}):
        assert problem(pad(direction), dofs=dofs).warnings == ()
    (warning,) = problem(pad({"D.x": 3.0, "blade.mode": -0.3}), dofs=dofs).warnings
    assert "unit vector, but have length 3" in warning


def test_a_damping_ratio_in_per_cent():
    assert problem(damping=ss.ModalDamping(0.1)).warnings == ()
    (warning,) = problem(damping=ss.ModalDamping(0.2)).warnings
    assert warning == "A large damping ratio: 0.2, 20 % of critical damping. One per cent is 0.01."
    (warning,) = problem(damping=ss.ModalDamping((0.01, 50.0))).warnings
    assert warning == "A large damping ratio: 50, 5000 % of critical damping. One per cent is 0.01."


def test_a_check_of_a_study_names_a_flipped_sign(tmp_path):
    path, _ = write_new("lumped", tmp_path / "wedge.toml", False)
    assert not job(path.read_text(), tmp_path, "wedge").notes
    flipped = path.read_text().replace('"1.x" = -0.8660254037844387', '"1.x" = 0.8660254037844387')
    assert tomllib.loads(flipped) != tomllib.loads(path.read_text())
    signs, perpendicular = job(flipped, tmp_path, "wedge").notes
    assert "(blade 1, t1)" in signs
    assert "(blade 1, t1 and n)" in perpendicular


@pytest.mark.slow
def test_sectors_of_a_disk_have_axes_of_their_own(octopus):
    """The damper's far side moves along axes turned by a sector: its coefficients do not cancel, and are sound."""
    assert octopus.warnings == ()
    assert octopus.full((1,)).warnings == ()


@pytest.fixture(scope="module")
def octopus():
    return ss.rigs.octopus_blisk(modes=2)


@pytest.mark.parametrize(
    ("stiffness", "changed", "said"),
    [
        (9.0, {}, ""),
        (11.0, {}, "The preload of pad, 30 N, is an interference, of which 14.3 N are left at rest without other loads"),
        (105.0, {}, "The preload of pad, 30 N, is an interference, of which 2.61 N are left at rest"),
        (3e4, {}, "The preload of pad, 30 N, is an interference, of which nothing is left at rest"),
        (105.0, {"balanced": True}, ""),
        (9.0, {"static": -20.0}, ""),
    ],
)
def test_a_preload_that_the_structure_takes_away_is_named(stiffness, changed, said):
    """Two pads of one surface on a mass with a spring of 10 N/m: 10/(10 + kn) of the preload is left, whatever lifts them."""
    static = changed.pop("static", 0.0)
    law = ss.Macroslip(kt=0.5 * stiffness, mu=0.3, kn=0.5 * stiffness, preload=15.0)
    pads = [
        ss.Contact(
            f"pad {k}", law, (ss.between("1.x", "ground"),), ss.between("1.y", "ground"), surface=OnSurface("pad", 0.5), **changed
        )
        for k in (1, 2)
    ]
    structure = ss.Structure(np.eye(2), 10.0 * np.eye(2), ("1.x", "1.y"))
    problem = ss.Problem(structure, pads, (ss.Force("1.x", 1.0), ss.Force("1.y", 0.5, static=static)), ("1.x",))
    found = [warning for warning in problem.warnings if "preload" in warning]
    assert len(found) == bool(said)
    assert said in "".join(found)


def test_a_lost_preload_is_named_beside_a_contact_elsewhere_that_keeps_its_own():
    """Two contacts at two places, numbered because they have no names: 1/11 of 100 N is left, and most of 1000 N."""
    laws = [ss.Macroslip(kt=kn, mu=0.3, kn=kn, preload=preload) for kn, preload in ((1e6, 100.0), (1.2e3, 1000.0))]
    contacts = [
        ss.Contact(f"contact {k}", law, (ss.between(f"{node}.x", "ground"),), ss.between(f"{node}.y", "ground"))
        for k, (law, node) in enumerate(zip(laws, "ab", strict=True), start=1)
    ]
    structure = ss.Structure(np.eye(4), 1e5 * np.eye(4), ("a.x", "a.y", "b.x", "b.y"))
    (found,) = ss.Problem(structure, contacts, (ss.Force("a.x", 1.0),), ("a.x",)).warnings
    assert found.startswith("The preload of contact 1, 100 N, is an interference, of which 9.09 N are left")
