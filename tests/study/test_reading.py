"""A study file becomes the problem that it describes: contacts, starts, forces, damping, units, matrices."""

import numpy as np
import pytest
from scipy import io, sparse

import stickslip as ss
from stickslip.study import job, read
from stickslip.support.checks import InputError

HEAD = """
[study]
title = "A title"
analysis = "forced_response"
"""
FOUR = """
[structure]
matrices = "four.npz"
dofs = ["1.x", "1.y", "2.x", "2.rz"]
"""
TAIL = """
[[force]]
direction = "1.x"
amplitude = [1.0, -2.0]
static = 3.0
[sweep]
at = [0.1, 0.2]
force_levels = [1, 2.5]
outputs = ["1.x", { name = "rim", direction = { "2.x" = 1.0, "2.rz" = 0.5 } }]
"""
SPRING = '[[contact]]\nlaw = "gap"\nbetween = ["1.x", "ground"]\nkn = 1.0\n'


@pytest.fixture
def folder(tmp_path):
    M, K = np.diag([1.0, 2.0, 3.0, 4.0]), 10.0 * np.eye(4) - np.ones((4, 4))
    np.savez(tmp_path / "four.npz", M=M, K=K, other=np.ones(3))
    return tmp_path


def made(folder, contacts=SPRING, head=HEAD, tail=TAIL, structure=FOUR):
    return job(head + structure + contacts + tail, folder, "study")


def test_settings_forces_and_outputs(folder):
    study = made(folder)
    assert (study.title, study.sweep.levels, study.sweep.harmonics, study.sweep.samples) == ("A title", (1.0, 2.5), 5, 256)
    assert study.sweep.band == [0.1, 0.2]
    assert study.sweep.problem.load(1, 2.0)[0].tolist() == [3.0, 2.0, 4.0]
    assert study.sweep.problem.output_names == ("1.x", "rim")
    assert study.sweep.problem.output_rows.tolist() == [[1, 0, 0, 0], [0, 0, 1, 0.5]]
    assert study.text == HEAD + FOUR + SPRING + TAIL


def test_a_band_and_a_higher_harmonic(folder):
    study = made(folder, tail=TAIL.replace("at = [0.1, 0.2]", "frequency = [0.2, 0.1]").replace("static = 3.0", "harmonic = 3"))
    assert study.sweep.band == ss.hertz(0.2, 0.1)
    assert study.sweep.problem.load(3)[0].tolist() == [0, 0, 0, 0, 0, 1.0, 2.0]


def test_contacts_of_every_law(folder):
    contacts = """
[[contact]]
name = "slider"
law = "macroslip"
between = ["1.x", "2.x"]
kt = 2
mu = 0.5
normal_load = 3.0
[[contact]]
law = "macroslip"
tangential = [["1.x", "ground"], { "2.x" = 0.6, "1.x" = -0.6 }]
normal = ["1.y", "ground"]
kt = 2.0
kt2 = 2.5
kn = 3.0
mu = 0.5
preload = 4.0
gap = 0.1
balanced = true
[[contact]]
law = "microslip_array"
tangential = ["1.x", "ground"]
normal = ["1.y", "ground"]
kt = 6.0
kn = [1.0, 2.0, 3.0]
mu = 0.5
preload = 3.0
largest_gap = 0.2
[[contact]]
law = "gap"
normal = { "1.y" = -1.0 }
kn = 5.0
gap = 0.3
"""
    slider, both, array, stop = made(folder, contacts).sweep.problem.contacts
    assert slider.name == "slider"
    assert slider.law == ss.Macroslip(2.0, 0.5, normal_load=3.0)
    assert slider.tangential == ({"1.x": 1.0, "2.x": -1.0},)
    assert both.name == "contact 2"
    assert both.balanced
    assert both.law == ss.Macroslip(2.0, 0.5, 3.0, 4.0, 0.1, kt2=2.5)
    assert both.tangential == ({"1.x": 1.0}, {"2.x": 0.6, "1.x": -0.6})
    assert array.law == ss.MicroslipArray((2.0, 2.0, 2.0), 0.5, (1.0, 2.0, 3.0), (0.0, 0.1, 0.2), (1.0, 1.0, 1.0))
    assert stop.law == ss.Gap(5.0, 0.3)
    assert stop.normal == {"1.y": -1.0}


