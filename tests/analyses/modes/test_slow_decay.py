"""The damping of a slow decay from a nonlinear mode, against time integration."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.modes.slow_decay import decay_damping


def beside(problem, size, released, duration, steps, **fineness):
    """Damping ratios at amplitudes (n,) of the first output: of half cycles in time, of a decay along the mode, of the mode."""
    decay = ss.free_decay(problem, duration, displacement={problem.structure.dofs[0]: released}, steps=steps)
    half = decay.dataset.isel(output=0)
    known = np.isfinite(half["damping_ratio"].values)
    found = [np.interp(-size, -half["amplitude"].values[known], half["damping_ratio"].values[known])]
    modes = ss.nonlinear_modes(problem, amplitude=(0.8 * size.min(), 1.2 * size.max()), **fineness)
    shown, mode = decay.with_modes(modes).dataset.isel(mode=0), modes.dataset.isel(case=0)
    along = shown["mode_amplitude"].values[:, 0]
    found += [np.interp(size, along, values) for values in (shown["mode_damping_ratio"].values, mode["damping_ratio"].values)]
    return found


def test_of_a_joint_in_microslip():
    """Four amplitudes with up to 1.4 % of damping: within 0.7 %, where the mode itself is up to 7 % low."""
    size = np.array([5.0, 3.0, 2.0, 1.2]) * 1e-4
    time, along, mode = beside(ss.rigs.jointed_mode(count=40), size, 8e-4, 2.0, 20_000, harmonics=3, samples=128)
    assert along == pytest.approx(time, rel=0.01)
    assert mode[0] < 0.94 * time[0]


def test_of_a_slider_and_of_viscous_damping():
    """Within 1 % while it slips, where the mode is up to 3 % low; and the mode's own while it sticks."""
    problem = ss.rigs.single_mass(kt=0.05, limit=0.05, damping=2e-3)
    size = np.array([5.0, 3.3, 2.15, 1.72, 0.95])
    time, along, mode = beside(problem, size, 7.0, 400.0, 20_000, harmonics=3, samples=256)
    assert along == pytest.approx(time, rel=0.01)
    assert np.all(mode[1:4] < 0.99 * time[1:4])
    assert along[-1] == pytest.approx(mode[-1], rel=1e-6)


def test_by_hand():
    """A mode of constant shape whose frequency falls as the tenth root of its amplitude, and what has no curve."""
    size = np.geomspace(1.0, 2.0, 400)
    frequency = size**-0.1
    energy = 0.5 * (2.0 * np.pi * frequency * size) ** 2
    found = decay_damping(frequency, np.full(400, 0.01), energy, size)
    assert found == pytest.approx(np.full(400, 0.01 / 0.8), rel=1e-6)
    of_output = decay_damping(frequency, np.full(400, 0.01), energy, size**1.5)  # an output that grows faster than the mode
    assert of_output == pytest.approx(np.full(400, 0.015 / 0.8), rel=1e-6)
    lost = decay_damping(*np.full((4, 3), np.nan))
    assert np.all(np.isnan(lost))
    padded = decay_damping(*(np.append(one, np.nan) for one in (frequency, np.full(400, 0.01), energy, size)))
    assert padded[:-1] == pytest.approx(found)
