"""A study of an identification to begin with, beside two synthetic loops whose truth is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stickslip.dampers.platform_motion import in_phase, out_of_phase
from stickslip.files import write_text
from stickslip.measurement.records import write_record
from stickslip.measurement.rig_errors import RigErrors
from stickslip.measurement.synthetic import synthetic_record, true_cycle
from stickslip.rigs.laboratory_damper import laboratory_damper

TEMPLATE = """\
# Contact parameters of a damper between two platforms from its measured loops. The loops beside this file are synthetic, with
# the errors of a rig; their truth is kt = 56 and kn = 84 N/um, mu = 0.18, 0.199 and 0.45 at L1, L2 and R.
# `stickslip run FILE --out DIR` identifies them; `stickslip identify LOOP... --damper FILE --out DIR` takes other loops.

[study]
title = "Contact parameters of a three-point damper"
analysis = "identification"

[damper]
shape = "three_point"             # or "crossed_curved_flat", "curved_flat"
left_angle = 37.0                 # slopes of the platforms, degrees
right_angle = 37.0
dimensions = {{ foot_distance = 14e-3 }}  # m; others have their defaults
pull = 80.0                       # N
kt = 50e6                         # N/m; what is known stays, what is unknown is found whatever stands here
kn = 80e6                         # N/m
mu = 0.3

[identification]
loops = ["{first}", "{second}"]   # columns by name with units: time [s], platform_x [um], force_x [N], ...
unknown = ["kt", "kn", "mu_L1", "mu_L2", "mu_R"]  # of all lines of contact, or of those whose names begin so
errors = {{ cell_gain = 0.01, zero = 0.8, linearity = 0.5, motion_gain = 0.05 }}  # standard deviations: 1, N, N, 1
resamples = 24                    # refits for the intervals
"""


def write_identification(path: Path) -> list[Path]:
    """Two synthetic loops of the laboratory damper, and what is to be found of it."""
    rig, errors = laboratory_damper(37.0), RigErrors()
    systematic, loops = errors.draw(np.random.default_rng(0)), []
    for seed, (name, motion) in enumerate({"out_of_phase": out_of_phase(30e-6), "in_phase": in_phase(30e-6)}.items()):
        record = synthetic_record(true_cycle(rig, motion), errors, seed=seed, systematic=systematic, cycles=10, name=name)
        loops.append(write_record(record, path.with_name(f"{path.stem}_{name}.csv")))
    return [write_text(path, TEMPLATE.format(first=loops[0].name, second=loops[1].name)), *loops]
