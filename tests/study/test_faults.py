"""Wrong study files are refused with what, rule, value and remedy; all faults of a file at once."""

from contextlib import suppress

import numpy as np
import pytest
from each import each

import stickslip as ss
from stickslip.study import job, read
from stickslip.support.checks import Faults, InputError

GOOD = """
[study]
analysis = "forced_response"
[structure]
matrices = { M = [[1.0, 0.0], [0.0, 2.0]], K = [[2.0, -1.0], [-1.0, 1.0]], C = [[0.1, 0.0], [0.0, 0.1]] }
dofs = ["1.x", "2.x"]
[[contact]]
law = "macroslip"
between = ["1.x", "ground"]
kt = 0.5
mu = 1.0
normal_load = 1.0
[[force]]
direction = "2.x"
amplitude = 1.0
[sweep]
frequency = [0.1, 0.3]
harmonics = 5
samples = 256
outputs = ["2.x"]
"""

ONE_CHANGE = [
    ('analysis = "forced_response"', 'analysis = "forced_respons"', "'forced_respons'. Did you mean 'forced_response'?"),
    ('analysis = "forced_response"', "", "analysis must be given, but is missing"),
    ("[0.0, 2.0]]", "[0.0, nan]]", "M, entry 2, entry 2 must be finite, but is nan"),
    ("M = [[1.0, 0.0], [0.0, 2.0]]", "M = [[1.0, 0.0]]", "M must be a square matrix, but is (1, 2)"),
    ("M = [[1.0, 0.0], [0.0, 2.0]]", "M = [[1.0, 0.0], [0.0]]", "M must have rows of one length, but is [2, 1]"),
    ("[2.0, -1.0]", "[2.0, -1.5]", "K must be symmetric, but is 'K[0, 1] = -1.5 against K[1, 0] = -1'"),
    ("[0.0, 2.0]]", "[0.0, -2.0]]", "M must have no negative eigenvalue"),
    ('dofs = ["1.x", "2.x"]', 'dofs = ["1.x", "1.x"]', "dofs must be unique, but '1.x' is given"),
    ('dofs = ["1.x", "2.x"]', 'dofs = ["1.x"]', "dofs, the names of the rows of M, must have 2 entries, but is 1"),
    ('dofs = ["1.x", "2.x"]', "", "matrices and dofs must be given together, but only matrices is"),
    ("K = [[2.0, -1.0], [-1.0, 1.0]]", "K = [[1.0, -1.0], [-1.0, 0.5]]", "is of negative stiffness"),
    ('law = "macroslip"', 'law = "macrslip"', "'macrslip'. Did you mean 'macroslip'?"),
    ('law = "macroslip"', "", "law must be given, but is 'missing'"),
    ('"ground"', '"gruond"', "between: degree of freedom 'gruond' does not exist. Did you mean 'ground'?"),
    ('between = ["1.x", "ground"]', 'between = ["1.x", "1.x"]', "must join two different places"),
    ('between = ["1.x", "ground"]', "", "between or tangential or surface must be given, but is missing"),
    ('between = ["1.x", "ground"]', 'between = ["1.x"]', "between must have 2 entries or more, but is ['1.x']"),
    ("kt = 0.5", "kt = -0.5", "[[contact]] 1: kt must be above 0, but is -0.5"),
    ("kt = 0.5", 'kt = "0.5"', "kt must be a number, but is '0.5'"),
    ("kt = 0.5", "kt = 2026-01-02", "kt must be a number, but is the date or time 2026-01-02."),
    ("kt = 0.5", "kt = true", "kt must be a number, but is true."),
    ("kt = 0.5", "kt = nan", "kt must be"),
    ("kt = 0.5", "kt = 0.5\nktt = 1", "key must be a known one, but is 'ktt'. Did you mean 'kt'?"),
    ("kt = 0.5", "kt = 0.5\nkt2 = 1", "must have a second tangential direction for its kt2, but is '1 direction'"),
    ("mu = 1.0", "mu = -1.0", "mu must be at least 0, but is -1.0"),
    ("normal_load = 1.0", "", "kn or normal_load must be given, but is missing"),
    ("normal_load = 1.0", "normal_load = 1.0\nkn = 1.0", "kn and normal must be given together, but only kn is"),
    ("normal_load = 1.0", "normal_load = 1.0\nbalanced = true", "balanced must go with a normal direction"),
    ("normal_load = 1.0", "normal_load = 1.0\nstart = { traction_ratio = 1.5 }", "traction_ratio must be at most 1, but is 1.5"),
    ("normal_load = 1.0", "normal_load = 1.0\nstart = { slider_ofset = 0.0 }", "'slider_ofset'. Did you mean 'slider_offset'?"),
    ("normal_load = 1.0", "normal_load = 1.0\nstart = { }", "start must name exactly one rule"),
    (
        "normal_load = 1.0",
        "normal_load = 1.0\nstart = { slider_offset = [0, 1] }",
        "an entry per direction (1) or per element (1)",
    ),
    ('direction = "2.x"', 'direction = "3.x"', "[[force]] 1: direction: degree of freedom '3.x' does not exist"),
    ('direction = "2.x"', "", "[[force]] 1: direction must be given"),
    ("amplitude = 1.0", "amplitude = [1.0, 2.0, 3.0]", "amplitude must have at most 2 entries"),
    ("amplitude = 1.0", "static = 1.0", "forces must contain a harmonic force, but is 'none'"),
    ("amplitude = 1.0", "amplitude = 1.0\nharmonic = 7", "harmonics must reach the load's harmonic 7, but is 5"),
    ("frequency = [0.1, 0.3]", "frequency = [0.1, 0.1]", "frequency must have two different ends, but is [0.1, 0.1]"),
    ("frequency = [0.1, 0.3]", "frequency = [-0.1, 0.3]", "frequency, entry 1 must be above 0, but is -0.1"),
    ("frequency = [0.1, 0.3]", "frequency = []", "frequency must have 2 entries or more, but is []"),
    ("frequency = [0.1, 0.3]", "", "frequency or at must be given, but is missing"),
    ("frequency = [0.1, 0.3]", "frequency = [0.1, 0.3]\nat = [0.1]", "frequency and at must not be given together"),
    ("harmonics = 5", "harmonics = 2.5", "harmonics must be a whole number, but is 2.5"),
    ("samples = 256", "samples = 10", "samples must be at least 4 x harmonics + 2 = 22, but is 10"),
    ("harmonics = 5", "force_levels = [1.0, 0.0]", "force_levels, entry 2 must be above 0, but is 0.0"),
    ('outputs = ["2.x"]', 'outputs = ["2.y"]', "outputs: degree of freedom '2.y' does not exist. Did you mean '2.x'?"),
    ('outputs = ["2.x"]', "", "outputs must be given, but is missing"),
    ("[sweep]", "[swep]", "table must be a known one, but is 'swep'. Did you mean 'sweep'?"),
    ("[[force]]", "[force]", "[force] must be written with double brackets"),
    ("[sweep]", "[[sweep]]", "[[sweep]] must be written with single brackets"),
    ("[sweep]", '[base]\ndirection = "x"\nacceleration = 0.0\n[sweep]', "[base]: The acceleration of the base must not be zero"),
    ("[study]", 'units = "mm-t"\n[study]', "units: The system must be a known one, but is 'mm-t'. Did you mean 'mm-t-s'?"),
    (
        "[sweep]",
        '[damping]\nmodal = 0.01\non = "stuk"\n[sweep]',
        "on must be 'stuck' or 'free', but is 'stuk'. Did you mean 'stuck'?",
    ),
    ("[sweep]", "[damping]\nmodal = 0.01\n[sweep]", "Damping must be given once, but the structure has a matrix C"),
    ("[sweep]", "[damping]\nmodal = 0.01\nrayleigh = [1, 1]\n[sweep]", "modal and rayleigh must not be given together"),
    ("[sweep]", "[damping]\n[sweep]", "modal or rayleigh must be given, but is missing"),
    ("amplitude = 1.0", "amplitude = 1e-200", "Size of Force.amplitude of harmonic 1 must be at least 1e-40, but is 1e-200"),
    ("amplitude = 1.0", "amplitude = 1e200", "must not be larger than 1e+40 in size, but is 1e+200. Check its unit."),
    ("amplitude = 1.0", "amplitude = 1.0\nstatic = -1e200", "[[force]] 1: static must not be larger than 1e+40 in size"),
    ("frequency = [0.1, 0.3]", "frequency = [1e-300, 0.3]", "[sweep]: frequency, entry 1 must be at least 1e-40"),
    ("frequency = [0.1, 0.3]", "at = [0.1, 1e300]", "[sweep]: at, entry 2 must not be larger than 1e+40 in size"),
    ("frequency = [0.1, 0.3]", "at = [0.1, 0.2, 0.2]", "Frequencies beside each other must be unique, but 0.2 is given"),
    ("harmonics = 5", "force_levels = [1.0, 2.0, 1.0]", "Force levels must be unique, but 1.0 is given"),
    ("harmonics = 5", "force_levels = [1e300]", "[sweep]: force_levels, entry 1 must not be larger than 1e+40 in size"),
    ("[2.0, -1.0]", "[2e300, -1.0]", "matrices, K, entry 1, entry 1 must not be larger than 1e+40 in size"),
    (
        "K = [[2.0, -1.0], [-1.0, 1.0]]",
        "K = [[-9.0, 0.0], [0.0, -8.0]]",
        "(eigenvalues from -8.5 to -8 N/m). Turn the sign of K.",
    ),
    ('["1.x", "ground"]', '["ground", "ground"]', "must join two different places, but is ['ground', 'ground']"),
    ('["1.x", "ground"]', '["1.x", "ground"]\nname = "a\\u0000b"', "must hold no control characters, but is 'a\\x00b'"),
    ("[study]", '[study]\ntitle = "a\\u0000b"', "title must hold no control characters, but is 'a\\x00b'"),
    ('"2.x"]\n[[', '"2.\\u0001x"]\n[[', "A name in dofs must hold no control characters"),
    ('outputs = ["2.x"]', 'outputs = ["2.x", "2.x"]', "Names of outputs must be unique, but '2.x' is given"),
    (
        'direction = "2.x"',
        'direction = "ground"',
        "[[force]] 1: direction: must be a degree of freedom, which moves, but is 'ground'.",
    ),
    ("[study]", "[study", "must be valid TOML, but is not"),
    ("[study]", "study = 3\n[studies]", "[study]: The table must be a table, but is 3"),
]


