"""Commented study files to begin with. `KINDS` names them; a kind writes the study and whatever files it needs beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from stickslip.checks import fault, nearest
from stickslip.files import replacing, write_text
from stickslip.rigs import three_mass_wedge
from stickslip.study.damper_cycle import TEMPLATE as DAMPER_CYCLE
from stickslip.study.identification_template import write_identification
from stickslip.study.mistuning import TEMPLATE as MISTUNING
from stickslip.study.model_template import write_model

FORCE_LEVELS = (1.0, 5.0, 20.0, 50.0, 80.0, 100.0)
"""Force levels of the published experiment on the single blade, N."""

SINGLE_BLADE = """\
# Forced response of one blade between two underplatform dampers, a rig that is meshed and reduced on the spot.
# `stickslip check FILE` validates this file, `stickslip run FILE --out DIR` computes it.

[study]
title = "Single blade with two dampers, {preload_mass:g} kg"
analysis = "forced_response"

[structure]
rig = "single_blade"              # a ready problem: structure, dampers, contacts, load and outputs

[structure.parameters]            # arguments of the rig, in SI; leave one out for its default
preload_mass = {preload_mass}                # kg; its weight pulls each damper against the platforms; published: 2.6, 4.6, 6.6

[sweep]
frequency = [390.0, 600.0]        # Hz: continue over this band; or at = [520.0, 530.0]: solve exactly there
force_levels = {force_levels}     # factors on the harmonic force of the rig, 1 N
harmonics = {harmonics}                     # highest harmonic H
samples = 256                     # samples of a period
"""

WEDGE = """\
# Two blades and a wedge damper between them as three masses in a plane: matrices and contacts by name.
# `stickslip check FILE` validates this file, `stickslip run FILE --out DIR` computes it. SI units; see `units` in the
# documentation for others.

[study]
title = "Two blades and a wedge damper"
analysis = "forced_response"

[structure]
matrices = "{matrices}"           # M, K and C by these names, .npz or .mat; the path counts from this file
dofs = ["1.x", "1.y", "2.x", "2.y", "D.x", "D.y"]  # NODE.DIRECTION, in the order of the matrices

# When the file has no C:
# [damping]
# modal = 0.005                   # of all modes; or a list; or rayleigh = [a, b] for C = a M + b K
# on = "stuck"                    # modes with the contacts stuck, or "free": without them

# A contact: A relative to B, as [A, B] (one may be "ground") or as coefficients. Here the damper slides along the two
# platforms, which are inclined by 30 degrees.
[[contact]]
name = "blade 1"
law = "macroslip"                 # or "microslip_array", "gap"
tangential = {{ "D.x" = {c}, "D.y" = {s}, "1.x" = -{c}, "1.y" = -{s} }}
normal = {{ "D.x" = -{s}, "D.y" = {c}, "1.x" = {s}, "1.y" = -{c} }}  # positive closes
kt = 3e5                          # tangential stiffness, N/m
kn = 3e5                          # normal stiffness, N/m
mu = 0.5
start = {{ traction_ratio = 0.0 }}  # state at the last sample; or slider_offset (default, 0), mean_traction

[[contact]]
name = "blade 2"
law = "macroslip"
tangential = {{ "D.x" = {c}, "D.y" = -{s}, "2.x" = -{c}, "2.y" = {s} }}
normal = {{ "D.x" = {s}, "D.y" = {c}, "2.x" = -{s}, "2.y" = -{c} }}
kt = 3e5
kn = 3e5
mu = 0.5
start = {{ traction_ratio = 0.0 }}

[[force]]
at = "1.y"
amplitude = [0.0, 20.0]           # [re, im], N: F cos wt is [F, 0], F sin wt is [0, -F]

[[force]]
at = "2.x"
amplitude = [0.0, -5.0]

[[force]]
at = "D.y"
static = 120.0                    # the pull on the damper; force levels leave it as it is

