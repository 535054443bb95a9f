"""Nonlinear modes of a finite-element model of which no contact row is kept, against the same model with all its rows."""

from dataclasses import replace

import numpy as np
import pytest
from analyses.test_peak_shapes import parts

import stickslip as ss
from stickslip.analyses.modes.nonlinear_modes import limit_cycles_of
from stickslip.analyses.modes.work import MESH_ERRORS
from stickslip.analyses.peak_shapes import SETTLED
from stickslip.model.problem.meshed import meshed_problem
from stickslip.model.structure.matrices import Structure

MODE, ENDS = 1, (2e-5, 4e-4)


def all_rows(given=None):
    structure, *others = given or parts()
    return ss.Problem(Structure(structure.M, structure.K, structure.dofs, damping=structure.damping), *others)


def stiffer(factor):
    structure, contacts, *others = parts()
    laws = [replace(each.law, kt=factor * each.law.kt, kn=factor * each.law.kn) for each in contacts]
    return structure, [replace(each, law=law) for each, law in zip(contacts, laws, strict=True)], *others


def solved(problem, harmonics=3):
    return ss.nonlinear_modes(problem, MODE, ENDS, harmonics=harmonics, samples=128)


@pytest.fixture(scope="module")
def whole():
    return solved(all_rows())


@pytest.fixture(scope="module", params=[6e3, 12e3])
def meshed(request):
    return solved(meshed_problem(*parts(), modes_to=request.param))


def test_modes_are_those_of_all_rows_and_the_error_is_known(whole, meshed):
    """With modes up to below and far beyond the third harmonic, up to where all contacts slip."""
    right, found = (each.dataset.isel(case=0) for each in (whole, meshed))
    assert right.share_slip.max().item() > 0.5
    assert found.sizes["dof"] == meshed.problem.structure.size < 0.2 * right.sizes["dof"]
    errors = []
    for name in ("frequency", "damping_ratio"):
        values = [each[name].values[np.isfinite(each.frequency.values)] for each in (found, right)]
        few, all_of = ([each[0], each[-1], each.max()] for each in values)
        errors.append(np.abs(np.subtract(few, all_of)).max() / max(all_of))
    assert errors == pytest.approx(found.attrs[MESH_ERRORS], rel=0.05, abs=3e-7)
    assert (max(errors) < 1e-6) == (meshed.problem.modes_to > 1e4)


def test_a_result_and_its_problem_made_anew_solve_its_points_again(meshed):
    anew = ss.NonlinearModes(meshed.dataset, meshed_problem(*parts(), modes_to=meshed.problem.modes_to))
    assert pytest.approx(meshed.problem.structure.K, rel=1e-9, abs=1e-12) == anew.problem.structure.K
    cycles = limit_cycles_of(anew.dataset, meshed_problem(*parts(), modes_to=meshed.problem.modes_to), -0.08)
    assert cycles.dataset.limit_cycle.size == 1


def test_limit_cycles_are_those_of_all_rows():
    problems = all_rows(), meshed_problem(*parts(), modes_to=12e3)
    found = [ss.limit_cycles(problem, -0.08, MODE, ENDS, harmonics=1, samples=64).dataset for problem in problems]
    assert found[1].limit_cycle.size == found[0].limit_cycle.size == 1
    for name in ("frequency", "amplitude"):
        assert found[1][name].values == pytest.approx(found[0][name].values, rel=1e-4)
    assert MESH_ERRORS in found[1].attrs


def test_shapes_are_sought_until_little_is_left_out():
    """Contacts three times as stiff, where the first shapes lead to a motion that more of them do not have."""
    found = solved(meshed_problem(*stiffer(3.0), modes_to=12e3))
    assert 0.0 < max(found.dataset.attrs[MESH_ERRORS]) < SETTLED


def test_errors_of_stiff_contacts_are_known():
    """300 times as stiff: a damping ratio that is 2 % off, and said to be."""
    found = solved(meshed_problem(*stiffer(300.0), modes_to=12e3), 1).dataset
    right = solved(all_rows(stiffer(300.0)), 1).dataset
    ends = [float(each.damping_ratio[0, int(np.isfinite(each.frequency[0]).sum()) - 1]) for each in (found, right)]
    error = abs(ends[1] - ends[0]) / float(right.damping_ratio.max())
    assert error > 0.01
    assert found.attrs[MESH_ERRORS][1] == pytest.approx(error, rel=0.15)


def test_modes_beyond_those_that_are_kept_are_refused():
    """Beyond lie static shapes, whose frequencies are those of no mode."""
    problem = meshed_problem(*parts(), modes_to=6e3)
    number = problem.mesh.coordinates.modes
    assert ss.nonlinear_modes(problem, number, (1e-9, 2e-9), harmonics=1, samples=64).dataset.sizes["case"] == 1
    with pytest.raises(ss.InputError, match=f"mode must be at most {number}, the modes up to 6000 Hz, but is {number + 1}"):
        ss.nonlinear_modes(problem, number + 1, (1e-9, 2e-9), harmonics=1, samples=64)


def test_results_of_other_coordinates_are_refused(meshed):
    with pytest.raises(ss.InputError, match="The problem of the modes must have their"):
        ss.NonlinearModes(meshed.dataset, all_rows())