def test_the_good_file_is_good(tmp_path):
    assert job(GOOD, tmp_path, "good").title == "good"


@each(("old", "new", "said"), ONE_CHANGE, ids=[change[2][:50] for change in ONE_CHANGE])
def test_one_fault_is_named(tmp_path, old, new, said):
    assert old in GOOD
    with pytest.raises(InputError) as raised:
        job(GOOD.replace(old, new, 1), tmp_path, "study")
    assert said in str(raised.value)


def test_a_structure_that_nothing_holds_is_refused(tmp_path):
    text = GOOD.replace("K = [[2.0, -1.0], [-1.0, 1.0]]", "K = [[1.0, -1.0], [-1.0, 1.0]]")
    floating = text.replace('between = ["1.x", "ground"]', 'between = ["1.x", "2.x"]')
    with pytest.raises(InputError, match="held by nothing"):
        job(floating, tmp_path, "floating")
    assert job(text, tmp_path, "held by its contact").sweep.problem


ALONG = 'tangential = [{ "1.x" = 1.0 }]\nnormal = { "2.x" = 1.0 }'
VARYING = GOOD.replace("normal_load = 1.0", "kn = 0.5\npreload = 1.0").replace('between = ["1.x", "ground"]', ALONG)


@pytest.mark.parametrize(("text", "limit"), [(GOOD, 1e4), (VARYING, 1e2)], ids=["constant load", "varying load"])
def test_a_contact_far_stiffer_than_the_structure(tmp_path, text, limit):
    """Stuck, it works at any stiffness; where it slips or lifts off, random problems are lost from these ratios on (measured)."""
    usual = job(text, tmp_path, "usual")
    assert usual.notes == ()
    problem = usual.sweep.problem
    row, others = problem.B[0], problem.contact_stiffness.copy()
    others[0] = 0.0
    beside = problem.structure.K + problem.B.T @ (others[:, None] * problem.B)
    joined = 1.0 / (row @ np.linalg.solve(beside, row))  # the static stiffness, at the contact, of all that it joins
    assert problem.stiffness_ratios[0] == pytest.approx(0.5 / joined)
    below = job(text.replace("kt = 0.5", f"kt = {0.99 * limit * joined}"), tmp_path, "not too stiff").notes
    assert not [note for note in below if "Very stiff" in note]
    for kt in (1.01 * limit * joined, 5e11):
        note = job(text.replace("kt = 0.5", f"kt = {kt}"), tmp_path, "stiff").notes[0]  # then that kn is left behind
        assert f"Very stiff contacts (contact 1): up to {kt / joined:.2g} times what they join." in note
        assert note.endswith(f"a stuck contact is then rigid to within one part in {limit:g}.")
    with pytest.raises(InputError, match="so stiff that rounding hides the structure"):
        job(text.replace("kt = 0.5", "kt = 5e15"), tmp_path, "far too stiff")


