"""The first point of a curve, where Newton's method fails from the stuck state."""

import numpy as np

import stickslip as ss
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation import continuation


def test_a_ramp_of_the_force_level_comes_before_the_patient_search(monkeypatch):
    """On this blade the patient search costs four times the ramp, and fails."""
    descended, level = continuation._descended, 160.0

    def fails_at_the_level(balance, omega, at, iterations):
        return descended(balance, omega, at, 0 if at == level else iterations)

    monkeypatch.setattr(continuation, "_descended", fails_at_the_level)
    monkeypatch.setattr(continuation, "_patient", None)
    balance = HarmonicBalance(ss.rigs.single_blade(4.6), 5, 256)
    first = continuation.first_point(balance, 2.0 * np.pi * 540.0, level)
    assert first.converged
    assert first.evaluation.point.level == level
