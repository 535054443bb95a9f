"""Decks of Abaqus and CalculiX without a run: M and K assembled from the mesh, against CalculiX 2.20 and by hand."""

import gzip
import itertools
import re
import shutil
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from readers.fuzzing import CHANGES, damaged
from readers.test_calculix import printed_frequencies
from structure.calculix_elements import CALCULIX
from structure.calculix_products import PRODUCTS
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.model.readers.model import describe
from stickslip.model.readers.stress_places import centrifugal_loads
from stickslip.model.structure.centrifugal import RotationAxis
from stickslip.model.structure.modes import lowest_modes
from stickslip.model.structure.solid import BRICK, BRICK_EDGES, TETRAHEDRON_EDGES, Group, Material, mesh_matrices
from stickslip.results.files import open_results
from stickslip.study import read as read_study
from stickslip.support.checks import InputError

DATA = Path(__file__).parents[1] / "data" / "calculix"
STEEL = Material(200e9, 0.3, 7850.0)
TETRAHEDRA = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
"""Six tetrahedra round a diagonal of a brick; those of neighbours fit."""


def box(kind, sides=(3.0, 2.0, 2.0), cells=(3, 2, 2), moved=0.15):
    """Points and elements of a box whose inner corners are moved by up to `moved` of a cell; its edges stay straight."""
    grid = np.stack(np.meshgrid(*(np.linspace(0.0, 1.0, n + 1) for n in cells), indexing="ij"), axis=-1)
    corners = grid.reshape(-1, 3)
    inner = np.all((corners > 0.0) & (corners < 1.0), axis=1)
    corners[inner] += moved / max(cells) * np.random.default_rng(5).uniform(-1.0, 1.0, (inner.sum(), 3))
    number = np.arange(len(corners)).reshape(grid.shape[:3])
    bricks = [
        [number[tuple(np.add(place, offset).astype(int))] for offset in BRICK]
        for place in itertools.product(*(range(n) for n in cells))
    ]
    own = [[brick[k] for k in each] for brick in bricks for each in TETRAHEDRA] if kind in ("C3D4", "C3D10") else bricks
    edges = TETRAHEDRON_EDGES if kind in ("C3D4", "C3D10") else BRICK_EDGES
    points, middles, elements = [*corners], {}, []
    for nodes in own:
        row = list(nodes)
        for one, other in edges if kind not in ("C3D4", "C3D8") else ():
            edge = tuple(sorted((nodes[one], nodes[other])))
            if edge not in middles:
                middles[edge] = len(points)
                points.append(0.5 * (corners[edge[0]] + corners[edge[1]]))
            row.append(middles[edge])
        elements.append(row)
    return np.array(points) * sides, np.array(elements)