def test_laws_with_kernels_of_their_own(folder):
    """In the units of the file: v0 in mm/s."""
    contacts = """
[units]
length = "mm"
[[contact]]
law = "dahl"
between = ["1.x", "2.x"]
kt = 2.0
mu = 0.5
normal_load = 3.0
[[contact]]
law = "tanh_coulomb"
tangential = [["1.x", "ground"], ["2.x", "ground"]]
normal = ["1.y", "ground"]
mu = 0.4
v0 = 20.0
kn = 3.0
preload = 4.0
"""
    dahl, tanh = made(folder, contacts).sweep.problem.contacts
    assert dahl.law == ss.Dahl(2e3, 0.5, normal_load=3.0)
    assert tanh.law == ss.TanhCoulomb(0.4, 0.02, 3e3, 4.0)
    assert len(tanh.tangential) == 2


ARRAY = """
[[contact]]
law = "microslip_array"
tangential = {tangential}
kt = 6.0
elements = {elements}
normal_load = 3.0
mu = 0.5
start = {start}
"""
IWAN = """
[[contact]]
law = "iwan"
between = ["1.x", "ground"]
kt = 6.0
mu = 0.5
normal_load = 3.0
"""
ONE, TWO = '["1.x", "ground"]', '[["1.x", "ground"], ["1.y", "ground"]]'


@pytest.mark.parametrize(
    ("tangential", "elements", "start", "expected"),
    [
        (ONE, 3, "{ slider_offset = 0.1 }", [ss.SliderOffset(0.1)]),
        (ONE, 3, "{ slider_offset = [0.1, 0.2, 0.3] }", [ss.SliderOffset([0.1, 0.2, 0.3])]),
        (TWO, 3, "{ traction_ratio = [0.1, 0.2] }", [ss.TractionRatio(0.1), ss.TractionRatio(0.2)]),
        (TWO, 3, "{ mean_traction = [1, 2, 3] }", [ss.MeanTraction([1.0, 2.0, 3.0])] * 2),
        (TWO, 2, "{ mean_traction = [[1, 2], 3] }", [ss.MeanTraction([1.0, 2.0]), ss.MeanTraction(3.0)]),
        (TWO, 3, "[{ slider_offset = 0.1 }, { traction_ratio = 0.5 }]", [ss.SliderOffset(0.1), ss.TractionRatio(0.5)]),
    ],
)
def test_start_rules(folder, tangential, elements, start, expected):
    contact = made(folder, ARRAY.format(tangential=tangential, elements=elements, start=start)).sweep.problem.contacts[0]
    assert list(contact.starts) == expected


def test_an_ambiguous_start_is_refused(folder):
    with pytest.raises(InputError, match="2 directions or elements"):
        made(folder, ARRAY.format(tangential=TWO, elements=2, start="{ slider_offset = [0.1, 0.2] }"))


def test_units_are_those_of_the_same_model_in_si(folder):
    """A model in mm, t, s against the same in SI; the rotation's row carries a length more."""
    contacts = """
[[contact]]
law = "macroslip"
tangential = { "2.x" = 1.0, "2.rz" = LEVER }
normal = ["1.y", "ground"]
kt = STIFFNESS
kn = STIFFNESS
mu = 0.5
preload = 7.0
gap = LENGTH
start = { slider_offset = LENGTH }
[damping]
rayleigh = [0.3, 0.01]
"""
    in_mm = contacts.replace("STIFFNESS", "5.0").replace("LENGTH", "0.25").replace("LEVER", "20.0")
    in_si = contacts.replace("STIFFNESS", "5e3").replace("LENGTH", "0.25e-3").replace("LEVER", "20e-3")
    M, K = np.diag([1e-3, 2e-3, 3e-3, 400.0]), np.array([[5.0, -1, 0, 0], [-1, 5, 0, 0], [0, 0, 6.0, 30.0], [0, 0, 30.0, 900.0]])
    lever = np.diag([1, 1, 1, 1e-3])
    np.savez(folder / "si.npz", M=1e3 * lever @ M @ lever, K=1e3 * lever @ K @ lever)
    np.savez(folder / "mm.npz", M=M, K=K)
    tail_mm = TAIL.replace('"2.rz" = 0.5', '"2.rz" = 500.0')
    mm = made(folder, in_mm, 'units = "mm-t-s"' + HEAD, tail_mm, FOUR.replace("four", "mm")).sweep.problem
    si = made(folder, in_si, HEAD, TAIL, FOUR.replace("four", "si")).sweep.problem
    for key in ("M", "K", "C", "B", "contact_stiffness", "output_rows"):
        ours, theirs = (getattr(problem if hasattr(problem, key) else problem.structure, key) for problem in (mm, si))
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-15, err_msg=key)
    np.testing.assert_allclose(mm.load(1), si.load(1))
    assert mm.contacts[0].law.preload == si.contacts[0].law.preload == 7.0
    assert mm.contacts[0].law.gap == pytest.approx(0.25e-3)
    assert mm.contacts[0].starts[0].value == pytest.approx(0.25e-3)


