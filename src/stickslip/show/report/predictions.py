"""Presentations of predicted responses and decays."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.laboratory.identification.response.decay_prediction import (
    comparison_table as decay_comparison_table,
)
from stickslip.laboratory.identification.response.decay_prediction import (
    decay_table,
    whole_tables,
)
from stickslip.laboratory.identification.response.decay_prediction import (
    failures as decay_failures,
)
from stickslip.laboratory.identification.response.decay_prediction import (
    summary as decay_summary,
)
from stickslip.laboratory.identification.response.prediction_result import (
    comparison_table,
    curve_table,
    failures,
    peak_table,
    summary,
)
from stickslip.show.plots.identification import predicted, predicted_decay, predicted_peaks
from stickslip.show.plots.paper import Figures
from stickslip.show.report.markup import Presentation, presents
from stickslip.support.late import pd, xr


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The predicted peaks, and the measured curves against what is predicted of them."""
    found = {"predicted peaks": peak_table(dataset)}
    return found | ({"measured against predicted": comparison_table(dataset)} if "measured" in dataset.sizes else {})


def histories(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The predicted curves with their bands."""
    return {"predicted curves": curve_table(dataset)}


def figures(dataset: xr.Dataset) -> Figures:
    """Curves with their bands, and peaks over the levels."""
    return {"predicted": predicted, "predicted_peaks": predicted_peaks}


PRESENTATION = presents(
    "response_prediction",
    Presentation("Predicted responses", summary, failures, figures, tables, answer="predicted peaks", histories=histories),
)


def decay_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Predicted frequency and damping, and the measured decays against what is predicted of them."""
    found = {"predicted decay": decay_table(dataset)}
    return found | ({"measured against predicted": decay_comparison_table(dataset)} if "decay" in dataset.sizes else {})


def decay_figures(dataset: xr.Dataset) -> Figures:
    """Frequency and damping with their bands."""
    return {"predicted_decay": predicted_decay}


DECAY_PRESENTATION = presents(
    "decay_prediction",
    Presentation(
        "Predicted decay",
        decay_summary,
        decay_failures,
        decay_figures,
        decay_tables,
        answer="predicted decay",
        histories=whole_tables,
    ),
)