def deck(points, elements, kind, more="*BOUNDARY\nROOT,1,3\n", name="STEEL", young=200e9, density=7850.0, root=0):
    """The deck of a mesh in SI, its nodes at x = 0 in the set ROOT."""
    ids = [[number, *(node + 1 for node in nodes)] for number, nodes in enumerate(elements.tolist(), start=1)]
    rows = [",\n".join(", ".join(map(str, row[k : k + 8])) for k in range(0, len(row), 8)) for row in ids]
    held = np.flatnonzero(points[:, root] < 1e-12) + 1
    return "\n".join(
        [
            "*NODE, NSET=ALL",
            *(f"{k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(points.tolist(), start=1)),
            f"*ELEMENT, TYPE={kind}, ELSET=BODY",
            *rows,
            "*NSET, NSET=ROOT",
            *map(str, held),
            f"*MATERIAL, NAME={name}\n*ELASTIC\n{young}, 0.3\n*DENSITY\n{density}",
            "*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL",
            more,
        ]
    )


def read(folder, text, **options):
    (folder / "body.inp").write_text(text)
    return ss.read_model(folder / "body.inp", **options)


@pytest.mark.parametrize("kind", PRODUCTS)
def test_matrices_of_a_distorted_element_are_those_of_calculix(kind):
    points = np.array(CALCULIX["C3D20R" if kind == "C3D20" else kind][0])
    material = Material(200000.0, 0.3, 7.85e-9)
    made = mesh_matrices(points, [Group(kind, material, ("1",), np.arange(len(points))[None])])
    for matrix, text in zip(made, PRODUCTS[kind], strict=True):
        calculix = np.array(text.split(), dtype=float)
        found = matrix @ np.cos(np.arange(calculix.size))
        np.testing.assert_allclose(found, calculix, atol=1e-9 * np.abs(calculix).max(), rtol=0.0)


def test_every_entry_is_that_of_a_run(tmp_path):
    """The blade of C3D20R of the tutorial, its deck alone and with its run."""
    for file in DATA.glob("blade.*.gz"):
        (tmp_path / file.stem).write_bytes(gzip.decompress(file.read_bytes()))
    shutil.copy(DATA / "blade.dof", tmp_path)
    shutil.copy(DATA / "blade.inp", tmp_path)
    run = ss.read_model(tmp_path / "blade.inp", units="mm-t-s")
    (tmp_path / "alone").mkdir()
    shutil.copy(DATA / "blade.inp", tmp_path / "alone")
    own = ss.read_model(tmp_path / "alone" / "blade.inp", units="mm-t-s")
    assert (run.format, own.format) == ("CalculiX matrices", "mesh of a deck")
    assert own.dofs == run.dofs
    assert own.nodes == run.nodes
    assert own.sets == run.sets
    for one, other in ((own.M, run.M), (own.K, run.K)):
        assert abs(one - other).max() <= 1e-12 * abs(other).max()


def test_frequencies_of_a_curved_mesh_to_the_printed_digits(tmp_path):
    """A piece of a ring of C3D10 with curved faces; ring.dat is what CalculiX wrote for its *FREQUENCY without storage."""
    shutil.copy(DATA / "ring.inp", tmp_path)
    model = ss.read_model(tmp_path / "ring.inp", units="mm-t-s")
    printed, last_digit = printed_frequencies((DATA / "ring.dat").read_text())
    assert printed.size == 6
    assert np.all(np.abs(lowest_modes(model.M, model.K, 6, None).frequencies - printed) <= last_digit)
    assert re.search(r"60 elements C3D10 of STEEL .*E = 210000, .*mass 4\.32375e-06.*\*BOUNDARY holds 13 nodes", model.notes[0])


@pytest.mark.parametrize("kind", PRODUCTS)
def test_patch_rigid_motions_and_mass(kind):
    """Constant strain gives no force at inner nodes and its exact energy; rigid motions give none; the mass is ρV."""
    points, elements = box(kind)
    M, K = mesh_matrices(points, [Group(kind, STEEL, [str(k) for k in range(len(elements))], elements)])
    largest = abs(K).max()
    rotations = [np.cross(axis, points).ravel() for axis in np.eye(3)]
    rigid = np.column_stack([np.tile(np.eye(3), (len(points), 1)), *rotations])
    assert np.abs(K @ rigid).max() < 1e-12 * largest
    total = STEEL.density * 12.0
    np.testing.assert_allclose(rigid[:, :3].T @ (M @ rigid[:, :3]), total * np.eye(3), atol=1e-12 * total)
    gradient = np.array([[1.0, 0.4, -0.2], [0.1, -0.7, 0.3], [0.5, 0.2, 0.9]])
    strain, (lam, shear) = 0.5 * (gradient + gradient.T), STEEL.lame
    stress = lam * np.trace(strain) * np.eye(3) + 2.0 * shear * strain
    u = (points @ gradient.T).ravel()
    force = (K @ u).reshape(-1, 3)
    inner = np.all((points > 1e-9) & (points < np.array([3.0, 2.0, 2.0]) - 1e-9), axis=1)
    assert inner.sum() >= 2
    assert np.abs(force[inner]).max() < 1e-11 * largest
    # The work of the forces on every other linear field is that of the stress: Σ f_i x_j = V σ_ij.
    np.testing.assert_allclose(force.T @ points, 12.0 * stress, atol=1e-11 * 12.0 * np.abs(stress).max())


@pytest.mark.parametrize(
    ("kind", "cells", "high"), [("C3D20", 10, 0.01), ("C3D20R", 10, 0.01), ("C3D10", 20, 0.01), ("C3D8", 40, 0.2)]
)
def test_frequencies_of_a_cantilever(tmp_path, kind, cells, high):
    """200 x 14 x 10 mm in steel: Euler-Bernoulli, less rotary inertia and shear (0.3 %); C3D8 is too stiff in bending."""
    points, elements = box(kind, (0.2, 0.014, 0.01), (cells, 2, 2), moved=0.0)
    model = read(tmp_path, deck(points, elements, kind))
    beam = 1.875104069**2 / (2 * np.pi) * np.sqrt(200e9 * 0.01**2 / 12 / 7850.0) / 0.2**2
    found = lowest_modes(model.M, model.K, 2, None).frequencies
    assert -0.005 < found[0] / beam - 1.0 < high
    assert -0.01 < found[1] / (1.4 * beam) - 1.0 < high, "bending the other way"
    assert describe(model).mass[0] < 7850.0 * 0.2 * 0.014 * 0.01, "without what the clamped nodes carry"


def test_two_materials(tmp_path):
    points, elements = box("C3D8", cells=(2, 1, 1), moved=0.0)
    light = "*MATERIAL, NAME=LIGHT\n*DENSITY\n2700.\n*ELASTIC, TYPE=ISOTROPIC\n70e9, 0.33\n*ELSET, ELSET=LEFT\n1\n"
    text = deck(points, elements, "C3D8", f"{light}*SOLID SECTION, ELSET=LEFT, MATERIAL=LIGHT\n")
    model = read(tmp_path, text)
    groups = [Group("C3D8", Material(70e9, 0.33, 2700.0), ("1",), elements[:1]), Group("C3D8", STEEL, ("2",), elements[1:])]
    for found, right in zip((model.M, model.K), mesh_matrices(points, groups), strict=True):
        assert abs(found - right).max() <= 1e-14 * abs(right).max()
    assert "1 element C3D8 of LIGHT, 1 element C3D8 of STEEL (LIGHT with E = 7e+10, " in model.notes[0]
    assert f"mass {6.0 * (2700.0 + 7850.0):g} in the units" in model.notes[0]


TEXT = deck(*box("C3D4", cells=(1, 1, 1)), "C3D4")
FREE = deck(*box("C3D4", cells=(1, 1, 1)), "C3D4", more="")
"""A brick of six tetrahedra with eight nodes, of which 1 to 4 are at x = 0."""


@pytest.mark.parametrize(
    ("supports", "held"),
    [
        ("*BOUNDARY\nROOT, 1, 6\n", {1: "xyz", 2: "xyz", 3: "xyz", 4: "xyz"}),
        ("*BOUNDARY\nroot, 2\n8, 3, 3, 0.\n", {1: "y", 2: "y", 3: "y", 4: "y", 8: "z"}),
        ("*BOUNDARY\n5, PINNED\n6, XSYMM\n7, 4, 6\n", {5: "xyz", 6: "x"}),
        ("*BOUNDARY\n5, 1\n*STEP\n*STATIC\n*BOUNDARY\n6, 2\n*END STEP\n", {5: "x", 6: "y"}),
        ("*BOUNDARY\n5, 1\n*STEP\n*BOUNDARY, OP=NEW\n6, 2\n*BOUNDARY, OP=NEW\n7, 3\n*END STEP\n", {6: "y", 7: "z"}),
        ("*TRANSFORM, NSET=ROOT, TYPE=C\n0,0,0, 0,0,1\n*BOUNDARY\nROOT, ENCASTRE\n", {1: "xyz", 2: "xyz", 3: "xyz", 4: "xyz"}),
    ],
)
def test_supports_leave_rows_out(tmp_path, supports, held):
    model = read(tmp_path, FREE + supports)
    right = [f"{node}.{axis}" for node in range(1, 9) for axis in "xyz" if axis not in held.get(node, "")]
    assert list(model.dofs) == right
    assert f"*BOUNDARY holds {len(held)} nodes" in model.notes[0]
    free = read(tmp_path, FREE)
    rows = [free.rows[name] for name in right]
    assert abs(model.K - free.K[rows][:, rows]).max() == 0.0


def test_loads_of_steps_are_said(tmp_path):
    step = "*STEP\n*STATIC\n*CLOAD\n5, 1, 10.\n*DLOAD\nBODY, CENTRIF, 100., 0,0,0, 0,0,1\n*NODE FILE\nU\n*END STEP\n"
    model = read(tmp_path, TEXT + step)
    assert model.notes[1] == "Of the steps of body.inp, *BOUNDARY alone counts, not *CLOAD, *DLOAD."
    assert len(read(tmp_path, TEXT).notes) == 1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "1, 1, 5, 7, 8\n",
            "1, 1, 7, 5, 8\n",
            r"must not be inverted or flat .* but 1 are: element 1 \(C3D4\)\. Move their nodes",
        ),
        (
            "1, 1, 5, 7, 8\n",
            "1, 1, 5, 7, 99\n",
            r"Element 1 \(C3D4\) must have all its nodes in \*NODE, but is 'with 99 missing'",
        ),
        ("1, 1, 5, 7, 8\n", "1, 1, 5, 7, 7\n", r"Element 1 \(C3D4\) must name 4 different nodes, but is 'with 1, 5, 7, 7'"),
        ("1, 1, 5, 7, 8\n", "1, 1, 5, 7\n", "must name 4 different nodes"),
        ("1, 1, 5, 7, 8\n", "1, 1, 5, 7, 8\n2, 1, 5, 7, 8\n", r"Element 2 \(C3D4\) must be defined once"),
        ("ELSET=BODY, MATERIAL", "ELSET=OTHER, MATERIAL", r"Element 1 \(C3D4\) must be in the ELSET of a \*SOLID SECTION"),
        ("*DENSITY\n7850.0", "", r"The material STEEL: it must have one line of \*DENSITY, but is 'without that card'"),
        ("*DENSITY\n7850.0", "*DENSITY\n7850.0, 20.\n7800., 500.", "must have one line of .DENSITY, but is '2 lines'"),
        ("*DENSITY\n7850.0", "*DENSITY\n-7850.0", "density must be positive, but is -7850"),
        ("*DENSITY\n7850.0", "*DENSITY\nnan", "must be a number, but is 'nan'"),
        ("200000000000.0, 0.3", "nan, 0.3", "The material STEEL: A field must be a number, but is 'nan'"),
        ("200000000000.0, 0.3", "2e11, 0.5", "poisson must lie between -1 and 0.5"),
        ("200000000000.0, 0.3", "2e11, 0.3, 20.\n1.9e11, 0.3, 400.", "in one line of .ELASTIC, .* but is '2 lines'"),
        ("*ELASTIC", "*ELASTIC, TYPE=ORTHO", "the same in all directions, but is 'another TYPE'"),
        (
            "MATERIAL=STEEL",
            "MATERIAL=STEAL",
            "The material STEAL: .* but is 'without that card'. Did you mean 'STEEL'",
        ),
        ("TYPE=C3D4", "TYPE=S4R", r"Element 1 \(S4R\) must be one of C3D4, C3D8, C3D10, C3D20, C3D20R, .*MATRIXSTORAGE"),
        ("TYPE=C3D4", "TYPE=C3D8R", "must be one of .* but is 'C3D8R'.*MATRIXSTORAGE"),
        ("TYPE=C3D4", "TYPE=C3D8I", "must be one of .* but is 'C3D8I'"),
        ("TYPE=C3D4", "TYPE=C3D15", "must be one of .* but is 'C3D15'"),
        ("*BOUNDARY", "*ELEMENT, TYPE=SPRINGA, ELSET=S\n99, 1, 2\n*BOUNDARY", r"Element 99 \(SPRINGA\) must be one of"),
        (
            "*BOUNDARY",
            "*SPRING, ELSET=S\n\n5.\n*BOUNDARY",
            "line .* must hold cards that count .* but is '.SPRING'. Give the stiff",
        ),
        ("*BOUNDARY", "*EQUATION\n2\n1,1,1.,2,1,-1.\n*BOUNDARY", r"but is '\*EQUATION'.*MATRIXSTORAGE"),
        ("*BOUNDARY", "*MPC\nPLANE, 1, 2, 3, 4\n*BOUNDARY", r"but is '\*MPC'"),
        ("*BOUNDARY", "*TIE, NAME=T\nA, B\n*BOUNDARY", r"but is '\*TIE'. Fix the nodes with"),
        ("*BOUNDARY", "*MAGIC\n*BOUNDARY", r"body\.inp, line \d+ must hold cards .* but is '\*MAGIC'. Delete it if"),
        ("*BOUNDARY", "*ELCOPY, ELEMENT SHIFT=10, OLD SET=BODY, SHIFT NODES=10\n*BOUNDARY", "with all elements written out"),
        ("*BOUNDARY", "*STEP\n*MODEL CHANGE, TYPE=ELEMENT, REMOVE\nBODY\n*END STEP\n*BOUNDARY", r"but is '\*MODEL CHANGE'"),
        ("ROOT,1,3", "ROOT,1,1,0.5", "must hold the nodes at 0, but is '0.5'"),
        ("ROOT,1,3", "ROOT,3,1", r"must fix directions from 1 to 6, but is \['3', '1'\]"),
        ("ROOT,1,3", "ROOT", "must fix directions from 1 to 6"),
        ("ROOT,1,3", "ROOT,11", "must fix directions from 1 to 6"),
        ("ROOT,1,3", "ROOT,12", "must fix directions from 1 to 6"),
        ("ROOT,1,3", "ROT,1,3", "must begin with a node or a set of nodes, but is 'ROT'. Did you mean 'ROOT'"),
        ("*BOUNDARY", "*BOUNDARY, SUBMODEL, STEP=1", "must fix nodes, but is 'S"),
        ("*BOUNDARY\nROOT,1,3", "*TRANSFORM, NSET=ROOT\n0,1,0,1,0,0\n*BOUNDARY\nROOT,1", "axes of its own .*MATRIXSTORAGE"),
        ("1, 0.0, 0.0, 0.0\n", "1, 1e999, 0.0, 0.0\n", "The coordinates of node 1 must be finite"),
    ],
)
def test_decks_that_are_refused(tmp_path, old, new, said):
    assert old in TEXT
    with pytest.raises(InputError, match=said):
        read(tmp_path, TEXT.replace(old, new, 1))


