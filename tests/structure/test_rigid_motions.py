"""Rigid motions are those of the body: thin, long, finely meshed, softly held or hinged, in any unit, with 1 to 1e5 elements.

References: the count of motions that the supports of each body leave, by hand; the first bending frequency of a clamped strip
(CalculiX 2.20: 18.894 Hz) and of a cantilever, 1.8751² √(EI/ρA)/(2π L²).
"""

import numpy as np
import pytest
from scipy import sparse

import stickslip as ss
from stickslip.model.readers.model import Model, describe
from stickslip.model.rigs.beams import beam_mass, beam_stiffness
from stickslip.model.structure.cyclic import sector_chain
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.modes import lowest_modes, natural_modes, rigid_motions
from stickslip.model.structure.solid import box_mesh, solid

YOUNG, DENSITY, WIDTH = 2.1e11, 7800.0, 0.02


def beam(elements, length=0.15, thickness=0.0005, hold=(), spring=0.0):
    """K, M, names and nodes of a straight beam along x in the plane x, y; hold: rows fixed at its first node; spring: under
    the last one, across it, as a share of the stiffness of an element."""
    size = length / elements
    own = beam_stiffness(size, YOUNG * WIDTH * thickness, YOUNG * WIDTH * thickness**3 / 12)
    first = 3 * np.arange(elements)[:, None] + np.arange(6)
    rows, columns = np.repeat(first, 6, axis=1).ravel(), np.tile(first, 6).ravel()
    n = 3 * (elements + 1)
    K = sparse.csc_array((np.tile(own.ravel(), elements), (rows, columns)), shape=(n, n))
    mass = np.zeros((6, 6))
    each = DENSITY * WIDTH * thickness * size
    mass[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = beam_mass(size, each)
    mass[np.ix_([0, 3], [0, 3])] = each / 6 * np.array([[2, 1], [1, 2]])
    M = sparse.csc_array((np.tile(mass.ravel(), elements), (rows, columns)), shape=(n, n))
    if spring:
        K = K + sparse.csc_array(([spring * own[1, 1]], ([n - 2], [n - 2])), shape=(n, n))
    free = np.setdiff1d(np.arange(n), list(hold))
    names = [f"{k // 3}.{('x', 'y', 'rz')[k % 3]}" for k in free]
    nodes = {str(k): (k * size, 0.0, 0.0) for k in range(elements + 1)}
    return K[free][:, free], M[free][:, free], names, nodes


@pytest.mark.parametrize("elements", [1, 7, 1000, 50_000])
def test_supports_leave_the_same_motions_whatever_the_mesh(elements):
    """Free in its plane 3, on a hinge 1, clamped 0, on a hinge and a soft spring 0."""
    counts = []
    for hold, spring in (((), 0.0), ((0, 1), 0.0), ((0, 1, 2), 0.0), ((0, 1), 1e-11)):
        K, _, names, nodes = beam(elements, hold=hold, spring=spring)
        counts.append(rigid_motions(K, names, nodes).shape[1])
    assert counts == [3, 1, 0, 0]


def test_the_motion_that_a_hinge_leaves_turns_about_it():
    K, _, names, nodes = beam(50, hold=(0, 1))
    (motion,) = rigid_motions(K, names, nodes).T
    across = motion[[names.index(f"{k}.y") for k in range(1, 51)]]
    np.testing.assert_allclose(across / across[-1], np.arange(1, 51) / 50, rtol=1e-9)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_units_and_place_do_not_count(scale):
    """The same solid body in other lengths and far from the origin, on a plane without friction: three motions are left."""
    body = solid(box_mesh(*(np.linspace(0, d, n + 1) for d, n in ((0.03, 3), (0.02, 2), (0.001, 1)))))
    rows = [(body.numbers[k, a], f"{k}.{'xyz'[a]}") for k in range(len(body.points)) for a in range(3)]
    names = [name for row, name in sorted(rows)]
    nodes = {str(k): tuple(scale * (point + 1.0)) for k, point in enumerate(body.points)}
    bottom = [row for row, name in rows if name.endswith("z") and body.points[int(name[:-2]), 2] == 0.0]
    free = np.setdiff1d(np.arange(body.size), bottom)
    assert rigid_motions(body.K, names, nodes).shape[1] == 6
    assert rigid_motions(body.K[free][:, free], [names[k] for k in free], nodes).shape[1] == 3


def test_parts_that_nothing_joins_move_by_themselves():
    one, _, names, nodes = beam(4)
    two = sparse.block_diag([one, one], format="csc")
    named = [*names, *(f"b{name}" for name in names)]
    places = nodes | {f"b{node}": (x, 0.1, 0.0) for node, (x, _, _) in nodes.items()}
    assert rigid_motions(two, named, places).shape[1] == 6


def strip(file, clamped=True):
    """A steel strip 150 x 20 x 0.5 mm of 20 x 4 x 1 solid elements as a model."""
    body = solid(box_mesh(*(np.linspace(0, d, n + 1) for d, n in ((0.15, 20), (0.02, 4), (0.0005, 1)))))
    if clamped:
        body = body.clamp(lambda points: points[:, 0] < 1e-9)
    rows = [(body.numbers[k, a], f"{k}.{'xyz'[a]}") for k in range(len(body.points)) for a in range(3)]
    names = tuple(name for row, name in sorted(rows) if row >= 0)
    nodes = {str(k): tuple(point) for k, point in enumerate(body.points)} if file else {}
    return Model(body.M, body.K, names, nodes=nodes)


@pytest.mark.parametrize("located", [True, False])
def test_the_bending_of_a_thin_strip_is_no_rigid_motion(located):
    """18.9 Hz: 3e-12 of the energy that its elements store against each other, and 1e-11 of the highest ω²."""
    found = describe(strip(located), 3).modes
    assert (found.rigid, found.negative) == (0, 0)
    assert found.frequencies[0] == pytest.approx(18.894, rel=5e-4)


@pytest.mark.parametrize("located", [True, False])
def test_a_free_strip_has_six(located):
    found = describe(strip(located, clamped=False), 8).modes
    assert (found.rigid, found.negative) == (6, 0)
    assert found.frequencies[6] == pytest.approx(118.5, rel=5e-3)


def test_a_beam_of_many_elements_is_clamped():
    """1000 elements: the first ω² is 3e-14 of the highest, at the limit of what the energy of the mode can say."""
    K, M, names, nodes = beam(1000, hold=(0, 1, 2))
    found = lowest_modes(M, K, 2, rigid_motions(K, names, nodes))
    exact = 1.875104068711961**2 * np.sqrt(YOUNG * 0.0005**2 / 12 / DENSITY) / (2 * np.pi * 0.15**2)
    assert found.rigid == 0
    assert found.frequencies[0] == pytest.approx(exact, rel=1e-3)


def test_a_reduced_free_body_stays_free(tmp_path, monkeypatch):
    """A thin free strip by five of its nodes: rounding of the reduction left 0.1 Hz, as large a share of K as a soft mode has."""
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path))
    model = strip(True, clamped=False)
    nodes = np.column_stack([[int(name) for name in model.nodes], list(model.nodes.values())])
    np.savez(tmp_path / "strip.npz", M=model.M.toarray(), K=model.K.toarray(), dofs=model.dofs, nodes=nodes)
    keep = {
        "a": (0.0, 0.0, 0.0),
        "b": (0.15, 0.0, 0.0),
        "c": (0.0, 0.02, 0.0),
        "d": (0.15, 0.02, 0.0005),
        "e": (0.075, 0.01, 0.0),
    }
    structure = ss.read_structure(tmp_path / "strip.npz", keep=keep, modes=20)
    frequencies = natural_modes(structure.M, structure.K).frequencies
    np.testing.assert_array_equal(frequencies[:6], 0.0)
    assert frequencies[6] == pytest.approx(118.5, rel=5e-3)