def test_stiff_contacts_side_by_side_do_not_pass_for_soft(tmp_path):
    """What one of two equal contacts joins counts the other, but no stiffer than the structure (its largest entry, 2 N/m)."""
    first = GOOD[GOOD.index("[[contact]]") : GOOD.index("[[force]]")].replace("kt = 0.5", "kt = 5e6")
    problem = job(GOOD.replace("kt = 0.5", "kt = 5e6").replace("[[force]]", first + "[[force]]"), tmp_path, "two")
    joined = 2.0 + (2.0 - 1.0)  # the other contact, and K with the second mass following: 2 - (-1)^2 / 1
    np.testing.assert_allclose(problem.sweep.problem.stiffness_ratios, 5e6 / joined, rtol=1e-9)
    assert "(contact 1, contact 2)" in problem.notes[0]


def test_a_body_that_a_contact_alone_holds_is_no_stiff_contact(tmp_path):
    text = GOOD.replace("K = [[2.0, -1.0], [-1.0, 1.0]]", "K = [[0.0, 0.0], [0.0, 1.0]]")
    held = job(text, tmp_path, "held by its contact")
    assert np.isposinf(held.sweep.problem.stiffness_ratios).all()
    assert held.notes == ()


def test_a_structure_of_negative_stiffness_that_its_contact_holds_is_computed():
    """K = -0.5 N/m with a slider of 1 N/m that sticks: a mass on 0.5 N/m."""
    contact = ss.Contact("slider", ss.Macroslip(1.0, 0.3, normal_load=1.0), (ss.between("1.x", "ground"),))
    structure = ss.Structure(np.eye(1), -0.5 * np.eye(1), ("1.x",), C=0.02 * np.eye(1))
    problem = ss.Problem(structure, (contact,), (ss.Force("1.x", 1e-3),), ("1.x",))
    assert np.isposinf(problem.stiffness_ratios).all()
    assert not problem.warnings
    dataset = ss.forced_response(problem, ss.radians_per_second(0.5, 0.9), harmonics=1, samples=64).dataset
    omega = 2.0 * np.pi * dataset.frequency.values[0]
    np.testing.assert_allclose(dataset.amplitude.values[0, :, 0], 1e-3 / np.abs(0.5 - omega**2 + 0.02j * omega), rtol=1e-6)


