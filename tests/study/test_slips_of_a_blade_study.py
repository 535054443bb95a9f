"""Slips of units and signs in the study of two finite-element blades and a wedge damper: all but two are warned of.

Each is one wrong number or sign of someone who types such a study in mm, t and s. Sound studies, of rigs with the bands and
force levels of their examples, are not warned of.
"""

import gzip
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.model import rigs
from stickslip.study.plausibility import plausibility_warnings
from stickslip.study.reading import job
from stickslip.support.checks import InputError

DATA = Path(__file__).parents[1] / "data" / "calculix"
STUDY = """
units = "mm-t-s"
[study]
analysis = "forced_response"
[[structure]]
name = "left"
model = "platform_blade.inp"
keep = { tip = [0.0, 122.0, 0.0] }
modes = 10
[[structure]]
name = "right"
model = "platform_blade.inp"
keep = { tip = [0.0, 122.0, 0.0] }
modes = 10
shift = [40.0, 0.0, 0.0]
[[body]]
name = "damper"
shape = "wedge"
dimensions = { width = 24.0, height = 6.0, depth = 30.0, left_angle = 35.0, right_angle = 35.0 }
centre = [20.0, 52.0, 0.0]
pull = [0.0, 600.0, 0.0]
[damping]
modal = 0.002
[[contact]]
name = "L"
law = "macroslip"
surface = "left/PLATR"
against = "damper"
kt = 5e3
kn = 1e4
mu = 0.4
[[contact]]
name = "R"
law = "macroslip"
surface = "right/PLATL"
against = "damper"
kt = 5e3
kn = 1e4
mu = 0.4
[[force]]
direction = "left/tip.x"
amplitude = 1.0
[[force]]
direction = "right/tip.x"
amplitude = -1.0
[sweep]
frequency = [400.0, 750.0]
force_levels = [1.0, 5.0, 20.0, 60.0]
outputs = ["left/tip.x"]
"""

PULL = "pull = [0.0, 600.0, 0.0]"
BAND = "frequency = [400.0, 750.0]"
LEVELS = "force_levels = [1.0, 5.0, 20.0, 60.0]"
REST = "no state of rest"
CARRY = "The contacts cannot carry the static load on 'damper'"
SAID = {
    "kt in N/m": ({"kt = 5e3": "kt = 5e6"}, "Unusual ratio"),
    "kt in kN/mm": ({"kt = 5e3": "kt = 5.0"}, "yielded by"),
    "kn in N/m": ({"kn = 1e4": "kn = 1e7"}, "Unusual ratio"),
    "kn a fiftieth of kt": ({"kn = 1e4": "kn = 100.0"}, "Unusual ratio"),
    "kt and kn in N/m": ({"kt = 5e3": "kt = 5e6", "kn = 1e4": "kn = 1e7"}, REST),
    "kt and kn in kN/mm": ({"kt = 5e3": "kt = 5.0", "kn = 1e4": "kn = 10.0"}, "yielded by"),
    "pull in kN": ({PULL: "pull = [0.0, 0.6, 0.0]"}, "friction has almost no effect"),
    "pull a thousand times": ({PULL: "pull = [0.0, 600e3, 0.0]"}, "over its mass"),
    "pull of the other sign": ({PULL: "pull = [0.0, -600.0, 0.0]"}, "Loads of the opposite sign could be carried."),
    "pull along the blades' depth": ({PULL: "pull = [0.0, 0.0, 600.0]"}, CARRY),
    "wedge of 30 m": ({"depth = 30.0": "depth = 30e3"}, "heavy for its contacts"),
    "depth in m": ({"depth = 30.0": "depth = 0.03"}, "over its mass"),
    "density in kg/m3": ({"depth = 30.0": "depth = 30.0, density = 7800.0"}, "heavy for its contacts"),
    "density in g/cm3": ({"depth = 30.0": "depth = 30.0, density = 7.8"}, "heavy for its contacts"),
    "centre in m": ({"centre = [20.0, 52.0, 0.0]": "centre = [0.02, 0.052, 0.0]"}, CARRY),
    "distance of the blades in m": ({"shift = [40.0": "shift = [0.04"}, CARRY),
    "distance of the blades doubled": ({"shift = [40.0": "shift = [80.0"}, "R: the nearest face of damper is"),
    "wedge of other angles": ({"right_angle = 35.0": "right_angle = 50.0"}, "R: the nearest face of damper is"),
    "wedge below the platforms": ({"centre = [20.0, 52.0, 0.0]": "centre = [20.0, 12.0, 0.0]"}, "mm away from the middle of"),
    "normals the wrong way": ({'against = "damper"': 'against = "damper"\nfacing = [0.0, 1.0, 0.0]'}, CARRY),
    "normals turned by 90 degrees": ({'against = "damper"': 'against = "damper"\nfacing = [1.0, 0.0, 0.0]'}, CARRY),
    "preload in mN": ({"mu = 0.4": "mu = 0.4\npreload = 3e5"}, "gap of L"),
    "gap of 1 m": ({"mu = 0.4": "mu = 0.4\ngap = 1e3"}, "gap of L"),
    "mu in per cent": ({"mu = 0.4": "mu = 40.0"}, "friction coefficients"),
    "damping in per cent": ({"modal = 0.002": "modal = 0.2"}, "20 %"),
    "force in mN": ({"amplitude = ": "amplitude = 1e3 # "}, "moves the stuck structure by 383 mm"),
    "force levels in kN": ({LEVELS: "force_levels = [1e-3, 5e-3, 2e-2, 6e-2]"}, "no contact slips"),
    "band in kHz": ({BAND: "frequency = [0.4, 0.75]"}, "no natural frequency"),
    "units left out": ({'units = "mm-t-s"': ""}, "implausible, check the units"),
}
"""By what was meant: what was typed in the place of what, and what the warning says."""