def test_units_one_by_one(folder):
    units = 'units = { length = "um", force = "kN", mass = "g", time = "ms" }'
    problem = made(folder, head=units + HEAD).sweep.problem
    assert problem.structure.K[0, 0] == pytest.approx(9e9)
    assert problem.structure.M[0, 0] == pytest.approx(1e-3)
    assert problem.contacts[0].law.kn == pytest.approx(1e9)
    assert problem.load(1)[0].tolist() == pytest.approx([3e3, 1e3, 2e3])


def test_frequencies_in_radians_per_second(folder):
    """Bands, lists, with matrices and with a ready rig; the same as in Hz."""
    units = 'units = { frequency = "rad/s" }'
    assert made(folder, head=units + HEAD).sweep.band == pytest.approx([0.1 / (2 * np.pi), 0.2 / (2 * np.pi)], rel=1e-15)
    band = made(folder, head=units + HEAD, tail=TAIL.replace("at = [0.1, 0.2]", "frequency = [2, 1]")).sweep.band
    assert (band.start, band.stop) == pytest.approx((1.0 / np.pi, 0.5 / np.pi), rel=1e-15)
    rig = '[structure]\nrig = "single_mass"\n[sweep]\nfrequency = [0.5, 2.0]\n'
    band = made(folder, head=units + HEAD, structure=rig, contacts="", tail="").sweep.band
    assert (band.start, band.stop) == pytest.approx((0.25 / np.pi, 1.0 / np.pi), rel=1e-15)
    with pytest.raises(InputError, match="units must go with matrices, but stands beside a rig"):
        made(folder, head='units = { frequency = "rad/s", length = "mm" }' + HEAD, structure=rig, contacts="", tail="")
    with pytest.raises(InputError, match="frequency must be"):
        made(folder, head='units = { frequency = "1/s" }' + HEAD)


@pytest.mark.parametrize(("damping", "expected"), [("modal = 0.01", 0.01), ("modal = [0.01, 0.02]\non = 'free'", (0.01, 0.02))])
def test_modal_damping(folder, damping, expected):
    rule = made(folder, SPRING + f"[damping]\n{damping}\n").sweep.problem.structure.damping
    assert rule.ratio == expected
    assert rule.on == ("free" if "free" in damping else "stuck")


@pytest.mark.parametrize("suffix", ["npz", "mat", "sparse.mat"])
def test_matrices_from_files(folder, suffix):
    M, K, C = np.diag([1.0, 2.0, 3.0, 4.0]), 10.0 * np.eye(4) - np.ones((4, 4)), 0.1 * np.eye(4)
    if suffix == "npz":
        np.savez(folder / "m.npz", M=M.astype(np.float32), K=K, C=C)
    else:
        io.savemat(folder / f"m.{suffix}", {"M": M, "K": sparse.csc_array(K) if "sparse" in suffix else K, "C": C})
    structure = made(folder, structure=FOUR.replace("four.npz", f"m.{suffix}")).sweep.problem.structure
    for name, matrix in (("M", M), ("K", K), ("C", C)):
        np.testing.assert_array_equal(getattr(structure, name), matrix)


def truncated(path):
    np.savez(path, M=np.eye(4), K=np.eye(4))
    path.write_bytes(path.read_bytes()[:300])


def text_file(path):
    path.write_text("M = 1")


def array_file(path):
    np.save(path.with_suffix(".npy"), np.eye(4))
    path.with_suffix(".npy").rename(path)


def pickled(path):
    np.savez(path, M=np.array([{"a": 1}], dtype=object), K=np.eye(4))