def test_large_friction_of_contacts_that_may_lift_off(tmp_path):
    """Where a load varies, random problems are lost from mu = 2 on (measured); a constant load has no such limit."""
    assert job(VARYING.replace("mu = 1.0", "mu = 1.99"), tmp_path, "usual").notes == ()
    (note,) = job(GOOD.replace("mu = 1.0", "mu = 1e4"), tmp_path, "constant load").notes
    assert "the curve may stop" not in note
    (note,) = job(VARYING.replace("mu = 1.0", "mu = 1e4"), tmp_path, "large").notes
    assert note.startswith(
        "Large friction coefficients (contact 1): up to mu = 1e+04. Where such contacts lift off, the curve may stop."
    )
    both = job(VARYING.replace("mu = 1.0", "mu = 2.0").replace("kt = 0.5", "kt = 5e6"), tmp_path, "both").notes
    assert [words.split(" (")[0] for words in both] == [
        "Very stiff contacts",
        "Large friction coefficients",
        "Unusual ratio of normal to tangential stiffness",
    ]


def test_all_faults_are_named_at_once(tmp_path):
    text = GOOD
    changes = ["kt = -0.5", '"gruond"', "[2.0, -1.5]", 'outputs = ["2.y"]', "frequency = [-0.1, 0.3]", "mu = -1.0"]
    for new in changes:
        old, _, said = next(change for change in ONE_CHANGE if change[1] == new)
        text = text.replace(old, new, 1)
    with pytest.raises(Faults) as raised:
        job(text, tmp_path, "study")
    assert len(raised.value.faults) == len(changes)
    for new in changes:
        said = next(change for change in ONE_CHANGE if change[1] == new)[2]
        assert any(said in fault for fault in raised.value.faults)


