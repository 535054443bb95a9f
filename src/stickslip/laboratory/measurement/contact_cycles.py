"""Whole cycles of the records of one contact, as harmonics, with an account of what was removed on the way.

A cycle runs from one upward passage of the displacement through its middle to the next. Each is smoothed by harmonics, since
noise of the displacement looks like motion: unsmoothed it makes kt too low and friction too high.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import compress, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.laboratory.measurement.contact_record import ContactRecord
from stickslip.laboratory.measurement.cycles import analysis, columns_at, delayed, fitted_cycle, synthesis
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import Array, Index, between, counted, fault, first_of, rounded

HARMONICS = (30, 60, 120, 240)
"""To which cycles are smoothed: the first that leaves nothing but noise of the displacement. Thirty round off the corners of a
triangle or trapezoid, which moves mu of such a test by 0.7 %."""

STRUCTURE = 3.0
"""Power of the displacement between H and 2H harmonics over that of white noise from which H is too few."""

SAMPLES_A_HARMONIC = 6
"""Fewer samples of a cycle for each harmonic follow the noise."""

FEWEST = 5
"""Harmonics that a loop needs at least."""

UNLIKE = 0.2
"""Relative difference from the median period or load of the record from which a cycle is dropped."""

FEWEST_SAMPLES = 20
"""Of one cycle: fewer do not show where it sticks."""

NOISE = 3.0
"""A harmonic of the mean displacement is noise below so many standard errors: noise exceeds them once in eight thousand. With
2.2 one of thirty harmonics stayed in every fourth record and moved kt by 1 %."""

IRREGULAR = 0.02
"""Part of a period by which passages may differ from equal steps that are tried in their place."""

GAP = 1.0 / 60.0
"""Part of the period that may be missing."""

MOST_LOOKED_AT = 20
"""Cycles from which the number of harmonics is chosen."""

SEEN = 0.02
"""Drift relative to the range from which it is stated."""


OPEN = 0.25
"""Difference of the force at the end of a cycle from that at its beginning, relative to the range, from which its loop is open:
the first stroke of a virgin contact leaves one half, wear and noise a few hundredths."""

TIMES_USUAL = 3.0
"""How many times the usual difference that is, too: of loops that are all open none is left out."""

AT_END, FEWEST_ON_LINE = 0.05, 4
"""Share of a cycle, and least number of samples of a line, from which the force at its beginning or end is found."""

TURN = 0.2
"""Part of the displacement's range by which it must turn back for a reversal: smaller motions are noise, or are dropped."""

CLOSED = 0.1
"""Largest distance of the last sample of a single cycle from its first, relative to the range of the displacement."""

FEW_CYCLES = 3
"""Up to so many whole cycles, strokes that the record begins or ends with are used if they pass the middle at all."""

WHOLE_STROKE = 0.9
"""Part of a stroke that the record must begin or end with for its passage to count: a virgin contact may begin there."""

ABOUT = 0.2
"""Part of a stroke on either side of its middle through which a line gives the passage."""


QUIET = 8.0
"""Standard deviations of noise that a reversal must exceed: where noise is larger, neighbouring samples are averaged first."""

LONGEST_MEAN = 101
"""Samples that are averaged at most."""


@dataclass(frozen=True, eq=False)
class ContactCycles:
    """Whole cycles of one contact as harmonics a0, a1, b1, ... of equal phases: displacement [m], force [N] and normal load [N],
    (cycles, 2H+1) each; error (H,) [m]: standard deviation by noise of the displacement's cosines and sines in one cycle, 0 of
    harmonics that are left out as noise; numbers (cycles,) of the cycles in the test; period [s], NaN without time; noise of
    one sample of displacement [m] and force [N], root mean square of what the harmonics leave; removed and notes: sentences."""

    displacement: Array
    force: Array
    normal: Array
    error: Array
    numbers: Index
    period: float
    noise: tuple[float, float]
    removed: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def harmonics(self) -> int:
        """The highest harmonic H."""
        return int(self.displacement.shape[1] - 1) // 2

    @property
    def amplitude(self) -> Array:
        """Half the range of the displacement in each cycle, (cycles,) [m]."""
        return np.asarray(0.5 * np.ptp(self.displacement @ synthesis(8 * self.harmonics, self.harmonics).T, axis=1))

    @property
    def energy(self) -> Array:
        """Energy dissipated in each cycle, (cycles,) [J]: the area of its loop, π Σ k (a_F b_u − b_F a_u)."""
        return cycle_work(self.force, self.displacement)

    @property
    def summary(self) -> str:
        """What there is, in half a line: "49 cycles of 4 s, amplitude 114 um, normal load 5 N"."""
        period = "" if np.isnan(self.period) else f" of {self.period:.4g} s"
        size, load = _range(1e6 * self.amplitude), _range(self.normal[:, 0])
        return f"{counted(len(self.force), 'cycle')}{period}, amplitude {size} um, normal load {load} N"