@pytest.fixture(scope="module")
def strips():
    """Twelve clamped steel strips 0.3 m long and 1 mm thick, 40 elements each, their tips joined by 1 N/m and a contact."""
    K, M, names, _ = beam(40, length=0.3, thickness=0.001, hold=(0, 1, 2))
    sector = Structure(M.toarray(), K.toarray(), names, damping=ss.ModalDamping(1e-3))
    tip = np.zeros((len(names), len(names)))
    y = names.index("40.y")
    tip[y, y] = -1.0
    own = sector.K.copy()
    own[y, y] += 2.0
    disk = sector_chain(Structure(sector.M, own, sector.dofs, damping=sector.damping), 12, tip)
    contact = ss.Contact("tip", ss.Macroslip(kt=1e4, mu=0.5, normal_load=2.0), ({"40.y": 1.0, "next/40.y": -1.0},))
    return ss.TunedDisk(disk, (contact,), (ss.Force("40.y", 1.0),), ("40.y",), engine_order=3)


def exact(stiffness):
    """Hz of the first bending with a soft spring k at the tip: ω² = ω₁² + 4 k/(ρAL), the tip moving by 2 where φᵀMφ = ρAL."""
    mass = DENSITY * WIDTH * 0.001 * 0.3
    clamped = 1.875104068711961**2 * np.sqrt(YOUNG * 0.001**2 / 12 / DENSITY) / 0.3**2
    return np.sqrt(clamped**2 + 4 * stiffness / mass) / (2 * np.pi)