[sweep]
frequency = [145.0, 235.0]        # Hz: continue over this band; or at = [150.0, 222.0]: solve exactly there
force_levels = [0.2, 0.5, 1.0]    # multiply every harmonic force
harmonics = 5
samples = 256
outputs = ["2.y", "1.y"]
"""

BLISK = """\
# Forced response of a bladed disk with a damper between all neighbours under engine-order excitation. One sector of finite
# elements stands for all 24; meshing and reducing it takes some seconds.
# `stickslip check FILE` validates this file, `stickslip run FILE --out DIR` computes it.

[study]
title = "Bladed disk with cylindrical dampers, engine order 2"
analysis = "forced_response"

[structure]
rig = "octopus_blisk"             # finite elements; or "lumped_blisk": three masses a sector, seconds for everything

[structure.parameters]            # arguments of the rig, in SI; leave one out for its default
contact = "measured"              # published contact stiffness: "measured" or "analytic"; or ktx, kty, kn = totals of a line, N/m
engine_order = 2                  # blade j is forced by F cos(wt - 2 pi EO j/24); at most the number of sectors
pull = 147.0                      # centrifugal force of each damper, N
mu = 0.6

[sweep]
frequency = [138.0, 150.0]        # Hz: continue over this band
force_levels = [0.2, 0.4]         # N on each blade
harmonics = 3                     # highest harmonic H; harmonic h has nodal diameter h EO modulo 24
samples = 96                      # of a period; raised until the delay between neighbours is a whole number of them
"""

VARIABILITY = """\
# {about}
# `stickslip check FILE` validates this file, `stickslip run FILE --out DIR` computes it.

[study]
title = "Two blades and a wedge damper: {title}"
analysis = "{analysis}"

[structure]
rig = "three_mass_wedge"          # two blades and a wedge damper; or "single_blade", which takes minutes per force level

[sweep]
frequency = [200.0, 235.0]        # Hz
force_levels = [0.5, 1.0]         # factors on the harmonic force of the rig
harmonics = 5                     # highest harmonic H
samples = 256                     # samples of a period

{table}
rule = "slider_offset"            # what a start variable sets; or "traction_ratio", "mean_traction"
share = "element"                 # one variable per friction element; or per "direction", "contact", for "all"
seed = 0                          # of the random draws
"""

BOUNDS_TABLE = """\
[bounds]
objective = "amplitude"           # at each frequency; or "peak": of the resonance; or "loss_factor", its published proxy
points = 25                       # frequencies over the band
cloud = 60                        # start states sampled at each frequency
starts = 3                        # how many of them begin a search"""

SAMPLES_TABLE = """\
[samples]
count = 20                        # start states; the first is virgin
method = "latin"                  # hypercube; or "random", "corners"
points = 29                       # solve exactly at so many frequencies of the band: percentiles need common ones
# law = "beta"                    # what every variable follows: a distribution of scipy.stats; uniform unless given
# parameters = { a = 0.5, b = 0.5 }"""


PERFORMANCE = """\
# Performance curves: resonance amplitude and frequency against F_C/F_E, the pull on the damper over the excitation.
# `stickslip check FILE` validates this file, `stickslip run FILE --out DIR` computes it.

[study]
title = "Blade and wedge: performance curves"
analysis = "performance_curve"

[structure]
rig = "blade_and_wedge"           # one blade mode and a wedge; or "two_semi_cylinders", "single_blade"

[structure.parameters]            # arguments of the rig, in SI; leave one out for its default
pull = 60.0                       # N, F_C
platform_angle = 35.0             # degrees

[sweep]
frequency = [280.0, 390.0]        # Hz: the band in which resonances are sought
harmonics = 5                     # highest harmonic H
samples = 256                     # samples of a period

[performance]
force_ratio = [3.0, 100.0]        # F_C/F_E from, to
points = 30                       # in equal ratios
friction = [0.2, 0.4]             # coefficients put at every contact; leave out for those of the rig
vary = "force"                    # the excitation changes; or "preload"
check_every = 10                  # points between two full sweeps that look for new peaks
"""

