"""Campbell diagram against closed forms of one mass whose stiffness goes with the square of the speed, and of rings of masses."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.speed.models import Turning, problem_at, waves_at
from stickslip.model.structure.cyclic import cyclic

K0, K1, KT = 1e4, 2.0, 3e3  # N/m, N s²/m, N/m


def mass(speed: float) -> ss.Problem:
    """One kg, k = K0 + Ω² K1 with Ω in rad/s, a Jenkins element beside it."""
    omega = speed * 2.0 * np.pi / 60.0
    return ss.rigs.single_mass(1.0, 1.0, K0 + K1 * omega**2, KT, limit=1.0, force=1.0)


PAIR = {0.0: mass(0.0), 600.0: mass(600.0)}


def frequency(speed: np.ndarray, stuck: bool) -> np.ndarray:
    omega = speed * 2.0 * np.pi / 60.0
    return np.sqrt(K0 + K1 * omega**2 + (KT if stuck else 0.0)) / (2.0 * np.pi)


def test_frequencies_of_a_pair_of_models_are_those_of_k0_and_k1():
    found = ss.campbell(PAIR, (0.0, 1500.0), [1, 2, 4]).dataset.isel(mode=0)
    for state, stuck in (("free", False), ("stuck", True)):
        exact = np.broadcast_to(frequency(found["speed"].values, stuck), (3, 11))
        np.testing.assert_allclose(found["frequency"].sel(state=state).values, exact, rtol=1e-10)


def test_crossings_and_margins_are_those_of_the_closed_form():
    """(EO² − K1) Ω² = K0 + kt: with K1 = 2 engine order 1 never meets the mode."""
    found = ss.campbell(PAIR, (0.0, 1500.0), [1, 2, 4], operating_speed=900.0)
    for order in (1, 2, 4):
        for state, k in (("free", K0), ("stuck", K0 + KT)):
            one = found.dataset.sel(engine_order=order, state=state, mode=1)
            margin = frequency(np.array(900.0), state == "stuck") / (order * 15.0) - 1.0
            assert float(one["margin"]) == pytest.approx(float(margin), rel=1e-10)
            assert float(one["operating_frequency"]) == pytest.approx(float(margin + 1.0) * order * 15.0, rel=1e-10)
            if order == 1:
                assert np.isnan(float(one["crossing_speed"]))
                continue
            exact = np.sqrt(k / (order**2 - K1)) * 60.0 / (2.0 * np.pi)
            assert float(one["crossing_speed"]) == pytest.approx(exact, rel=1e-8)
            assert float(one["crossing_frequency"]) == pytest.approx(order * exact / 60.0, rel=1e-8)
            assert float(one["speed_margin"]) == pytest.approx(exact / 900.0 - 1.0, rel=1e-8)
    assert len(found.table()) == 9


@pytest.mark.slow
def test_the_nonlinear_resonance_is_the_peak_of_a_forced_response_at_that_speed():
    found = ss.campbell(mass, (200.0, 400.0), [4], force_level=1.2, points=3, harmonics=5).dataset.isel(mode=0)
    for k, speed in enumerate(found["speed"].values):
        low, high = (float(f) for f in frequency(np.array([speed, speed]), False) * [0.98, 1.2])
        swept = ss.forced_response(mass(speed), ss.hertz(low, high), [1.2], harmonics=5).peaks().iloc[0]
        assert float(found["frequency"].sel(state="nonlinear")[0, k]) == pytest.approx(swept["frequency"], rel=1e-3)
        assert float(found["amplitude"][0, k]) == pytest.approx(swept["amplitude"], rel=1e-2)
    one = found.sel(state="nonlinear", engine_order=4)
    assert float(one["crossing_frequency"]) == pytest.approx(4.0 * float(one["crossing_speed"]) / 60.0, rel=1e-12)
    bounds = [float(found["crossing_speed"].sel(state=state, engine_order=4)) for state in ("free", "stuck")]
    assert bounds[0] < float(one["crossing_speed"]) < bounds[1]


def test_a_level_beyond_the_mode_has_a_sentence_and_no_number():
    found = ss.campbell(mass, (300.0, 900.0), [4], force_level=1e9, points=2).dataset
    assert not np.isfinite(found["frequency"].sel(state="nonlinear").values).any()
    assert all(str(message) for message in found["message"].values.ravel())


def test_each_engine_order_of_a_disk_meets_its_own_nodal_diameter():
    disk = ss.rigs.lumped_blisk("W", sectors=6)
    faster = replace(disk.structure, stiffnesses=1.1 * disk.structure.stiffnesses, K=1.1 * disk.structure.K)
    found = ss.campbell({0.0: disk, 3000.0: disk.with_structure(faster)}, (0.0, 3000.0), [1, 2, 5], points=3).dataset.isel(mode=0)
    for order in (1, 2, 5):
        for speed, structure in ((0.0, disk.structure), (3000.0, faster)):
            exact = disk.with_structure(structure).with_engine_order(order).frequencies(stuck=True)[0]
            one = found["frequency"].sel(state="stuck", engine_order=order, speed=speed)
            assert float(one) == pytest.approx(exact, rel=1e-9)


def test_progress_names_what_is_computed():
    met = []
    ss.campbell(PAIR, (0.0, 1500.0), [1, 2], points=2, progress=lambda share, words: met.append((share, words)))
    shares = [share for share, _ in met]
    assert shares == sorted(shares)
    assert met[0] == (0.0, "natural frequencies, engine order 1, 2")
    assert shares[-1] < 1.0


@pytest.mark.parametrize(
    ("models", "given", "words"),
    [
        ({0.0: mass(0.0)}, {}, "two speeds at least"),
        ({0.0: mass(0.0), 600.0: ss.rigs.single_mass(2.0, 1.0, K0, KT)}, {}, "differ in mass"),
        ({0.0: mass(0.0), 600.0: ss.rigs.chain(3, (3,), forced=1)}, {}, "differ in degrees of freedom"),
        (
            {0.0: mass(0.0), 600.0: ss.rigs.single_mass(1.0, 1.0, K0, 2.0 * KT)},
            {},
            "differ in contacts.*press the contact by a static force",
        ),
        ({0.0: mass(0.0), 300.0: mass(300.0), 600.0: mass(600.0)}, {}, "between 0 and 600 rev/min"),
        (PAIR, {"speed": (900.0, 100.0)}, "speed must be"),
        (PAIR, {"engine_orders": []}, "at least one"),
        (PAIR, {"engine_orders": [0]}, "engine_orders"),
        (PAIR, {"mode": 2}, "mode"),
        (3.0, {}, "models must be problems by speed"),
    ],
)
def test_wrong_input_is_refused(models, given, words):
    arguments = {"speed": (0.0, 1500.0), "engine_orders": [2]} | given
    with pytest.raises(ss.InputError, match=words):
        ss.campbell(models, **arguments)


def test_k_of_disks_that_were_read_at_two_speeds_turns_between_them():
    """Two masses a sector, soft along one axis and stiff along another, which turns by 0.02; without turn K goes straight."""
    M = np.diag([1.0, 2.0])

    def problem(angle, turns):
        axis = np.array([np.cos(angle), np.sin(angle)])
        K = 1e6 * np.outer(axis, axis) + np.eye(2)
        disk = cyclic(4, ("1.x", "1.y"), [M] * 3, [K, K + 0.5 * np.eye(2), K + np.eye(2)])
        return ss.TunedDisk(replace(disk, turns=turns), (), (ss.Force("1.x", 1.0),), ("1.x",), engine_order=1)

    for turns in (False, True):
        models = {0.0: problem(0.0, turns), 6000.0: problem(0.02, turns)}
        found = problem_at(models)(6000.0 / np.sqrt(2.0)).structure
        np.testing.assert_allclose(found.K, found.at(0).K.real)
        for n in range(3):
            one, other = (model.structure.at(n).K for model in models.values())
            between = Turning.between(M, one, other).at(0.5) if turns else 0.5 * (one + other)
            np.testing.assert_allclose(found.at(n).K, between, rtol=1e-12, atol=1e-6)
            np.testing.assert_allclose(
                waves_at({v: each.disk for v, each in models.items()}, 6000.0 / np.sqrt(2.0))[n], between, atol=1e-6
            )
        lowest = np.linalg.eigvalsh(found.at(0).K)[0]
        assert lowest == pytest.approx(1.0, abs=0.05) if turns else lowest > 90.0
    assert ss.with_bodies(models[0.0].disk, {"b": ss.RigidBody(1.0, np.eye(3), (0.0, 0.0, 0.0)).structure()}).turns