@pytest.mark.slow
def test_the_first_family_of_thin_strips_is_their_bending(strips):
    """9.31 Hz at nodal diameter 0, where tips move alike; 58.37 Hz is the second bending."""
    disk = strips.with_aerodynamics(ss.Aerodynamics(influence={0: 1e-3j}, frequency=9.31, direction="40.y"))
    found = ss.damping_by_nodal_diameter(disk, mode=1, stuck=False).dataset
    for n in (0, 3, 6):
        spring = 4 * np.sin(np.pi * n / 12) ** 2
        assert float(found.frequency.sel(nodal_diameter=n)) == pytest.approx(exact(spring), rel=2e-3)
    assert exact(0.0) == pytest.approx(9.31, abs=0.1)


def test_the_diagrams_begin_with_it(strips):
    """Campbell and nodal diameter diagrams of the free state; the unit of frequency must not decide what is elastic."""
    found = ss.nodal_diameters(strips, modes=2).dataset.disk_frequency
    assert float(found.sel(disk_state="free", nodal_diameter=0)[0]) == pytest.approx(exact(0.0), rel=1e-4)
    diagram = ss.campbell({0.0: strips, 6000.0: strips}, speed=(100.0, 300.0), engine_orders=(3,), points=2)
    assert float(diagram.dataset.frequency.sel(state="free")[..., 0].min()) == pytest.approx(exact(2.0), rel=2e-3)


def test_slow_modes_are_elastic_in_any_unit():
    """Masses on soft springs, 0.01 to 5000 Hz: the slowest was below a thousandth of the root of the highest, in Hz."""
    omegas = 2 * np.pi * np.array([0.01, 5000.0])
    structure = Structure(np.eye(2), np.diag(omegas**2), ("a.x", "b.x"), damping=ss.ModalDamping(0.01))
    contact = ss.Contact("c", ss.Macroslip(kt=1.0, mu=0.5, normal_load=2.0), ({"a.x": 1.0},))
    problem = ss.Problem(structure, (contact,), (ss.Force("a.x", 1.0),), ("a.x",))
    diagram = ss.campbell({0.0: problem, 100.0: problem}, speed=(1.0, 100.0), engine_orders=(1,), points=2)
    assert float(diagram.dataset.frequency.sel(state="free").min()) == pytest.approx(0.01)
    assert "1 crossing of engine orders and modes from 1 to 100 rev/min" in str(diagram)


def test_energy_alone_tells_a_soft_spring_from_none():
    K, M, _, _ = beam(7, hold=(0, 1))
    stiffness = beam_stiffness(0.15 / 7, 1.0, YOUNG * WIDTH * 0.0005**3 / 12)[1, 1]
    held, _, _, _ = beam(7, hold=(0, 1), spring=1e-9)
    assert natural_modes(M.toarray(), K.toarray()).squares[0] == 0.0
    exact = 3e-9 * stiffness / (DENSITY * WIDTH * 0.0005 * 0.15)  # k L² = ω² m L²/3
    squares = natural_modes(M.toarray(), held.toarray()).squares
    rounding = 1e-15 * squares[-1]  # each eigenvalue of a dense pair is exact to some roundings of the highest
    assert 0 < rounding < 0.1 * exact
    assert squares[0] == pytest.approx(exact, abs=rounding)


def test_a_soft_spring_beside_a_stiff_contact_holds_its_mean():
    """1 N/m beside 1e10 N/m: 1e-10 of the energy of the stuck motion, but no motion that friction alone restrains."""
    contact = ss.Contact("c", ss.Macroslip(kt=1e10, mu=0.5, normal_load=2.0), ({"a.x": 1.0},))

    def loose(K):
        structure = Structure(np.eye(1), np.array([[K]]), ("a.x",), damping=ss.RayleighDamping(0.1, 0.0))
        return ss.Problem(structure, (contact,), (ss.Force("a.x", 1.0),), ("a.x",)).loose_motions.shape[0]

    assert (loose(1.0), loose(0.0)) == (0, 1)