UNSAID = {
    "band in rad/s, where other resonances are": {BAND: "frequency = [2513.0, 4712.0]"},
    "gap of 1 mm that the pull closes": {"mu = 0.4": "mu = 0.4\ngap = 1.0"},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("blades")
    (place / "platform_blade.inp").write_bytes((DATA / "platform_blade.inp").read_bytes())
    (place / "platform_blade.dof").write_bytes((DATA / "platform_blade.dof").read_bytes())
    for name in ("sti", "mas"):
        packed = DATA / f"platform_blade.{name}.gz"
        (place / f"platform_blade.{name}").write_bytes(gzip.decompress(packed.read_bytes()))
    return place


def typed(slips):
    text = STUDY
    for meant, wrong in slips.items():
        assert meant in text
        text = text.replace(meant, wrong)
    return text


def said(text, folder):
    """Notes of a study, or what refuses it."""
    try:
        return job(text, folder, "study").notes
    except InputError as refused:
        return (str(refused),)


def warned(notes):
    return [note for note in notes if note.startswith("Warning") or "Unusual ratio" in note or "large" in note]


def test_the_study_as_it_is_meant_is_not_warned_of(folder):
    assert not warned(said(STUDY, folder))


def test_the_body_is_described_in_the_units_of_the_study(folder):
    """A trapezium of 24 mm, 6 mm high, its flanks at 35°: mass of the prism of steel, corners about the mass centre at y = 52."""
    top = 24.0 - 2.0 * 6.0 / np.tan(np.radians(35.0))
    mass = 7.8e-9 * 30.0 * 6.0 * 0.5 * (24.0 + top)
    low = 52.0 - 6.0 / 3.0 * (24.0 + 2.0 * top) / (24.0 + top)
    (note,) = [note for note in said(STUDY, folder) if note.startswith("damper: ")]
    assert note.startswith(f"damper: {mass:.4g} t, mass centre (20, 52, 0) mm, corners of its section (8, {low:.4g}, 0), (32, ")


@pytest.mark.parametrize("name", SAID)
def test_slips_are_warned_of(name, folder):
    slips, words = SAID[name]
    assert any(words in note for note in said(typed(slips), folder))


@pytest.mark.parametrize("name", UNSAID)
def test_what_no_warning_says(name, folder):
    """Numbers that could be meant: a guard that sees one of them belongs among those above."""
    assert not warned(said(typed(UNSAID[name]), folder))


def test_a_stiff_contact_whose_stuck_mode_leaves_the_band_is_warned_of():
    """A free mode lies in the band, and at the smallest level the contact sticks: kt is 1000 times too large."""
    for kt, count in ((0.5, 0), (500.0, 1)):
        problem = rigs.single_mass(kt=kt, limit=1.0, damping=0.01)
        found = plausibility_warnings(ForcedResponseSettings(problem, ss.radians_per_second(0.8, 1.3), (0.1, 1.0, 4.0), 5, 128))
        assert len([words for words in found if "no peak in it" in words]) == count, found


H = ss.hertz
RAD = ss.radians_per_second
SOUND = {
    "blade and wedge": (lambda: rigs.blade_and_wedge(), H(280, 390), (4.0, 10.0, 30.0)),
    "blade and light wedge": (lambda: rigs.blade_and_wedge(pull=60.0, platform_angle=35.0), H(280, 390), (10.0,)),
    "three masses and a wedge": (lambda: rigs.three_mass_wedge(), H(145, 235), (0.2, 0.5, 1.0)),
    "traction at the start": (lambda: rigs.three_mass_wedge(traction_ratio=0.5), H(145, 235), (0.5,)),
    "blade root": (lambda: rigs.blade_root(pull=5e3), H(112, 125), (0.2, 1.0, 3.0, 10.0)),
    "lumped disk": (lambda: rigs.lumped_blisk("W"), H(140, 156), (0.1, 0.4, 1.6)),
    "lumped disk, second engine order": (lambda: rigs.lumped_blisk("W", engine_order=2), H(140, 156), (0.1, 0.4, 1.6)),
    "chain": (lambda: rigs.chain(masses=6, sliders=(4, 5, 6), forced=3), RAD(0.1, 0.6), (1.0, 2.0)),
    "chain of three": (lambda: rigs.chain_of_three(), RAD(0.2, 2.5), (1.0,)),
    "chain with varying load": (lambda: rigs.chain_varying_load(), RAD(0.2, 2.5), (1.0,)),
    "mass": (lambda: rigs.single_mass(damping=0.01, kt=0.5), RAD(0.5, 2.0), (0.1, 0.5, 1.0, 2.0)),
    "mass without own stiffness of note": (lambda: rigs.single_mass(kt=1.0, limit=1.0, force=1.0), RAD(0.5, 2.0), (1.0,)),
    "jointed mode": (lambda: rigs.jointed_mode(), H(65, 90), (1.0,)),
    "ring damper": (lambda: rigs.ring_damper(), H(550, 590), (0.1, 0.5, 1.0, 2.0, 4.0, 8.0)),
    "strip damper": (lambda: rigs.strip_damper(pull=600.0), H(484, 503), (1.0, 2.0, 5.0, 10.0)),
    "two semi-cylinders": (lambda: rigs.two_semi_cylinders(pull=56.0), H(400, 520), (5.0,)),
    "two oiled semi-cylinders": (lambda: rigs.two_semi_cylinders(26.0, 0.1), H(400, 520), (5.0,)),
    "shrouded blades": (lambda: rigs.shrouded_blades(untwist=20.0), H(235, 266), (20.0, 50.0, 100.0, 150.0)),
}


@pytest.mark.parametrize("name", SOUND)
def test_sound_studies_are_not_warned_of(name):
    make, band, levels = SOUND[name]
    problem = make()
    assert not plausibility_warnings(ForcedResponseSettings(problem, band, levels, 5, 128))
    assert not warned(problem.warnings)