def test_names_are_compared_whatever_else_is_wrong(tmp_path):
    text = GOOD.replace('dofs = ["1.x", "2.x"]', 'dofs = ["1.x", "1.x"]').replace("[2.0, -1.0]", "[2.0, -1.5]")
    with pytest.raises(Faults) as raised:
        job(text, tmp_path, "study")
    assert any("dofs must be unique, but '1.x' is given" in message for message in raised.value.faults)
    assert any("K must be symmetric" in message for message in raised.value.faults)


def test_one_entry_is_singular(tmp_path):
    text = GOOD.replace("M = [[1.0, 0.0], [0.0, 2.0]]", "M = [[1.0]]")
    with pytest.raises(InputError, match="rows of M, must have 1 entry, but is 2"):
        job(text, tmp_path, "study")


def test_matrices_that_are_a_folder_or_hold_texts(tmp_path):
    text = GOOD.replace("matrices = {", 'matrices = "a.npz" # {')
    (tmp_path / "a.npz").mkdir()
    with pytest.raises(InputError, match=r"must be a file, but is .*, a folder"):
        job(text, tmp_path, "study")
    (tmp_path / "a.npz").rmdir()
    np.savez(tmp_path / "a.npz", M=np.eye(2), K=np.array([["2", "0"], ["0", "2"]]))
    with pytest.raises(InputError, match="K must hold real numbers, but is '<U1'"):
        job(text, tmp_path, "study")


RIG = """
[study]
analysis = "forced_response"
[structure]
rig = "single_mass"
[structure.parameters]
kt = 2.0
[sweep]
frequency = [0.08, 0.32]
"""


@each(
    ("old", "new", "said"),
    [
        ("single_mass", "single_mas", "rig must be a known one, but is 'single_mas'. Did you mean 'single_mass'?"),
        ("kt = 2.0", "ktt = 2.0", "parameters, key must be a known one, but is 'ktt'. Did you mean 'kt'?"),
        ("kt = 2.0", "kt = -2.0", "kt must be positive, but is -2.0"),
        ("kt = 2.0", 'kt = "much"', "must be a number, but is 'much'"),
        ("kt = 2.0", "start = { slidr = 1 }", "parameters, key must be a known one, but is 'start'"),
        ("[sweep]", '[[force]]\nat = "1.x"\n[sweep]', "force must go with matrices, but stands beside a rig"),
        ("[sweep]", '[sweep]\noutputs = ["9.x"]', "outputs: degree of freedom '9.x' does not exist"),
        ('"single_mass"', '"single_mass"\nmodes = 3\nown_damping = false', "modes and own_damping must go with a model"),
        ('"single_mass"', '"single_mass"\nmatrices = "a.npz"', "rig and matrices must not be given together"),
    ],
)
def test_faults_beside_a_rig(tmp_path, old, new, said):
    assert job(RIG, tmp_path, "rig").sweep.problem.contact_stiffness == pytest.approx([2.0])
    with pytest.raises(InputError) as raised:
        job(RIG.replace(old, new, 1), tmp_path, "rig")
    assert said in str(raised.value)


def test_files_that_are_no_studies(tmp_path):
    with pytest.raises(InputError, match="must exist"):
        read(tmp_path / "missing.toml")
    with pytest.raises(InputError, match="must be a file"):
        read(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="UTF-8"):
        read(tmp_path / "binary.toml")
    (tmp_path / "deep.toml").write_text("a = " + "[" * 5000)
    with pytest.raises(InputError, match="valid TOML"):
        read(tmp_path / "deep.toml")


@each("seed", range(20))
def test_a_file_cut_or_scrambled_anywhere_is_refused_or_read(tmp_path, seed):
    """Nothing but InputError comes out, whatever a line is replaced by."""
    rng = np.random.default_rng(seed)
    lines = GOOD.splitlines()
    for position in rng.integers(len(lines), size=3):
        key = lines[position].partition("=")[0]
        lines[position] = rng.choice(
            ["", "[[contact]]", f"{key} = []", f"{key} = {{}}", f"{key} = [[[1]]]", f"{key} = 'x'", f"{key} = inf"]
        )
    with suppress(InputError):
        assert job("\n".join(lines), tmp_path, "study").sweep.problem


SECOND = """[[contact]]
law = "macroslip"
between = ["2.x", "ground"]
kt = -0.5 # wrong
mu = 1.0
normal_load = 1.0
"""


def line(text, part):
    return next(number for number, line in enumerate(text.splitlines(), start=1) if part in line)


