"""Figures of docs/modes.md: the nonlinear mode of the single blade, and the peaks from it."""

from pathlib import Path

import stickslip as ss

HERE = Path(__file__).parent

modes = ss.nonlinear_modes(ss.rigs.single_blade(4.6), 1, (2e-8, 2e-5))
modes.plot().savefig(HERE / "nonlinear_mode.svg", metadata={"Date": None})
modes.plot("peaks").savefig(HERE / "nonlinear_mode_peaks.svg", metadata={"Date": None})
