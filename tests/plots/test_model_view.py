"""The drawing of a model: places and directions are those of the geometry that made the problem."""

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.model.rigs.single_blade import PlatformBlade, damper_shape, pads, placed_dampers
from stickslip.model.structure.mesh_surface import MeshSurface
from stickslip.show.plots.model_view import MOST_POINTS, model_view
from stickslip.study.templates import write_new
from stickslip.support.units import UnitSystem


@pytest.fixture(scope="module")
def rig():
    return ss.rigs.single_blade(4.6, modes=5)


@pytest.fixture(scope="module")
def dampers():
    blade = PlatformBlade()
    return dict(zip(("left", "right"), placed_dampers(blade, damper_shape(blade), 1.0), strict=True))


def arrows(view, label):
    return next(found for found in view.arrows if found.label == label)


def in_order(places):
    return sorted(np.round(places, 9).tolist())


@pytest.mark.parametrize("side", ["left", "right"])
def test_contacts_of_nodes_stand_at_their_nodes(rig, dampers, side):
    found = arrows(model_view(rig), f"{side} flat, closing motion")
    assert in_order(found.feet) == in_order([place for _, place in pads(dampers[side])])
    normal = np.asarray(dampers[side].surface("flat").frame)[2]
    np.testing.assert_allclose(found.directions, np.tile(normal, (5, 1)), atol=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
def test_contacts_of_a_body_alone_stand_at_its_points(rig, dampers, side):
    """Place by the rotations that the contact sees, closing motion towards the fixed side."""
    surface = dampers[side].surface("cylinder")
    found = arrows(model_view(rig), f"{side} cylinder, closing motion")
    assert in_order(found.feet) == in_order(surface.points)
    np.testing.assert_allclose(found.directions, np.tile(-np.asarray(surface.frame)[2], (3, 1)), atol=1e-12)


def test_forces_and_outputs_are_drawn_where_they_act(rig):
    view = model_view(rig)
    static = arrows(view, "static forces")
    np.testing.assert_allclose(static.directions, [[0.0, 1.0, 0.0]] * 2)  # the pull of two dampers
    (force,) = arrows(view, "exciting forces").feet
    np.testing.assert_allclose(force, [0.5 * PlatformBlade().thickness, PlatformBlade().force_height, 0.0])
    (output,) = next(points for points in view.points if points.label == "outputs").places
    np.testing.assert_allclose(output, [0.0, PlatformBlade().length, 0.0])


def test_a_negative_amplitude_points_the_other_way(rig):
    turned = rig.with_forces([ss.Force("blade/force.x", -1.0), *rig.forces[1:]])
    np.testing.assert_allclose(arrows(model_view(turned), "exciting forces").directions, [[-1.0, 0.0, 0.0]])


def test_a_wrong_sign_of_a_normal_is_seen(rig):
    def flipped(contact):
        return ss.Contact(contact.name, contact.law, contact.tangential, {dof: -c for dof, c in contact.normal.items()})

    right, wrong = (arrows(model_view(p), "left flat, closing motion") for p in (rig, rig.with_contacts(flipped)))
    np.testing.assert_array_equal(wrong.directions, -right.directions)


def test_a_large_mesh_is_thinned_out():
    points = np.random.default_rng(0).random((5 * MOST_POINTS, 3))
    structure = ss.Structure([[1.0]], [[1.0]], ["a.x"], nodes={"a": (0.0, 0.0, 0.0)}, mesh_points=points)
    law = ss.Macroslip(kt=1.0, mu=0.1, normal_load=1.0)
    problem = ss.Problem(structure, [ss.Contact("c", law, ({"a.x": 1.0},))], [ss.Force("a.x", 1.0)], ["a.x"])
    mesh = next(found for found in model_view(problem).points if found.label == "mesh")
    assert MOST_POINTS / 2 < len(mesh.places) <= MOST_POINTS
    assert problem.plot()._repr_png_().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_disk_is_drawn_by_its_sector():
    view = model_view(ss.rigs.octopus_blisk(modes=3))
    assert {"right edge, closing motion", "left edge, closing motion", "static forces"} <= {found.label for found in view.arrows}
    lengths = np.linalg.norm(arrows(view, "left edge, closing motion").directions, axis=1)
    np.testing.assert_allclose(lengths, 1.0)


def test_a_disk_whose_elements_are_known_is_drawn_by_its_faces():
    """The sector and its neighbours, turned about the axis, in place of dots; the damper by its section."""
    disk = ss.rigs.octopus_blisk(modes=3)
    view = model_view(disk)
    assert [faces.label for faces in view.faces] == ["sector", "preceding sector", "following sector"]
    assert "mesh" not in {points.label for points in view.points}
    own, before, after = (faces.places for faces in view.faces)
    turn = disk.structure.axis.turn(disk.sectors)
    np.testing.assert_allclose(after, own @ turn.T, atol=1e-12)
    np.testing.assert_allclose(before @ turn.T, own, atol=1e-12)
    assert len(view.sections) == 1
    kinds = [trace.type for trace in view.to_plotly().data]
    assert kinds.count("mesh3d") == 3
    assert disk.plot()._repr_png_().startswith(b"\x89PNG")


def test_points_within_a_surface_are_not_drawn_as_dots():
    """Of two bodies, one has elements."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    surface = MeshSurface(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), np.zeros((12, 1)), ("a.x",))
    points = np.array([[0.5, 0.1, 0.1], [3.0, 0.0, 0.0]])
    nodes = {"a": (0.0, 0.0, 0.0)}
    structure = ss.Structure([[1.0]], [[1.0]], ["a.x"], nodes=nodes, mesh_points=points, surfaces=(surface,))
    law = ss.Macroslip(kt=1.0, mu=0.1, normal_load=1.0)
    view = model_view(ss.Problem(structure, [ss.Contact("c", law, ({"a.x": 1.0},))], [ss.Force("a.x", 1.0)], ["a.x"]))
    (faces,) = view.faces
    assert (faces.label, len(faces.triangles)) == ("surface", 4)
    np.testing.assert_allclose(next(found for found in view.points if found.label == "mesh").places, points[1:])


def test_check_draws_the_model_of_a_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_new("model", tmp_path / "mine.toml")
    study = (tmp_path / "mine.toml").read_text().replace("Blade between two pads", "<b>&quot;pads")
    (tmp_path / "mine.toml").write_text(study)
    found = CliRunner().invoke(app, ["check", "mine.toml", "--show"])
    assert found.exit_code == 0
    assert "mine_model.html" in found.output
    page = (tmp_path / "mine_model.html").read_text()
    assert "closing motion" in page
    assert "<b>&quot;pads" not in page
    assert '"text":"z in mm"' in page.replace(": ", ":")
    assert ' in m"' not in page


def test_a_model_is_drawn_in_the_units_of_its_study(rig):
    """Lengths and forces of every kind; directions stay."""
    known, shown = model_view(rig), model_view(rig, UnitSystem("mm", "kN", "kg", "ms"))
    for one, other in zip(known.points, shown.points, strict=True):
        np.testing.assert_allclose(other.places, 1e3 * one.places)
    for one, other in zip(known.arrows, shown.arrows, strict=True):
        np.testing.assert_allclose(other.feet, 1e3 * one.feet)
        np.testing.assert_array_equal(other.directions, one.directions)
    assert shown.plot().axes[0].get_zlabel() == "y in mm"
    assert shown.to_plotly().layout.scene.xaxis.title.text == "x in mm"
    texts = [arrows(view, "exciting forces").texts[0] for view in (known, shown)]
    assert texts[0].endswith(": 1 N")
    assert texts[1].endswith(": 0.001 kN")


def test_what_cannot_be_drawn_is_said(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, words in (("lumped", "needs the coordinates of its nodes"), ("damper_cycle", "draws a structure with contacts")):
        write_new(kind, tmp_path / f"{kind}.toml")
        found = CliRunner().invoke(app, ["check", f"{kind}.toml", "--show"])
        assert found.exit_code == 2
        assert words in found.output
