"""Outcomes of a solution point, each with its message."""

from enum import IntEnum


class Outcome(IntEnum):
    """Outcome of one solution point; `sentence` says it to the user."""

    EMPTY = 0
    CONVERGED = 1
    NOT_CONVERGED = 2
    NO_STATIC_EQUILIBRIUM = 3
    BODY_HELD_BY_NOTHING = 4
    MOST_STARTS_UNSOLVED = 5
    NO_PEAK = 6
    STATIC_NOT_FOUND = 7
    STOPPED = 8

    @property
    def sentence(self) -> str:
        return _SENTENCES[self]


_SENTENCES = {
    Outcome.EMPTY: "No point was computed here.",
    Outcome.CONVERGED: "Converged.",
    Outcome.NOT_CONVERGED: (
        "Newton's method did not converge. Begin the band where contacts stick or hardly move, or take more samples."
    ),
    Outcome.NO_STATIC_EQUILIBRIUM: (
        "With the prescribed start state no static equilibrium was found: the static friction forces that it fixes may be "
        "unable to balance the static load. Use slider offsets, or other ratios."
    ),
    Outcome.BODY_HELD_BY_NOTHING: (
        "A body is held by nothing in its mean position (harmonic 0): only friction of fixed size acts on it in some "
        "direction. Add a spring to ground, or use slider offsets as start states."
    ),
    Outcome.MOST_STARTS_UNSOLVED: (
        "Most start states have no solution, so no bounds can be given. Use another rule, or one for each "
        'tangential direction: ratios in the plane of a damper, "virgin" or slider offsets along its axis.'
    ),
    Outcome.STATIC_NOT_FOUND: (
        "Newton's method found no equilibrium under the static loads alone, though there may be one. Check static loads, "
        "preloads and gaps, and what holds each body; softer contacts help."
    ),
    Outcome.STOPPED: "The run was stopped before this was computed.",
    Outcome.NO_PEAK: "No peak was found: the response is largest at an end of the band, or the curve broke off.",
}