DESIGN = """\
# Design of a damper: the arguments of a rig that make its worst resonance least, over force, friction and start states.
# `stickslip check FILE` validates this file, `stickslip run FILE --out DIR` computes it.

[study]
title = "Blade and wedge: design"
analysis = "damper_design"

[design]
rig = "blade_and_wedge"           # or "two_semi_cylinders", which takes minutes
parameters = { kt = 8e5, kn = 1.2e6 }  # arguments that stay, in SI
variables = { damper_mass = [0.02, 0.1], platform_angle = [15.0, 60.0] }  # kg, degrees
acceleration = 3000.0             # m/s2: the pull follows the mass
force = [5.0, 20.0]               # range of the force level
levels = 2                        # force levels between them
friction = 0.4                    # nominal; anything from 0.28 to 0.57 with
friction_factor = 2.0             # from the least to the largest
starts = 1                        # drawn start states beside virgin contacts
no_jamming = "platform_angle"     # 1 - mu tan(angle) stays positive
no_lift_off = true                # no contact point may open
designs = 8                       # first look at the design space
refinements = 8                   # designs of the search that follows
samples = 128                     # of a period
"""


def single_blade_study(preload_mass: float = 4.6, force_levels: Sequence[float] = FORCE_LEVELS, harmonics: int = 5) -> str:
    """The study of the single-blade rig, as text."""
    return SINGLE_BLADE.format(preload_mass=float(preload_mass), force_levels=list(map(float, force_levels)), harmonics=harmonics)


def write_forced_response(path: Path) -> list[Path]:
    """The single-blade rig."""
    return [write_text(path, single_blade_study())]


def write_lumped(path: Path) -> list[Path]:
    """The three-mass wedge, with its matrices beside it."""
    structure = three_mass_wedge().structure
    matrices = path.with_suffix(".npz")
    with replacing(matrices) as temporary:
        np.savez(temporary, M=structure.M, K=structure.K, C=np.asarray(structure.C))
    text = WEDGE.format(matrices=matrices.name, c=repr(float(np.cos(np.pi / 6))), s="0.5")
    return [write_text(path, text), matrices]


def write_blisk(path: Path) -> list[Path]:
    """The bladed disk of finite elements."""
    return [write_text(path, BLISK)]


def write_bounds(path: Path) -> list[Path]:
    """Bounds of the wedge over all start states."""
    about = "The highest and lowest response over all states from which friction contacts may start, beside the response itself."
    text = VARIABILITY.format(about=about, title="bounds", analysis="response_bounds", table=BOUNDS_TABLE)
    return [write_text(path, text)]


def write_samples(path: Path) -> list[Path]:
    """A cloud of responses of the wedge."""
    about = "Responses of one problem from many states of its friction contacts."
    text = VARIABILITY.format(about=about, title="samples", analysis="response_samples", table=SAMPLES_TABLE)
    return [write_text(path, text)]


def write_damper_cycle(path: Path) -> list[Path]:
    """The laboratory damper between two platforms."""
    return [write_text(path, DAMPER_CYCLE)]


KINDS: dict[str, Callable[[Path], list[Path]]] = {
    "forced_response": write_forced_response,
    "lumped": write_lumped,
    "model": write_model,
    "blisk": write_blisk,
    "bounds": write_bounds,
    "samples": write_samples,
    "damper-cycle": write_damper_cycle,
    "performance": lambda path: [write_text(path, PERFORMANCE)],
    "identification": write_identification,
    "design": lambda path: [write_text(path, DESIGN)],
    "mistuning": lambda path: [write_text(path, MISTUNING)],
}


def write_new(kind: str, path: Path, overwrite: bool = False) -> list[Path]:
    """Write a study of a kind to `path`; returns the paths of all files written."""
    if kind not in KINDS:
        raise fault("KIND", "must be a known one", kind, f"{nearest(kind, KINDS)} Kinds: {', '.join(KINDS)}.")
    for existing in (path, path.with_suffix(".npz")):
        if existing.exists() and not overwrite:
            raise fault("FILE", "must not exist yet", str(existing), "Name another, or add --force.")
    if path.suffix != ".toml":
        raise fault("FILE", "must end in .toml", str(path))
    return KINDS[kind](path)
