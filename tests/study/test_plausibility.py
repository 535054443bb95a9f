"""Slips of units and signs in a study are warned of, by what results from them; the study as it is meant is not.

Each slip is a factor of a thousand or a million, an exchange, or a sign, in the template of two blades and a wedge or in a mass.
"""

import re

import pytest

from stickslip.study.reading import job
from stickslip.study.templates import KINDS, write_new
from stickslip.support.checks import InputError

MASS = """
[study]
analysis = "forced_response"
[structure]
matrices = { M = [[0.5]], K = [[1.0e6]] }
dofs = ["m.x"]
[damping]
rayleigh = [2.0, 1e-6]
[[contact]]
name = "slider"
law = "macroslip"
between = ["m.x", "ground"]
kt = 2e5
mu = 0.5
normal_load = 20.0
[[force]]
direction = "m.x"
amplitude = 1.0
[sweep]
frequency = [200.0, 300.0]
outputs = ["m.x"]
"""

COS = "0.8660254037844387"

SLIPS = [
    ("static = 120.0 ", "static = 120e3 ", "no contact slips"),
    ("static = 120.0 ", "static = 0.12 ", "slip at"),
    ("amplitude = [0.0, 20.0]", "amplitude = [0.0, 20e6]", "slip at"),
    ("amplitude = [0.0, 20.0]", "amplitude = [0.0, 20e3]", "slip at"),
    ("force_levels = [0.2, 0.5, 1.0]", "force_levels = [1e6]", "slip at"),
    ("force_levels = [0.2, 0.5, 1.0]", "force_levels = [1e-6]", "no contact slips"),
    ("frequency = [145.0, 235.0]", "frequency = [1450.0, 2350.0]", "no natural frequency"),
    ("frequency = [145.0, 235.0]", "frequency = [0.145, 0.235]", "no natural frequency"),
    ("frequency = [145.0, 235.0]", "frequency = [911.0, 1476.5]", "no natural frequency"),
    ("kn = 3e5", "kn = 0.3", "Unusual ratio of normal to tangential stiffness"),
    ("kt = 3e5", "kt = 0.3", "Unusual ratio of normal to tangential stiffness"),
    (
        "kn = 3e5",
        "kn = 2e5",
        "kn is 0.67 times kt. Between elastic bodies it is 1 to 1.5 times kt. Check whether the two are exch",
    ),
    ("mu = 0.5", "mu = 50.0", "friction coefficients"),
    ('"1.x" = -0.8660254037844387', '"1.x" = 0.8660254037844387', "signs"),
    ("kn = 3e5  ", "kn = 3e5\npreload = -20.0  ", "a preload of -20 N"),
    ("kn = 3e5  ", "kn = 3e5\npreload = 100.0  ", "and a pull acts on D"),
    ('outputs = ["2.y", "1.y"]', 'outputs = ["D.y"]', "all outputs are on D"),
    (
        f'normal = {{ "D.x" = 0.5, "D.y" = {COS}, "2.x" = -0.5, "2.y" = -{COS} }}',
        f'normal = {{ "D.x" = -0.5, "D.y" = -{COS}, "2.x" = 0.5, "2.y" = {COS} }}',
        "blade 2 carries no load at rest",
    ),
]

OF_A_MASS = [
    ("mu = 0.5", "mu = 0.0", "no contact has friction"),
    ("rayleigh = [2.0, 1e-6]", "rayleigh = [1e-6, 2.0]", "Rayleigh"),
    ("rayleigh = [2.0, 1e-6]", "modal = 0.2", "20 %"),
    ("rayleigh = [2.0, 1e-6]", "modal = 2.0", "200 %"),
    ("matrices = { M = [[0.5]], K = [[1.0e6]] }", "matrices = { M = [[0.5]], K = [[1.0e6]], C = [[1.5e4]] }", "critical"),
    ("normal_load = 20.0", "normal_load = 20e3", "no contact slips"),
    ("normal_load = 20.0", "normal_load = 0.002", "slip at"),
    ("amplitude = 1.0", "amplitude = 1e6", "slip at"),
    ("K = [[1.0e6]]", "K = [[1.0e3]]", "no natural frequency"),
    ("M = [[0.5]]", "M = [[5e-4]]", "no natural frequency"),
    ("kt = 2e5", "kt = 2e11", "stiff"),
]


def notes_of(text, folder):
    return job(text, folder, "study").notes


def sentences_of(text, folder):
    """Warnings, or what a refusal says."""
    try:
        return notes_of(text, folder)
    except InputError as refused:
        return [str(refused)]


@pytest.mark.parametrize(("meant", "typed", "said"), SLIPS)
def test_slips_in_two_blades_and_a_wedge(meant, typed, said, tmp_path):
    write_new("lumped", tmp_path / "study.toml")
    text = (tmp_path / "study.toml").read_text()
    assert notes_of(text, tmp_path) == ()
    assert meant in text
    assert any(said in note for note in notes_of(text.replace(meant, typed), tmp_path))


def test_the_wiring_of_a_damper(tmp_path):
    """All forces on the damper; a contact of blade 2 with the ground in place of the damper."""
    write_new("lumped", tmp_path / "study.toml")
    text = (tmp_path / "study.toml").read_text()
    pushed = text.replace('direction = "1.y"', 'direction = "D.y"')
    assert not any("excitation acts only on" in note for note in notes_of(pushed, tmp_path))
    pushed = pushed.replace('direction = "2.x"', 'direction = "D.x"')
    assert any("excitation acts only on D" in note for note in notes_of(pushed, tmp_path))
    grounded = text.replace(f'"D.x" = {COS}, "D.y" = -0.5, "2.x"', '"2.x"').replace(f'"D.x" = 0.5, "D.y" = {COS}, "2.x"', '"2.x"')
    assert any("blade 2 carries no load at rest" in note for note in notes_of(grounded, tmp_path))