@pytest.mark.parametrize("text", ["", "*HEADING\nnothing\n", "*NODE\n1, 0., 0., 0.\n"])
def test_an_empty_deck_is_refused(tmp_path, text):
    with pytest.raises(InputError, match=r"A deck without matrices must hold solid elements.*MATRIXSTORAGE"):
        read(tmp_path, text)


def test_linear_and_quadratic_elements_must_not_touch(tmp_path):
    points, elements = box("C3D10", cells=(1, 1, 1))
    text = deck(points, elements[:5], "C3D10")
    linear = "*ELEMENT, TYPE=C3D4, ELSET=BODY\n6, " + ", ".join(str(node + 1) for node in elements[5][:4])
    with pytest.raises(InputError, match="Linear and quadratic elements must have no nodes in common"):
        read(tmp_path, text.replace("*NSET, NSET=ROOT", f"{linear}\n*NSET, NSET=ROOT"))


def test_parts_and_instances(tmp_path):
    """The only instance of a part, moved: its rows have the numbers of the part; elements of the assembly are refused."""
    plain = read(tmp_path, FREE)
    mesh, material = FREE.split("*MATERIAL")[0], "*MATERIAL" + FREE.split("*MATERIAL")[1].split("*SOLID")[0]
    part = f"*PART, NAME=P\n{mesh}*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL\n*END PART\n"
    instance = "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=P\n1., 2., 3.\n*END INSTANCE\n{more}*END ASSEMBLY\n"
    support = "*BOUNDARY\nP-1.ROOT, 1, 2\nP-1.8, 3\n"
    model = read(tmp_path, part + instance.format(more="") + material + support)
    rows = [plain.rows[name] for name in model.dofs]
    assert len(rows) == 24 - 9
    assert abs(model.K - plain.K[rows][:, rows]).max() < 1e-9 * abs(plain.K).max()
    spring = "*ELEMENT, TYPE=SPRINGA, ELSET=S\n1, P-1.1, P-1.2\n"
    with pytest.raises(InputError, match=r"Element 1 of the assembly \(SPRINGA\) must be one of"):
        read(tmp_path, part + instance.format(more=spring) + material + support)
    two = instance.format(more="*INSTANCE, NAME=P-2, PART=P\n9., 2., 3.\n*END INSTANCE\n")
    with pytest.raises(InputError, match="must hold one instance with all elements written out"):
        read(tmp_path, part + two + material)


