"""Presentation of predicted decays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from stickslip.laboratory.identification.response.decay_prediction_result import (
    comparison_table,
    decay_table,
    failures,
    summary,
    whole_tables,
)
from stickslip.show.plots.files import Figures
from stickslip.show.plots.identification import predicted_decay
from stickslip.show.report.presentation import Presentation, presents

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Predicted frequency and damping, and the measured decays against what is predicted of them."""
    found = {"predicted decay": decay_table(dataset)}
    return found | ({"measured against predicted": comparison_table(dataset)} if "decay" in dataset.sizes else {})


def figures(dataset: xr.Dataset) -> Figures:
    """Frequency and damping with their bands."""
    return {"predicted_decay": predicted_decay}


PRESENTATION = presents(
    "decay_prediction",
    Presentation("Predicted decay", summary, failures, figures, tables, answer="predicted decay", histories=whole_tables),
)
