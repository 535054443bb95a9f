"""Contacts at rest: each by hand, by surface in equilibrium with what presses them, in results and files of other programs."""

from xml.etree import ElementTree

import numpy as np
import pytest
from study.test_many_contacts_study import SWEEP, from_mesh  # noqa: F401
from study.test_surfaces_study import folder  # noqa: F401
from typer.testing import CliRunner

import stickslip as ss
from stickslip.analyses.static_load import as_lines, by_surface, rest_of
from stickslip.cli import app
from stickslip.model.problem.at_rest import at_rest, rest_variables
from stickslip.rigs import blade_root
from stickslip.study import job
from stickslip.support.units import UNIT_SYSTEMS


def pads(*contacts, along=0.0, across=0.0):
    """A mass on springs of 2 N/m along x and 4 N/m along z, beside pads."""
    structure = ss.Structure(np.eye(2), np.diag([2.0, 4.0]), ("m.x", "m.z"), C=np.eye(2))
    return ss.Problem(structure, contacts, (ss.Force("m.x", 1.0, static=along), ss.Force("m.z", static=across)), ("m.x",))


def test_each_contact_by_hand():
    """8 N across close the pad at z = 1 m with 4 N; 6 N along drag it to μN = 2 N at 2 m, where 3 N/m hold 2/3 m. The stop above
    is 1.5 m off, the far one half open, and the spring has no load that anything states."""
    pad = ss.Contact("pad", ss.Macroslip(kt=3.0, mu=0.5, kn=4.0), ({"m.x": 1.0},), {"m.z": 1.0})
    stop = ss.Contact("stop", ss.Gap(kn=8.0, gap=0.5), (), {"m.z": -1.0})
    two = ss.MicroslipArray((1.0, 1.0), 0.5, kn=(1e-12, 1e-12), gaps=(0.25, 3.0))
    half = ss.Contact("half", two, ({"m.x": 1e-9},), {"m.z": 1.0})
    grip = ss.Contact("grip", ss.Macroslip(kt=1e-12, mu=0.5, normal_load=3.0), ({"m.x": 1.0},))
    spring = ss.Contact("spring", ss.CubicSpring(1e-12), ({"m.x": 1.0},))
    problem = pads(pad, stop, half, grip, spring, along=6.0, across=8.0)
    found = rest_variables(problem, at_rest(problem))
    np.testing.assert_allclose(found["rest_load"], [4.0, 0.0, 0.75e-12, 3.0, np.nan], atol=1e-9)
    np.testing.assert_allclose(found["rest_friction"], [2.0, 0.0, 0.0, 0.0, 0.0], atol=1e-8)
    np.testing.assert_allclose(found["rest_gap"], [0.0, 1.5, 0.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(found["rest_slip"][:2], [2.0 - 2.0 / 3.0, 0.0], rtol=1e-9)
    assert found["rest_state"].tolist()[:2] == [2, 0]
    assert found["rest_state"].tolist()[3] == 1
    assert [record["surface"] for record in by_surface(rest_of(problem))] == ["pad", "stop", "half", "grip"]


def test_friction_and_slip_in_two_directions_are_sizes():
    """3 and 4 N along both directions, of which 2 and 3 N slip: a limit of 1 N along each, and 1 N/m."""
    structure = ss.Structure(np.eye(2), np.eye(2), ("m.x", "m.y"), C=np.eye(2))
    law = ss.Macroslip(kt=1.0, mu=0.5, normal_load=2.0)
    pad = ss.Contact("pad", law, ({"m.x": 1.0}, {"m.y": 1.0}))
    problem = ss.Problem(structure, (pad,), (ss.Force("m.x", 1.0, static=3.0), ss.Force("m.y", static=4.0)), ("m.x",))
    (record,) = by_surface(rest_of(problem))
    assert record["friction [N]"] == pytest.approx(np.hypot(1.0, 1.0))
    assert record["slip [m]"] == pytest.approx(np.hypot(1.0, 2.0))


def test_the_flanks_of_a_root_carry_its_pull():
    """N = F/(2 (cos a + μ sin a)) where it slips outwards; after 1.44 times the pull the root springs back, stuck."""
    stiffness = 0.5 * (1e9 + 8e8)  # kn cos² a + kt sin² a, of one flank
    back = 0.44 * 5e3 / (2.0 * stiffness) * np.sqrt(0.5)
    slipping = 5e3 / (2.0 * np.sqrt(0.5) * 1.3)
    for steps, load, friction in (
        ([], slipping, 0.3 * slipping),
        ([1.44], 1.44 * slipping - 1e9 * back, 1.44 * 0.3 * slipping - 8e8 * back),
    ):
        problem = blade_root(pull=5e3)
        records = by_surface(rest_of(ss.after_load_steps(problem, steps) if steps else problem))
        assert [record["surface"] for record in records] == ["left", "right"]
        for record in records:
            assert record["contacts"] == 8
            assert record["normal load [N]"] == pytest.approx(load, rel=1e-6)
            assert 8.0 * record["friction [N]"] == pytest.approx(abs(friction), rel=1e-6)
            assert record["at friction limit"] == (0 if steps else 8)


def test_surfaces_of_a_study_are_in_equilibrium_and_the_same_from_the_mesh(folder, from_mesh, monkeypatch):  # noqa: F811
    """60 N pull the damper; normals of both platforms lean inwards, so that their loads and friction balance it."""
    mesh = job(SWEEP, folder, "rest").sweep.problem
    assert mesh.mesh is not None
    monkeypatch.undo()
    rows = job(SWEEP.replace("modes = 6", "modes = 60"), folder, "rest").sweep.problem
    one, other = (by_surface(rest_of(problem), UNIT_SYSTEMS["mm-t-s"]) for problem in (mesh, rows))
    for few, all_rows in zip(one, other, strict=True):
        assert few["normal load [N]"] == pytest.approx(all_rows["normal load [N]"], rel=1e-3)
        assert few["slip [mm]"] == pytest.approx(all_rows["slip [mm]"], rel=5e-3)
        assert few["least [N]"] <= few["largest [N]"] <= few["normal load [N]"]
        assert few["friction [N]"] <= 0.4 * few["largest [N]"] * np.sqrt(2.0)
    rest, total = at_rest(rows), np.zeros(3)
    forces = iter(rest.forces)
    for contact in rows.contacts:
        for direction in contact.directions:
            total += next(forces) * np.array([direction.get(f"damper/centre.{axis}", 0.0) for axis in "xyz"])
    np.testing.assert_allclose(total[:2], [0.0, 60.0], atol=1e-6)  # along z a mean spring holds the damper too


def test_results_tables_and_files_have_them(folder):  # noqa: F811
    text = (
        SWEEP.replace("[sweep]", "[sweep]\nsamples = 64").replace("[0.3, 1.0]", "[0.3]").replace("harmonics = 3", "harmonics = 1")
    )
    (folder / "kept.toml").write_text(text.replace("[480.0, 620.0]", "[480.0, 490.0]"))
    for command in (
        ("run", folder / "kept.toml", "--out", folder / "kept", "--workers", "1"),
        ("export", folder / "kept", "--out", folder / "kept.csv"),
        ("export", folder / "kept", "--out", folder / "kept.vtu"),
    ):
        result = CliRunner().invoke(app, [str(each) for each in command])
        assert result.exit_code in (0, 3), result.output
    data = ss.open_results(folder / "kept" / "results.nc")
    records = by_surface(data, UNIT_SYSTEMS["mm-t-s"])
    names = [contact.name for contact in job((folder / "kept.toml").read_text(), folder, "kept").sweep.problem.contacts]
    assert [name.rpartition(" ")[0] for name in names] == data["contact_surface"].values.tolist()
    page, table = ((folder / name).read_text() for name in ("kept/report.html", "kept_contacts_at_rest.csv"))
    assert "contacts at rest" in page.lower()
    assert table.splitlines()[0] == ",".join(records[0])
    assert float(table.splitlines()[1].split(",")[4]) == pytest.approx(records[0]["normal load [N]"])
    arrays = {
        array.get("Name"): np.array(array.text.split(), dtype=float)
        for array in ElementTree.parse(folder / "kept_contacts.vtu").iter("DataArray")
    }
    assert len(arrays["state at rest"]) == len(names) == data.sizes["contact_node"]
    assert arrays["load at rest [N]"].sum() == pytest.approx(sum(record["normal load [N]"] for record in records), rel=1e-5)
    area = 1e6 * data["contact_area"].values
    np.testing.assert_allclose(arrays["pressure at rest [MPa]"] * area, arrays["load at rest [N]"], rtol=1e-5)
    places = arrays["points"].reshape(-1, 3)
    assert np.ptp(places[:, 0]) > 10.0
    np.testing.assert_array_equal(arrays["connectivity"], np.arange(len(names)))
    assert set(arrays["types"]) == {1.0}


def test_patches_and_many_contacts():
    """A patch stands for several nodes; of many contacts by themselves the table has the first."""
    contacts = [ss.Contact(f"c{k}", ss.Macroslip(1.0, 0.5, normal_load=1.0 + k), ({"m.x": 1.0},)) for k in range(70)]
    lines = as_lines(by_surface(rest_of(pads(*contacts, along=1.0))))
    assert lines[-1] == "... (70 in all)"
    assert len(lines) == 62
    assert len({len(line) for line in lines[:-1]}) == 1
    assert rest_of(pads()) == {}
    loose = ss.Structure(np.eye(2), np.diag([1.0, 0.0]), ("m.x", "m.z"), C=np.eye(2))
    floor = ss.Contact("floor", ss.Macroslip(1.0, 0.5, kn=1.0), ({"m.x": 1.0},), {"m.z": 1.0})
    assert rest_of(ss.Problem(loose, (floor,), (ss.Force("m.x", 1.0), ss.Force("m.z", static=-1.0)), ("m.x",))) == {}


def test_a_start_state_that_is_no_place_is_no_slip():
    """A traction ratio of one half carries μN/2 = 0.5 N, and no slider has gone anywhere."""
    law = ss.Macroslip(kt=1.0, mu=0.5, normal_load=2.0)
    pad = ss.Contact("pad", law, ({"m.x": 1.0},), start=ss.TractionRatio(0.5))
    (record,) = by_surface(rest_of(pads(pad, along=1.0)))
    assert record["slip [m]"] == 0.0
    assert record["friction [N]"] == pytest.approx(0.5)