def test_units_that_no_body_has_are_warned_of(tmp_path):
    with pytest.warns(UserWarning, match="density|box"):
        read(tmp_path, TEXT, units="mm-t-s")


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(CHANGES), st.floats(0.0, 0.999), st.integers(0, 2**32 - 1)), min_size=1, max_size=3))
def test_damaged_decks(tmp_path_factory, changes):
    """Whatever happens to a deck, it is a model or refused with a sentence."""
    file = tmp_path_factory.mktemp("damaged") / "body.inp"
    file.write_bytes(damaged(TEXT.encode(), changes))
    with suppress(InputError):
        model = ss.read_model(file)
        assert np.isfinite(model.K.data).all()
        assert np.isfinite(model.M.data).all()


STUDY = """
units = "mm-t-s"
[study]
analysis = "forced_response"
[structure]
model = "ring.inp"
keep = { tip = 7 }
stress = { root = 2 }
modes = 8
[rotation]
speed = 3000.0
[damping]
modal = 0.002
[[contact]]
name = "pad"
law = "macroslip"
surface = "PAD"
against = "ground"
facing = [0.0, 0.0, 1.0]
kt = 1e4
kn = 1e4
mu = 0.4
preload = 20.0
[[force]]
direction = "tip.x"
amplitude = 1.0
[sweep]
frequency = [19000.0, 24000.0]
force_levels = [0.05, 100.0]
harmonics = 1
outputs = ["tip.x"]
"""


