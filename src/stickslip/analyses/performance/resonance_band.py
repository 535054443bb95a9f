"""Search band for resonances, from the free to the stuck one, and the message if it holds none."""

from __future__ import annotations

from stickslip.analyses.arguments import Ends
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.peaks.linear import linear_peak
from stickslip.support.checks import InputError, fault
from stickslip.support.units import Band

OUTSIDE = (0.9, 1.1)
"""How far the band reaches beyond the free and the stuck resonance."""


def resonance_band(balance: HarmonicBalance, output: int) -> Band:
    """A band that holds the free and the stuck resonance of an output."""
    peaks = [linear_peak(balance, output, stuck).frequency for stuck in (False, True)]
    return Band(OUTSIDE[0] * min(peaks), OUTSIDE[1] * max(peaks))


def no_resonance(balance: HarmonicBalance, output: int, band: Ends, where: str = "") -> InputError:
    """The fault of a band in Hz that holds no resonance of an output; where: " at 5 N", say."""
    free, stuck = (linear_peak(balance, output, stuck).frequency for stuck in (False, True))
    remedy = f"The highest resonance without contacts is at {free:.5g} Hz, that with contacts stuck at {stuck:.5g} Hz."
    return fault("The band of frequencies", f"must hold a resonance{where}", f"{band[0]:g} to {band[1]:g} Hz", remedy)
