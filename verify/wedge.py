"""The three-mass planar oscillator with a wedge damper: non-unique friction forces, fully specified."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.analyses.forced_response import forced_response
from stickslip.model.rigs import three_mass_wedge
from stickslip.support.units import hertz
from verify.row import Row, absolute, at_most, relative

TITLE = "Two blades and a wedge damper"
ABOUT = (
    "Start state: traction ratio m at the last sample of both contacts; 5 harmonics, 256 samples. Parameters of a "
    "public example, reference numbers computed twice with independent codes. Near the first peak the curve is flat; "
    "these codes, in which contacts land at samples, find it at 162.91 Hz and 2.275e-4 m with 256."
)
SOURCE = "two independent codes"
EVENTS = "integration from event to event (SciPy)"


def rows() -> Iterator[Row]:
    stuck = three_mass_wedge().frequencies(stuck=True)
    for mode, frequency in enumerate((84.971051, 161.981025, 225.079079, 256.629635, 399.949839, 555.087429)):
        yield absolute(f"Stuck frequency {mode + 1}, Hz", stuck[mode], frequency, 1e-6, SOURCE)
    for ratio, amplitude in ((-1.0, 3.494106e-5), (0.0, 4.928118e-5), (1.0, 6.228618e-5)):
        dataset = forced_response(three_mass_wedge(ratio), [145.0, 222.0], harmonics=5).dataset
        yield relative(f"|y2| at 222 Hz, m = {ratio:g}, m", dataset.amplitude.sel(output="2.y")[0, 1], amplitude, 1e-6, SOURCE)
    found = []
    for ratio in (-1.0, -0.5, 0.0, 0.5, 1.0):
        peaks = forced_response(three_mass_wedge(ratio), hertz(145.0, 235.0), harmonics=5).peaks()
        found.append(peaks[peaks.output == "2.y"].iloc[0])
    amplitudes = [peak.amplitude for peak in found]
    yield relative("First peak of |y2|, m = 0, m", amplitudes[2], 2.2730e-4, 3e-4, EVENTS)
    yield absolute("First peak of |y2|, m = 0: frequency, Hz", found[2].frequency, 162.98, 0.03, EVENTS)
    yield at_most("First peak of |y2|: spread over m, relative", np.ptp(amplitudes) / amplitudes[2], 1e-5, "practically unique")