@pytest.fixture
def ring(tmp_path):
    """The ring alone, with a set of the nodes of its upper face, and a study of it."""
    text = (DATA / "ring.inp").read_text()
    sets = "*NSET, NSET=PAD\n1, 5, 10, 13, 22, 25, 34, 73, 74, 75, 76, 80, 85\n*MATERIAL"
    (tmp_path / "ring.inp").write_text(text.replace("*MATERIAL", sets, 1))
    (tmp_path / "ring.toml").write_text(STUDY)
    return tmp_path


def test_a_study_of_a_deck_alone(ring):
    """Contacts on a set of nodes, rotation and stress at a set: all as of a run."""
    job = read_study(ring / "ring.toml")
    said = "\n".join(job.notes)
    assert "M and K are assembled from the mesh of ring.inp, without a run: 60 elements C3D10 of STEEL" in said
    assert "pad: 13 contacts on PAD against ground" in said
    assert "Stress at root (node 2)" in said
    out = str(ring / "out")
    ran = CliRunner().invoke(app, ["run", str(ring / "ring.toml"), "--out", out, "--workers", "1"])
    assert ran.exit_code == 0, ran.output
    data = open_results(ring / "out" / "results.nc")
    small, large = (float(data.frequency[k, int(np.nanargmax(data.amplitude.values[k, :, 0]))]) for k in (0, 1))
    assert small == pytest.approx(job.sweep.problem.frequencies(stuck=True)[0], rel=1e-3)
    assert 19910.0 < large < 0.99 * small, "pads that slip hold less"
    assert float(data.stress_von_mises.sel(place="root").max()) > 0.0