def _range(values: Array) -> str:
    """The median of values that are about the same, else their range."""
    if values.max() < 1.05 * values.min():
        return f"{np.median(values):.4g}"
    return f"{values.min():.4g} to {values.max():.4g}"


@dataclass(frozen=True, eq=False)
class _Cut:
    """The cycles of one record: harmonics (3, 2H+1) of displacement, force and load of each, its number and period, what the
    harmonics leave of displacement and force, its force at beginning and end, cycles dropped, samples outside of cycles, and the
    drift of displacement and force over the record, which is removed."""

    cycles: list[Array]
    numbers: list[int]
    periods: list[float]
    residuals: list[Array]
    ends: list[tuple[float, float]]
    dropped: int
    outside: int
    drift: Array


def contact_cycles(records: ContactRecord | Sequence[ContactRecord], harmonics: int | None = None) -> ContactCycles:
    """The whole cycles of one or several records, each smoothed to its first harmonics: 30, 60, 120 or 240, as the displacement
    needs, unless given, and at most as its samples allow.

    Removed: samples outside whole cycles, cycles whose period or normal load differs by more than 20 % from the median of their
    record (pauses, loading), cycles whose loop is open by more than a quarter of the range of the force while others close (a
    virgin contact's first stroke), the mean of displacement and force in each cycle, their drift over a record, and the sign of
    the force where it would make the contact give energy. `removed` and `notes` say how much of each.
    """
    several = [records] if isinstance(records, ContactRecord) else list(records)
    if not several:
        raise fault("records", "must be at least one", 0)
    if harmonics is not None:
        between("harmonics", harmonics, 5, 2000)
    spans = [_regular(record, cycle_ends(record)) for record in several]
    shortest = min(int(np.floor(np.min(np.diff(span)))) for span in spans)
    if shortest < FEWEST_SAMPLES:
        raise fault(
            f"Cycles of {several[0].name}",
            f"must have at least {FEWEST_SAMPLES} samples",
            shortest,
            "Sample faster, or with less noise.",
        )
    notes = [*_repeated(several), *(note for record in several for note in record.notes)]
    most = (shortest - 3) // 2
    if harmonics is not None and harmonics > most:
        notes.append(f"Cycles of {shortest} samples are smoothed to {most} harmonics, not {harmonics}.")
    enough = partial(_left, several[0], spans[0])
    count = min(most, harmonics or _enough(enough, float(np.min(np.diff(spans[0]))), most))
    numbered = zip(several, spans, _first_numbers(several, spans), strict=True)
    cuts, open_loops = _closed([_cut(record, span, count, number) for record, span, number in numbered])
    notes += open_loops
    found = np.array([cycle for cut in cuts for cycle in cut.cycles])
    removed = _counted(several, cuts) + _drifts(cuts)
    u, force, normal = found[:, 0].copy(), found[:, 1].copy(), found[:, 2]
    removed += _offsets(u, force)
    u[:, 0] = force[:, 0] = 0.0
    if _turned(u, force):
        force *= -1.0
        removed.append("The sign of the force is turned, so that friction dissipates.")
    residuals = np.concatenate([one for cut in cuts for one in cut.residuals], axis=1)
    noise = np.sqrt(np.mean(residuals**2, axis=1))
    error = float(noise[0]) * np.sqrt(2.0 * len(u) / residuals.shape[1])
    lost = _lost(u, error / np.sqrt(len(u)))
    u[:, 1::2][:, lost] = u[:, 2::2][:, lost] = 0.0
    removed.append(
        f"Smoothed to {count} harmonics, which takes {_small(noise[0], 'm')} and {_small(noise[1], 'N')} rms as noise."
    )
    periods = [period for cut in cuts for period in cut.periods]
    numbers = np.array([number for cut in cuts for number in cut.numbers], dtype=np.int64)
    untimed = any(record.time is None for record in several)
    period = float("nan") if untimed else float(np.mean(periods))
    own = (float(noise[0]), float(noise[1]))
    return ContactCycles(
        u, force, normal, np.where(lost, 0.0, error), numbers, period, own, tuple(removed), tuple(dict.fromkeys(notes))
    )


