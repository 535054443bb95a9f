"""Mapping from the contact rows of a problem to labelled arrays, by contact and direction t1, t2, n."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import DIRECTION_NAMES
from stickslip.model.problem import Problem


class ContactRows:
    """contact, direction (rows,): the places of each row."""

    def __init__(self, problem: Problem) -> None:
        contacts = enumerate(problem.contacts)
        pairs = [(c, DIRECTION_NAMES.index(name)) for c, contact in contacts for name in contact.direction_names]
        self.contact, self.direction = np.array(pairs, dtype=int).reshape(len(pairs), 2).T
        self.contacts = len(problem.contacts)

    def spread(self, values: NDArray[Any], axis: int = 0) -> NDArray[Any]:
        """Values (..., rows, ...), rows along an axis, as (..., contact, direction, ...), NaN where a contact has no such
        direction."""
        before, after = values.shape[:axis], values.shape[axis + 1 :]
        found = np.full((*before, self.contacts, len(DIRECTION_NAMES), *after), np.nan)
        found[(slice(None),) * axis + (self.contact, self.direction)] = values
        return found

    def summed(self, values: NDArray[Any]) -> NDArray[Any]:
        """Sums over the rows of each contact of values (points, rows): (points, contacts)."""
        found = np.zeros((len(values), self.contacts))
        np.add.at(found.T, self.contact, values.T)
        return found

    def collected(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values (contact, direction, ...) as (rows, ...)."""
        return np.asarray(values[self.contact, self.direction])