def test_info_and_check_say_what_was_assembled(ring):
    info = CliRunner().invoke(app, ["info", str(ring / "ring.inp"), "--units", "mm-t-s"])
    assert info.exit_code == 0
    for words in ("mesh of a deck", "19910.06, 20239.31", "60 elements C3D10 of STEEL", "mass 4.32375e-06"):
        assert words in info.output
    check = CliRunner().invoke(app, ["check", str(ring / "ring.toml")])
    assert check.exit_code == 0, check.output
    assert "60 elements C3D10 of STEEL" in " ".join(check.output.split())


def test_the_load_of_rotation_is_that_of_a_run(tmp_path):
    """r Ω² M of the assembled M, which holds the mass of the nodes: against ∫ ρ r dV of a box."""
    points, elements = box("C3D20", moved=0.0)
    model = read(tmp_path, deck(points, elements, "C3D20", more=""))
    load = centrifugal_loads(model).about(RotationAxis.of("z"))[0].reshape(-1, 3).sum(axis=0)
    np.testing.assert_allclose(load, 7850.0 * 12.0 * np.array([1.5, 1.0, 0.0]), rtol=1e-10, atol=1e-6)


@pytest.mark.parametrize("there", ["blade.sti", "blade.mas.gz"])
def test_a_part_of_a_run_is_not_passed_over(tmp_path, there):
    shutil.copy(DATA / "blade.inp", tmp_path)
    (tmp_path / there).write_bytes(b"1 1 1.0\n")
    with pytest.raises(InputError, match=r"must have blade\.(sti|mas) beside blade\.inp"):
        ss.read_model(tmp_path / "blade.inp")