@pytest.mark.parametrize(
    ("write", "said"),
    [
        (truncated, "must be a .npz archive"),
        (text_file, "must be a .npz archive"),
        (array_file, "must be a .npz archive"),
        (pickled, "allow_pickle=False"),
        (lambda path: None, "must be a file that exists"),
        (
            lambda path: np.savez(path, M=np.eye(4), k=np.eye(4)),
            "matrix K must be in the file, but is missing. Known: M, k.",
        ),
        (lambda path: np.savez(path, M=np.eye(4), K=np.eye(4) * (1 + 0.1j)), "K must hold real numbers, but is 'complex128'"),
        (lambda path: np.savez(path, M=np.eye(4), K=np.array(["a"])), "K must hold real numbers"),
        (lambda path: np.savez(path, M=np.eye(4), K=np.ones((4, 3))), "K must be a square matrix, but is (4, 3)"),
        (lambda path: np.savez(path, M=np.eye(4), K=np.diag([1, 1, 1, np.nan])), "K[3, 3] must be finite, but is nan"),
        (lambda path: np.savez(path, M=np.eye(4), K=np.eye(3)), "the names of the rows of K, must have 3 entries, but is 4"),
    ],
)
def test_wrong_matrix_files(folder, write, said):
    write(folder / "wrong.npz")
    with pytest.raises(InputError) as raised:
        made(folder, structure=FOUR.replace("four", "wrong"))
    assert said in str(raised.value)


def test_matlab_files_of_another_kind(folder):
    (folder / "wrong.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(100))
    with pytest.raises(InputError, match=r"wrong\.mat: The file is damaged \(.*v7\.3"):
        made(folder, structure=FOUR.replace("four.npz", "wrong.mat"))
    (folder / "wrong.mat").write_bytes(b"")
    with pytest.raises(InputError, match=r"must be of version 4 to 7\.3"):
        made(folder, structure=FOUR.replace("four.npz", "wrong.mat"))
    (folder / "wrong.csv").write_text("1, 2\n")
    with pytest.raises(InputError, match=r"must be a file ending in .*\.mat.*, but is 'wrong\.csv'"):
        made(folder, structure=FOUR.replace("four.npz", "wrong.csv"))


def test_a_mark_at_the_start_of_the_file_is_no_fault(folder):
    (folder / "study.toml").write_text(HEAD + FOUR + SPRING + TAIL, encoding="utf-8-sig")
    assert read(folder / "study.toml").title == "A title"


@pytest.mark.parametrize(
    ("keys", "spectrum", "count"),
    [
        ("", ss.Hertz(), None),
        ('spectrum = "parabolic"\nedge = 0.3\ncount = 8\n', ss.Parabolic(0.3), 8),
        ('spectrum = "four_parameter"\nchi = -0.2\n', ss.FourParameter(chi=-0.2), None),
    ],
)
def test_iwan_has_the_names_of_python(folder, keys, spectrum, count):
    law = made(folder, IWAN + keys).sweep.problem.contacts[0].law
    assert law == ss.Iwan(6.0, 0.5, normal_load=3.0, spectrum=spectrum, count=count)


def test_an_edge_needs_a_parabolic_pressure(folder):
    with pytest.raises(InputError, match="edge must go with another spectrum, but is 'hertz'"):
        made(folder, IWAN + "edge = 0.3\n")


def test_a_force_has_a_direction_as_outputs_have(folder):
    found = made(folder, tail=TAIL.replace('direction = "1.x"', 'direction = { "1.x" = 0.6, "1.y" = 0.8 }')).sweep.problem
    assert found.forces[0] == ss.Force({"1.x": 0.6, "1.y": 0.8}, {1: 1.0 - 2.0j}, 3.0)
    assert ss.Force(direction="1.x").coefficients == {"1.x": 1.0}
    assert found.forces[0].coefficients == {"1.x": 0.6, "1.y": 0.8}


def test_a_set_of_one_node_in_a_study(folder):
    """tip.x is tip/14.x: forces, outputs and contacts take it, and the rotation keeps its lever, 1 mm."""
    structure = FOUR.replace('["1.x", "1.y", "2.x", "2.rz"]', '["tip/14.x", "tip/14.y", "2.x", "tip/14.rz"]')
    tail = TAIL.replace('"1.x"', '"tip.x"').replace('"2.rz"', '"tip.rz"')
    contacts = SPRING.replace('"1.x"', '"tip.x"')
    problem = made(folder, contacts, 'units = "mm-t-s"' + HEAD, tail, structure).sweep.problem
    assert problem.output_names == ("tip.x", "rim")
    assert problem.output_rows.tolist() == [[1, 0, 0, 0], [0, 0, 1, 0.5e-3]]
    assert problem.load(1, 2.0)[0].tolist() == [3.0, 2.0, 4.0]
    with pytest.raises(InputError, match=r"'tip\.z' does not exist"):
        made(folder, contacts, HEAD, tail.replace('"tip.rz"', '"tip.z"'), structure)
