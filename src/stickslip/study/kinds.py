"""Analyses available in study files, by their name in `[study] analysis`. Add a new one here."""

from __future__ import annotations

from stickslip.study.analysis import Kind
from stickslip.study.damper_cycle import DAMPER_CYCLE
from stickslip.study.damper_cycles import DAMPER_EVOLUTION, STEADY_CYCLES
from stickslip.study.design import DAMPER_DESIGN
from stickslip.study.forced_response import FORCED_RESPONSE
from stickslip.study.identification import IDENTIFICATION
from stickslip.study.mistuning import MISTUNED_POPULATION
from stickslip.study.performance import PERFORMANCE_BAND, PERFORMANCE_CURVE
from stickslip.study.sensitivity_indices import SENSITIVITY_INDICES
from stickslip.study.variability import RESPONSE_BOUNDS, RESPONSE_SAMPLES

KINDS: dict[str, Kind] = {
    "forced_response": FORCED_RESPONSE,
    "response_bounds": RESPONSE_BOUNDS,
    "response_samples": RESPONSE_SAMPLES,
    "damper_cycle": DAMPER_CYCLE,
    "steady_cycles": STEADY_CYCLES,
    "damper_evolution": DAMPER_EVOLUTION,
    "performance_curve": PERFORMANCE_CURVE,
    "performance_band": PERFORMANCE_BAND,
    "damper_design": DAMPER_DESIGN,
    "sensitivity_indices": SENSITIVITY_INDICES,
    "identification": IDENTIFICATION,
    "mistuned_population": MISTUNED_POPULATION,
}

PROBLEM_KEYS = ("structure", "damping", "contact", "force", "dashpot", "base", "sweep")
"""Tables that state a problem and where to compute it, for every analysis of one."""
COMMON_KEYS = ("units", "study", *PROBLEM_KEYS)
KEYS = (*COMMON_KEYS, *dict.fromkeys(key for kind in KINDS.values() for key in kind.tables))


def owners(key: str) -> list[str]:
    """The analyses that a table belongs to."""
    return [name for name, kind in KINDS.items() if key in kind.tables or (key in PROBLEM_KEYS and kind.on_problem)]
