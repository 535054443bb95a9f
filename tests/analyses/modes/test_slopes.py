"""Slopes along the curve of a mode, with which cubics pass between its points, and modes of contacts that carry nothing."""

import numpy as np
import pytest

import stickslip as ss


def coupled_masses() -> ss.Problem:
    """Three masses with two sliders and a damper that couples the stuck modes."""
    K = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    structure = ss.Structure(np.diag([1.0, 1.0, 0.8]), K, ("1.x", "2.x", "3.x"), C=np.diag([0.1, 0.0, 0.02]))
    law = ss.Macroslip(0.4, 1.0, normal_load=1.0)
    sliders = [ss.Contact(f"{n}", law, (ss.between(f"{n}.x", "ground"),)) for n in (2, 3)]
    return ss.Problem(structure, sliders, (ss.Force("3.x", 1.0),), ("3.x", "1.x"))


@pytest.mark.parametrize("phase_at", [None, 1])
def test_slopes_are_the_differences_of_near_points(phase_at):
    """Two points 1e-5 apart in ln a, both in slip; with another phase the slopes are turned as the motion."""
    data = ss.nonlinear_modes(coupled_masses(), 2, (8.0, 8.0 * np.exp(1e-5)), 5, 4096, phase_at=phase_at).dataset.isel(case=0)
    assert data.share_slip.max() > 0.1
    ends = data.isel(point=[0, -1])
    change = {
        name: np.diff(values)[0]
        for name, values in (
            ("amplitude", np.log(ends.modal_amplitude.values)),
            ("frequency", np.log(ends.frequency.values)),
            ("damping", ends.damping_ratio.values),
        )
    }
    way = np.linalg.norm(list(change.values()))
    for name, difference in change.items():
        assert ends[f"{name}_slope"].values.mean() == pytest.approx(difference / way, rel=1e-3, abs=1e-7)
    if phase_at is None:
        shape, slope = (ends[name].values @ [1.0, 1.0j] for name in ("mode_shape", "shape_slope"))
        np.testing.assert_allclose(
            slope.mean(axis=0), np.diff(shape, axis=0)[0] / way, rtol=1e-3, atol=1e-4 * np.abs(slope).max()
        )


def test_peaks_do_not_depend_on_the_phase():
    peaks = [
        ss.nonlinear_modes(coupled_masses(), 2, (0.5, 50.0), 3, 256, phase_at=phase_at).peaks([1.0, 2.0])
        for phase_at in (None, 1)
    ]
    np.testing.assert_allclose(peaks[0], peaks[1], rtol=1e-12)


def one_mass(**law: float) -> ss.Problem:
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.02 * np.eye(1))
    slider = ss.Contact("slider", ss.Macroslip(1.0, **law), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",))


def unloaded_contact() -> ss.Problem:
    """A contact that closes without gap or preload, and a mode along it."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 2.1]), ("1.x", "1.y"), C=0.02 * np.eye(2))
    law = ss.Macroslip(1.0, 0.3, 1.0, preload=0.0)
    contact = ss.Contact("contact", law, (ss.between("1.x", "ground"),), ss.between("1.y", "ground"))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))


@pytest.mark.parametrize(
    "problem", [one_mass(mu=0.0, normal_load=1.0), one_mass(mu=0.3, normal_load=0.0), unloaded_contact()],
    ids=["no friction", "no normal load", "no preload"],
)  # fmt: skip
def test_the_mode_of_a_contact_that_carries_nothing_is_linear(problem):
    data = ss.nonlinear_modes(problem, 1, (1e-2, 10.0)).dataset.isel(case=0)
    assert str(data.case_message.values) == "The curve reached the largest amplitude."
    assert data.amplitude.values[-1, 0] == pytest.approx(10.0, rel=1e-9)
    np.testing.assert_allclose(2.0 * np.pi * data.frequency, 1.0, rtol=1e-9)
    np.testing.assert_allclose(data.damping_ratio, 0.01, rtol=1e-9)