def _first_numbers(records: Sequence[ContactRecord], spans: Sequence[Array]) -> list[int]:
    """The number of the first cycle of each record."""
    found, alone, following = [], all(span.size == 2 for span in spans), 1
    for record, span in zip(records, spans, strict=True):
        own = record.file_number if record.number is None and alone else record.number
        found.append(following if own is None else own)
        following = found[-1] + span.size - 1
    return found


def _repeated(records: Sequence[ContactRecord]) -> list[str]:
    """Records that hold the same samples, such as a file that was named twice."""
    content = [record.displacement.tobytes() + record.force.tobytes() for record in records]
    twins = [(records[content.index(one)], records[k]) for k, one in enumerate(content) if content.index(one) < k]
    return [f"{first.name} and {other.name} hold the same samples, which count twice: leave one out." for first, other in twins]


def smoothed_motion(displacement: Array, harmonics: int | None = None) -> tuple[Array, Array]:
    """A closed cycle of displacement (n,) by its first harmonics, as many as it needs unless given, without those that are noise;
    and the standard errors (H,) of their cosines and sines [m]."""
    size = displacement.size
    power = np.abs(np.fft.rfft(displacement - displacement.mean())) ** 2 * 2.0 / size**2
    enough = _enough(lambda count: float(np.sum(power[count + 1 :])), size, (size - 3) // 3)
    count = enough if harmonics is None else min(harmonics, (size - 3) // 2)
    error = np.sqrt(2.0 * float(np.sum(power[count + 1 :])) / (size - 2 * count - 1))
    found = analysis(displacement, count)
    lost = _lost(found[None], error)
    found[1::2][lost] = found[2::2][lost] = 0.0
    return synthesis(size, count) @ found, np.where(lost, 0.0, error)


def _regular(record: ContactRecord, span: Array) -> Array:
    """The ends of cycles in equal steps, where these leave less of the displacement than the passages as they were found, each
    of which noise shifts."""
    shortest = float(np.min(np.diff(span)))
    if span.size <= FEW_CYCLES or shortest < FEWEST_SAMPLES:
        return span
    number = np.arange(span.size)
    line = np.asarray(np.polyval(np.polyfit(number, span, 1), number))
    line = np.clip(line, 0.0, record.displacement.size - 1.0)
    if np.max(np.abs(line - span)) > IRREGULAR * shortest:
        return span
    count = min(HARMONICS[0], int(min(shortest, float(np.min(np.diff(line)))) - 3) // 2)
    return line if _left(record, line, count) <= _left(record, span, count) else span


def _enough(left: Callable[[int], float], samples: float, most: int) -> int:
    """The first number of `HARMONICS` beyond which a displacement has nothing but noise; of few samples first so many that noise
    does not follow. left: sum of squares that so many harmonics leave."""
    few = int(samples / SAMPLES_A_HARMONIC)
    allowed = [count for count in HARMONICS if count <= few] or [*([few] if FEWEST <= few < most else []), most]
    for count, more in pairwise(allowed):
        still = left(more)
        if left(count) - still <= STRUCTURE * still * 2.0 * (more - count) / max(samples - 2.0 * more - 1.0, 1.0):
            return count
    return allowed[-1]


def _left(record: ContactRecord, span: Array, harmonics: int) -> float:
    """Sum of squares of the displacement that so many harmonics leave of the cycles of a record [m²]."""
    return float(sum(np.sum(one[0] ** 2) for one in _cut(record, span[: MOST_LOOKED_AT + 1], harmonics).residuals))


def _cut(record: ContactRecord, span: Array, harmonics: int, number: int = 1) -> _Cut:
    """The cycles of a record, of which the first has a number, without those that differ in period or load from the others."""
    places = np.arange(record.displacement.size, dtype=float)
    clock = places if record.time is None else record.time
    ends = np.interp(span, places, clock) if span[-1] <= places[-1] else span
    if span[-1] > places[-1] and record.time is not None:  # a single closed cycle: one more step
        ends = np.array([clock[0], clock[-1] + float(np.median(np.diff(clock)))])
    normal = np.broadcast_to(np.asarray(record.normal, dtype=float), places.shape)
    signals = np.stack([record.displacement, record.force, normal])
    periods = np.diff(ends)
    parts = [np.arange(a, b) for a, b in pairwise(np.searchsorted(clock, ends))]
    loads = np.array([normal[part].mean() for part in parts])
    steps = np.array([float(np.max(np.diff(clock[part]), initial=0.0)) for part in parts])
    sound = np.abs(periods / np.median(periods) - 1.0) < UNLIKE
    sound &= np.abs(loads / np.median(loads) - 1.0) < UNLIKE
    sound &= np.array([part.size >= 2 * harmonics + 3 for part in parts])
    sound &= steps <= np.maximum(GAP * periods, 3.0 * float(np.median(np.diff(clock))))
    if not np.any(sound):
        raise fault(record.name, "must hold at least one whole cycle without gaps", 0, "Record more cycles.")
    kept = np.flatnonzero(sound)
    drift = _drift(signals[:2], clock, [parts[k] for k in kept])
    signals = signals - np.vstack([drift[:, None] * (clock - clock[0]), np.zeros_like(clock)])
    cycles, residuals, forces = [], [], []
    for k in kept:
        phase = (clock[parts[k]] - ends[k]) / periods[k]
        values = signals[:, parts[k]]
        found = fitted_cycle(phase, values, harmonics)
        forces.append(_at_ends(phase, values[1]))
        residuals.append((values - found @ columns_at(phase, harmonics).T)[:2])
        cycles.append(found)
    first = cycles[0][0]
    if len(periods) == 1 or np.sum(first[2::2] * np.arange(1, harmonics + 1)) < 0.0:  # not an upward passage at its beginning
        cycles = [_from_middle(cycle) for cycle in cycles]
    numbers = [number + int(k) for k in np.flatnonzero(sound)]
    outside = places.size - int(sum(part.size for part in parts))
    span_of_drift = drift * (clock[parts[kept[-1]][-1]] - clock[parts[kept[0]][0]])
    return _Cut(cycles, numbers, list(periods[sound]), residuals, forces, int(np.count_nonzero(~sound)), outside, span_of_drift)


def _at_ends(phase: Array, force: Array) -> tuple[float, float]:
    """The force at the beginning and at the end of a cycle, by straight lines through the samples beside them."""
    count = max(round(AT_END * force.size), FEWEST_ON_LINE)
    begin, end = (
        np.polyfit(phase[part] - at, force[part], 1)[1] for part, at in ((slice(count), 0.0), (slice(-count, None), 1.0))
    )
    return float(begin), float(end)


def _closed(cuts: Sequence[_Cut]) -> tuple[list[_Cut], list[str]]:
    """The cuts without cycles whose loop is open while others close, and a sentence on those that are left out."""
    apart = np.array([abs(end - begin) for cut in cuts for begin, end in cut.ends])
    span = float(np.median([np.ptp(_shape(cycle[1])) for cut in cuts for cycle in cut.cycles]))
    usual = float(np.sort(apart)[(apart.size - 1) // 2])
    most = max(OPEN * span, TIMES_USUAL * usual)
    if np.all(apart <= most):
        return list(cuts), []
    kept, left = [], []
    for cut in cuts:
        closes = [abs(end - begin) <= most for begin, end in cut.ends]
        left += [
            f"cycle {number} ({rounded(begin, 3)} N at its beginning, {rounded(end, 3)} N at its end)"
            for number, (begin, end), whole in zip(cut.numbers, cut.ends, closes, strict=True)
            if not whole
        ]
        if any(closes):
            each = ("cycles", "numbers", "periods", "residuals", "ends")
            parts: dict[str, Any] = {key: list(compress(getattr(cut, key), closes)) for key in each}
            kept.append(replace(cut, **parts))
    why = "its force does not close" if len(left) == 1 else "their force does not close"
    return kept, [f"Left out: {first_of(left)}; {why}, as in the first stroke of a virgin contact."]


def _drift(signals: Array, clock: Array, parts: list[Index]) -> Array:
    """Slopes over time (signals,) of the means of the cycles; zero for fewer than three."""
    if len(parts) < 3:
        return np.zeros(len(signals))
    times = np.array([clock[part].mean() for part in parts])
    return np.array([np.polyfit(times - times[0], [signal[part].mean() for part in parts], 1)[0] for signal in signals])


def _from_middle(cycle: Array) -> Array:
    """A cycle (signals, 2H+1) that begins where its displacement, the first signal, passes its middle upwards."""
    harmonics = (cycle.shape[1] - 1) // 2
    u = synthesis(16 * harmonics, harmonics) @ cycle[0]
    u = u - 0.5 * (u.max() + u.min())
    lowest = int(np.argmin(u))
    passed = (lowest + int(np.argmax(np.roll(u, -lowest) >= 0.0))) % u.size
    return delayed(cycle, -2.0 * np.pi * passed / u.size)


def _counted(records: Sequence[ContactRecord], cuts: Sequence[_Cut]) -> list[str]:
    """How much lies outside whole cycles, and how many cycles were dropped."""
    found, samples = [], sum(record.displacement.size for record in records)
    outside, dropped = sum(cut.outside for cut in cuts), sum(cut.dropped for cut in cuts)
    if outside:
        found.append(f"{outside} of {samples} samples lie outside whole cycles.")
    if dropped:
        whole = dropped + sum(len(cut.cycles) for cut in cuts)
        found.append(f"{dropped} of {whole} cycles are dropped: pauses, gaps, or another load than the others.")
    return found


def _drifts(cuts: Sequence[_Cut]) -> list[str]:
    """The drift of each signal that is worth stating."""
    found = []
    for signal, name, factor, unit in ((0, "displacement", 1e6, "um"), (1, "force", 1.0, "N")):
        largest = max((cut.drift[signal] for cut in cuts), key=abs)
        ranges = [float(np.ptp(_shape(cycle[signal]))) for cut in cuts for cycle in cut.cycles]
        if abs(largest) > SEEN * float(np.median(ranges)):
            found.append(f"Drift of the {name} removed: {factor * largest:.3g} {unit} over the record.")
    return found


def _shape(harmonics: Array) -> Array:
    count = (harmonics.size - 1) // 2
    return np.asarray(synthesis(4 * count, count) @ harmonics)


def _offsets(u: Array, force: Array) -> list[str]:
    """The mean values that are removed of displacement and force."""
    place = float(np.median(u[:, 0]))
    found = [f"Mean displacement removed: {f'{1e3 * place:.4g} mm' if abs(place) > 1e-3 else f'{1e6 * place:.4g} um'}."]
    mean, half = float(np.median(force[:, 0])), 0.5 * float(np.ptp(_shape(force.mean(axis=0))))
    found.append(f"Mean force removed: {rounded(mean, 3)} N, {abs(mean) / half:.1%} of half its range.")
    return found


def _lost(u: Array, error: float) -> NDArray[np.bool_]:
    """Which harmonics of the mean displacement do not stand out of the standard error [m] of their cosines and sines.

    As motion of the contact they would make it softer than it is.
    """
    mean = u.mean(axis=0)
    return np.asarray(mean[1::2] ** 2 + mean[2::2] ** 2 <= 2.0 * NOISE**2 * error**2)


def _small(value: float, unit: str) -> str:
    """A small quantity with a prefix."""
    for size, prefix in ((1.0, ""), (1e-3, "m"), (1e-6, "u")):
        if value >= size:
            return f"{value / size:.3g} {prefix}{unit}"
    return f"{value / 1e-9:.3g} n{unit}"


def _turned(u: Array, force: Array) -> bool:
    """Whether the force has the sign with which friction gives energy; in loops without area, with which it falls."""
    area = float(np.sum(cycle_work(force, u)))
    size = float(np.sum(np.ptp(u @ synthesis(120, (u.shape[1] - 1) // 2).T, axis=1) * np.sqrt(np.sum(force**2, axis=1))))
    return area < 0.0 if abs(area) > 0.02 * size else float(np.sum(u * force)) < 0.0


def cycle_ends(record: ContactRecord) -> Array:
    """Where cycles begin and end, (cycles + 1,) in samples: upward passages through the middle between two reversals, or
    downward ones where these give more cycles; a single closed cycle begins with its first sample and ends where that
    would come again."""
    u = _quiet(record.displacement)
    turns = reversals(u, TURN * float(np.ptp(u)))
    for part, fewest in ((WHOLE_STROKE, FEW_CYCLES), (0.0, 1)):
        passages = max((_passages(sign * u, turns, part) for sign in (1.0, -1.0)), key=len)
        if len(passages) > fewest:
            return np.array(passages)
    apart = abs(u[-1] - u[0])
    if 1 <= len(turns) <= 2 and apart <= CLOSED * np.ptp(u):
        same = abs(record.force[-1] - record.force[0]) < 0.01 * np.ptp(record.force)
        repeated = same and apart < 0.1 * np.median(np.abs(np.diff(u)))
        return np.array([0.0, float(u.size - 1 if repeated else u.size)])
    if not turns:
        shown = f"rising or falling throughout, from {u[0]:.4g} m to {u[-1]:.4g} m"
        remedy = "Is it the right column? A cycle needs motion in both directions."
        raise fault(f"Displacement of {record.name}", "must reverse", shown, remedy)
    shown = f"{counted(len(turns), 'reversal')}, ends {apart / np.ptp(u):.0%} of the range apart"
    raise fault(record.name, "must hold at least one whole cycle", shown, "Record more cycles, or cut one out that is closed.")


def _quiet(u: Array) -> Array:
    """A displacement (n,) as mean over so many neighbours that noise alone makes no reversal; unchanged where it is low.

    Third differences show the noise: those of white noise are √20 times as large, those of a finely sampled motion vanish.
    """
    noise = float(np.median(np.abs(np.diff(u, 3)))) / (0.6745 * np.sqrt(20.0))
    width = 1
    mean = u
    while TURN * float(np.ptp(mean)) < QUIET * noise / np.sqrt(width) and width < min(LONGEST_MEAN, u.size // 8):
        width += 2
        mean = np.convolve(np.pad(u, width // 2, mode="edge"), np.full(width, 1.0 / width), mode="valid")
    return mean


def reversals(values: Array, least: float) -> list[int]:
    """Places of the highest and lowest samples between which a signal turns back by at least `least`, in turn.

    The first and the last sample are none, nor is noise near them: a signal must come to a reversal from `least` away.
    """
    found: list[int] = []
    high = low = 0
    rising = 0
    for n in range(values.size):
        if values[n] > values[high]:
            high = n
        if values[n] < values[low]:
            low = n
        if rising >= 0 and values[high] - values[n] >= least:
            if rising or values[high] - values[0] >= least:
                found.append(high)
            rising, low = -1, n
        elif rising <= 0 and values[n] - values[low] >= least:
            if rising or values[0] - values[low] >= least:
                found.append(low)
            rising, high = 1, n
    return found


def _passages(u: Array, turns: list[int], part: float) -> list[float]:
    """Where the displacement passes upwards through the middle between two reversals, in samples.

    part: of a stroke that must lie before the first reversal, or after the last one, for the passage there to count.
    """
    if len(turns) < 2:
        return []
    strokes = [(a, b, 0.5 * (u[a] + u[b]), 0.0) for a, b in pairwise(turns)]
    ends = [(0, turns[0], 0), (turns[-1], u.size - 1, -1)]
    first, last = ((a, b, strokes[k][2], part * abs(u[turns[k]] - u[turns[1 if k == 0 else -2]])) for a, b, k in ends)
    return [
        _passage(u, a, b, middle)
        for a, b, middle, least in (first, *strokes, last)
        if u[a] < middle <= u[b] and u[b] - u[a] >= least
    ]


def _passage(u: Array, start: int, end: int, middle: float) -> float:
    """Where the displacement passes a value upwards between two samples, in samples: by a straight line through the samples about
    it, since noise would shift a single sample."""
    part = u[start : end + 1]
    n = int(np.argmax(part >= middle))
    half = ABOUT * float(part.max() - part.min())
    below, above = np.flatnonzero(part[:n] < middle - half), np.flatnonzero(part[n:] > middle + half)
    first, last = (int(below[-1]) + 1 if below.size else 0), (n + int(above[0]) if above.size else part.size)
    if last - first < FEWEST_ON_LINE:
        return start + n - 1 + float((middle - part[n - 1]) / (part[n] - part[n - 1]))
    places = np.arange(first, last) - n
    slope, value = np.polyfit(places, part[first:last] - middle, 1)
    found = -value / slope if slope > 0.0 else 0.0
    return start + n + float(np.clip(found, places[0], places[-1]))