@pytest.mark.parametrize(("meant", "typed", "said"), OF_A_MASS)
def test_slips_in_one_mass(meant, typed, said, tmp_path):
    assert notes_of(MASS, tmp_path) == ()
    assert meant in MASS
    text = MASS.replace(meant, typed)
    text = text.replace("[damping]\nrayleigh = [2.0, 1e-6]\n", "") if "C = " in typed else text
    assert any(said in sentence for sentence in sentences_of(text, tmp_path))


def test_a_slider_far_beyond_what_its_contact_moves(tmp_path):
    """Free in resonance the mass moves by F/(ω C), C = 2 N s/m, and the contact yields by μN/kt = 50 µm more."""
    start = 'name = "slider"\nstart = {{ slider_offset = {} }}'
    reach = 1.0 / (2.0 * (1e6 / 0.5) ** 0.5) + 0.5 * 20.0 / 2e5
    for times in (-300.0, -90.0, 0.0, 1.0, 90.0, 300.0):
        notes = notes_of(MASS.replace('name = "slider"', start.format(times * reach)), tmp_path)
        assert len(notes) == (abs(times) > 100.0)
        far = f"{300.0 * reach:.3g} m away, 3e+02 times as far as the contact moves and yields, {reach:.3g} m"
        assert all(note.startswith(f"Warning: the slider of slider rests {far}: ") for note in notes)


def test_kn_a_little_below_kt_is_let_pass(tmp_path):
    """As a measured one may be. Directions of other lengths count with their squares: kn of 2z is a quarter of that of z."""
    write_new("lumped", tmp_path / "study.toml")
    text = (tmp_path / "study.toml").read_text()
    for kn, odd in (("2.6e5", False), ("2.4e5", True), ("8e8", True)):
        said = [note for note in notes_of(text.replace("kn = 3e5", f"kn = {kn}"), tmp_path) if "Unusual ratio" in note]
        assert bool(said) == odd
    twice = re.sub(r"normal = .*", lambda line: re.sub(r"0\.\d+", lambda part: str(2.0 * float(part[0])), line[0]), text)
    assert twice != text
    for kn, odd in (("0.65e5", False), ("0.6e5", True)):
        said = [note for note in notes_of(twice.replace("kn = 3e5", f"kn = {kn}"), tmp_path) if "Unusual ratio" in note]
        assert bool(said) == odd


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_no_template_is_warned_of_but_what_it_means(kind, tmp_path):
    """Gas forces of the flutter template feed a wave on purpose."""
    write_new(kind, tmp_path / "study.toml")
    found = [note for note in notes_of((tmp_path / "study.toml").read_text(), tmp_path) if "arning" in note or "Negative" in note]
    assert len(found) == (kind == "flutter")


def test_peaks_of_one_of_several_excited_harmonics(tmp_path):
    """The peaks of two harmonics are those of the first, unless the largest motion in time is asked for."""
    path, *_ = write_new("lumped", tmp_path / "study.toml")

    def warned(text):
        return sum("has the harmonics 1, 2" in note for note in job(text, tmp_path, "study").notes)

    text = path.read_text()
    two = f'{text}\n[[force]]\ndirection = "1.y"\namplitude = 1.0\nharmonic = 2\n'
    assert (warned(text), warned(two)) == (0, 1)
    assert warned(two.replace("[sweep]", '[sweep]\nmeasure = "max_abs"')) == 0


@pytest.mark.parametrize("first", ["", '[[force]]\ndirection = "m.x"\namplitude = 0.001\n'])
def test_the_force_of_the_second_harmonic_counts_at_its_resonance(first, tmp_path):
    """4 μN/(π F) < 0.1 with μN = 10 N from F = 127 N on; large motions at the ends of the band."""
    text = MASS.replace("[200.0, 300.0]", "[100.0, 150.0]").replace("[sweep]", '[sweep]\nmeasure = "max_abs"')
    text = text.replace('[[force]]\ndirection = "m.x"\n', f'{first}[[force]]\ndirection = "m.x"\nharmonic = 2\n')
    said = {
        force: " ".join(notes_of(text.replace("amplitude = 1.0", f"amplitude = {force}"), tmp_path)) for force in (100, 150, 1e10)
    }
    assert [force for force, notes in said.items() if "friction has almost no effect" in notes] == [150, 1e10]
    assert [force for force, notes in said.items() if "moves the stuck structure" in notes] == [1e10]


def test_a_contact_that_slips_by_the_second_harmonic_alone_is_no_slip_of_the_pen(tmp_path):
    """The second harmonic meets the resonance at half its frequency; the first hardly loads the contact there."""
    second = MASS.replace("[sweep]", '[[force]]\ndirection = "m.x"\namplitude = 5.0\nharmonic = 2\n[sweep]\nmeasure = "max_abs"')
    low = second.replace("[200.0, 300.0]", "[100.0, 150.0]").replace("amplitude = 1.0", "amplitude = 0.001")
    assert not any("no contact slips" in note for note in notes_of(low, tmp_path))
    assert any("no contact slips" in note for note in notes_of(low.replace("amplitude = 5.0", "amplitude = 0.005"), tmp_path))
