"""Old names in study files and of their templates: still read for one release, with a note that gives the new name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

TABLES = {
    "bounds": "response_bounds",
    "samples": "response_samples",
    "starts": "steady_cycles",
    "evolution": "damper_evolution",
    "performance": "performance_curve",
    "design": "damper_design",
    "mistuning": "mistuned_population",
    "what_matters": "sensitivity_indices",
}
ANALYSES = {"what_matters": "sensitivity_indices"}
TEMPLATES = {
    "bounds": "response_bounds",
    "samples": "response_samples",
    "damper-cycle": "damper_cycle",
    "steady-cycles": "steady_cycles",
    "damper-evolution": "damper_evolution",
    "performance": "performance_curve",
    "band": "performance_band",
    "design": "damper_design",
    "what-matters": "sensitivity_indices",
    "mistuning": "mistuned_population",
}


def with_new_names(document: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The document of a study under the new names, and a note on each old one; an old table beside the new one stays."""
    renamed = {key: TABLES[key] for key in document if key in TABLES and TABLES[key] not in document}
    notes = [f"The table [{old}] is now called [{new}]; the old name will stop working." for old, new in renamed.items()]
    found = {renamed.get(key, key): value for key, value in document.items()}
    study = found.get("study")
    analysis = study.get("analysis") if isinstance(study, dict) else None
    if isinstance(study, dict) and isinstance(analysis, str) and analysis in ANALYSES:
        new = ANALYSES[analysis]
        found["study"] = study | {"analysis": new}
        notes.append(f'The analysis "{analysis}" is now called "{new}"; the old name will stop working.')
    return found, notes