@each(
    ("old", "new", "at"),
    [
        ("kt = 0.5", "kt = true", "kt ="),
        ("kt = 0.5", "# kt = 1\nktt = 0.5", "ktt"),
        ("[sweep]", "[swep]", "[swep]"),
        ("[[force]]", "[force]", "[force]"),
        ("samples = 256", "samples = 10", "samples"),
        ('outputs = ["2.x"]', 'outputs = [\n"2.y"\n]', "outputs"),
        ("kt = 0.5\n", "", "[[contact]]"),
        ("[study]", 'units = "mm-t"\n[study]', "units"),
        ("[[force]]", SECOND + "[[force]]", "# wrong"),
        ("matrices = {", "unknown.key = 3\nmatrices = {", "unknown"),
        ("[[contact]]", "[structure.keep]\ntips = 3\n[[contact]]", "[structure.keep]"),
    ],
)
def test_a_fault_has_the_line_of_its_key(tmp_path, old, new, at):
    text = GOOD.replace(old, new, 1)
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(Faults) as raised:
        read(tmp_path / "study.toml")
    assert any(message.startswith((f"Line {line(text, at)},", f"Line {line(text, at)}:")) for message in raised.value.faults)


def test_what_lies_on_no_line_has_none(tmp_path):
    (tmp_path / "study.toml").write_text(GOOD.replace("[study]\n", "[study]\ntitle = 'sweep'\n").partition("[sweep]")[0])
    with pytest.raises(Faults, match=r"^\[sweep\] must be given, but is missing"):
        read(tmp_path / "study.toml")


def test_a_mistyped_name_of_a_file_gets_the_one_beside_it(tmp_path):
    text = RIG.replace('rig = "single_mass"', 'model = "blde.npz"').replace("[structure.parameters]\nkt = 2.0\n", "")
    (tmp_path / "blade.toml").write_text(text)
    (tmp_path / "blade.npz").touch()
    with pytest.raises(InputError, match=r"must be a file that exists.*Did you mean 'blade.npz'\?"):
        read(tmp_path / "blade.toml")
    with pytest.raises(InputError, match=r"must exist.*Did you mean 'blade.toml'\?"):
        read(tmp_path / "blede.toml")
    with pytest.raises(InputError, match=r"The folder '.*none' does not exist\."):
        read(tmp_path / "none" / "blade.toml")
    with pytest.raises(InputError, match=r"must exist, but is '.*results.nc'. `stickslip run STUDY"):
        ss.open_results(tmp_path / "results.nc")


AERODYNAMIC = """
[study]
analysis = "limit_cycles"
[structure]
rig = "lumped_blisk"
parameters = { sectors = 6 }
[aerodynamics]
influence = [[0, 0.0, 240.0], [1, -600.0, -200.0], [-1, 600.0, -200.0]]
frequency = 152.7
direction = "tip.t"
[sweep]
frequency = [150.0, 155.0]
"""


def test_a_study_has_the_aerodynamics_of_its_table(tmp_path):
    disk = job(AERODYNAMIC, tmp_path, "flutter").sweep.problem
    (gas,) = disk.wave_stiffnesses
    order = np.arange(6)
    turn = np.exp(-2j * np.pi * order / 6)
    np.testing.assert_allclose(gas.waves, 240j + (-600 - 200j) * turn + (600 - 200j) * turn.conj(), rtol=1e-12, atol=1e-9)
    assert gas.omega == pytest.approx(2.0 * np.pi * 152.7, rel=1e-15)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("[-1, 600.0, -200.0]", "[1, 600.0, -200.0]", "influence must hold every blade once"),
        ("[-1, 600.0, -200.0]", "[-1.5, 600.0, -200.0]", "must be a whole number"),
        ("[-1, 600.0, -200.0]", "[9, 600.0, -200.0]", "on a disk of 6 sectors"),
        ("frequency = 152.7", "", "frequency must be given with a direction"),
        ('direction = "tip.t"', 'direction = "tip.x"', "tip.x"),
        ('direction = "tip.t"', "damping_ratio = [0.1]", "damping_ratio"),
        ('rig = "lumped_blisk"\nparameters = { sectors = 6 }', 'rig = "single_mass"', "must be a tuned disk"),
    ],
)
def test_wrong_aerodynamics_of_a_study_are_refused(before, after, words, tmp_path):
    assert before in AERODYNAMIC
    with pytest.raises(InputError, match=words):
        job(AERODYNAMIC.replace(before, after, 1), tmp_path, "flutter")