def test_faces_of_a_mesher_have_no_section_and_are_left_out(tmp_path):
    """gmsh writes the triangles of a physical surface beside the solids, and its groups as sets of elements unless told."""
    text = deck(*box("C3D4"), "C3D4")
    alone = read(tmp_path, text)
    faces = text.replace("*NSET", "*ELEMENT, TYPE=CPS3, ELSET=Surface1\n9001, 1, 2, 3\n9002, 1, 3, 4\n*NSET", 1)
    beside = read(tmp_path, faces)
    assert abs(beside.K - alone.K).max() == abs(beside.M - alone.M).max() == 0.0
    assert any("2 elements without a section (CPS3) are left out of M and K." in note for note in beside.notes)
    assert not any("left out of M" in note for note in alone.notes)
    with pytest.raises(InputError, match=r"Element 9001 \(CPS3\) must be one of C3D4"):
        read(tmp_path, faces + "*SOLID SECTION, ELSET=Surface1, MATERIAL=STEEL\n")
    with pytest.raises(InputError, match=r"but is 'ROOT'. gmsh writes sets of nodes with Mesh.SaveGroupsOfNodes = 1"):
        read(tmp_path, text.replace("*NSET, NSET=ROOT", "*ELSET, ELSET=ROOT").replace("*NODE, NSET=ALL", "*NODE"))
