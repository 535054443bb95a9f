"""The page of the documentation on robustness, from what a run found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from string import Template
from typing import Any, Self

from robustness.one_slider import HighestResult
from robustness.resonances import Tally

TEXT = Template("""\
# Robustness

`make robustness` traces seeded random problems across their bands, 250 of each class, and meets ill-posed ones, which
must be recognised as such. A problem has 1 to 6 degrees of freedom, 1 to 4 contacts with random directions, modal
damping between 0.3 and 5 %, a band from below the first free to beyond the last stuck resonance, and a force level
between 0.05 and 10; 5 harmonics, 256 samples. Traced means: from one end of the band to the other, whatever folds and
kinks lie on the way, every point with its residual below the tolerance of Newton's method. This page is written by
`make robustness`.

| class | laws | traced | CPU time each |
| --- | --- | --- | --- |
$rows

$when. The time of the first class holds that of compiling or loading the kernels.

$failures

## Every resonance

Traced is not enough: a step can pass over a lightly damped resonance with both its ends right. Chains of 2 to 6 masses with 1
to 3 sliders, some with one more that always sticks, and steel cantilevers with one, wide and narrow bands, upwards and
downwards, one or several outputs, are compared with independent answers: where all contacts stick with the exact peaks of the
linear structure; where they slip (1.1 to 100 times the force at which the first contact slips) with solutions at listed
frequencies, 40 to each half-width ζω around every computed resonance, every one with a set of contacts stuck, and their fractions
1/h. A peak counts if it has at least 1e-3 of the highest and rises by 0.2 % out of the curve; it must be found, and right to
1e-3 of its height (not below the listed ones by more, where contacts slip).

| structure | damping ratio | cases | peaks, stuck | missing | wrong height | peaks, slipping | missing | wrong height |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
$resonances

$wrong

## The highest response of a band

One slider on 1 to 40 modes, closely spaced ones among them, stiffness, limit and force over many decades, solved with one
harmonic and 1024 samples. The closed form of that is solved at the resonances which every amplitude of the slider makes, and
beside them. The highest response of a curve that arrives must be that of the closed form to 0.2 %. Without any damping a
response may grow without bound, or its peak be narrower than the spacing of floating-point numbers; such a curve ends and
says so.

| damping ratio | cases | arrived | highest response right |
| --- | --- | --- | --- |
$highest

$wrong_highest

## What was not traced, and why

Of six problems that an earlier version did not trace (156 and 224 of the varying load, 211 of lift-off, 40, 198 and 207 of the
start states) three causes were found. A step over a kink was believed although it led back to where the curve came from. A
sharp fold was taken for a crossing of branches; now a crossing counts only if the curve goes on straight behind it. And in a
cascade of folds a step may go from one branch to the next, parallel one, and now and then back: such a curve closes on itself.
That is recognised (Brent's test). A curve that is lost is traced again with reversible steps: a step counts only if the step
back leads to where it came from, within 3 % of its length. Such steps stay on their branch where others jump. They are not the
rule, because they cost a second solution each and follow the whole cascade of a sampled contact, thousands of points. Every
point is a solution either way.

Barely pressed contacts that are stiffer than what they join lift off and close within a few samples of each other. While normal
forces were summed over samples, curves folded at every such sample: of numbers 0 to 149 of the class 8 were lost. Integrated over
the openings of contacts, which came after the table above, 1 is lost (number 36).

Number 207 of the start states remains: what Newton's method finds at and before the start of its band is a branch that comes
back from 0.41 rad/s. From 1.1 and 1.3 rad/s, inside the band, the end is reached.

The ill-posed problems are bodies held by nothing, or by a friction that a prescribed traction ratio or mean takes
away; matrices that are no masses or stiffnesses; numbers that are none; loads, outputs, starts and laws that do not
fit. Each must be refused with a sentence that names the fault, or end with the outcome "body held by nothing", and
never be answered: $ill_posed.

The problems stand in `robustness/problems.py` and `robustness/ill_posed.py`: number n of a class is the same on every
machine, and a failure is printed with its number and its cause.
""")
LAWS = {
    "constant load": "macroslip and microslip arrays of constant normal load",
    "varying load": "macroslip, microslip arrays with gaps; preload 10 to 30",
    "lift-off": "the same with preload 0 to 2, and gaps",
    "start state": "those of all classes, sliders away from zero",
    "barely pressed": "gaps, macroslip and microslip of 0.1 to 30 times the median stiffness, preload 0 to 0.3",
    "barely pressed, start state": "the same, sliders away from zero",
}


@dataclass
class ClassResult:
    """What came of one class: how many problems, CPU seconds each, and the numbers that failed by their cause."""

    kind: str
    count: int
    seconds: float = 0.0
    failed: Mapping[str, Sequence[int]] = field(default_factory=dict)

    @property
    def traced(self) -> int:
        return self.count - sum(len(numbers) for numbers in self.failed.values())

    @property
    def causes(self) -> list[str]:
        """Failures grouped by cause, the most frequent first."""
        ordered = sorted(self.failed.items(), key=lambda item: -len(item[1]))
        return [f"{len(numbers)} of {self.kind}: {cause} (numbers {', '.join(map(str, numbers))})" for cause, numbers in ordered]


@dataclass
class ResonanceResult:
    """What sweeps found of the peaks of one kind of structure with one damping ratio."""

    kind: str
    ratio: float
    stuck: Tally
    slipping: Tally

    @classmethod
    def restored(cls, stored: Mapping[str, Any]) -> Self:
        """From the dictionary that `dataclasses.asdict` makes of it."""
        return cls(stored["kind"], stored["ratio"], Tally(**stored["stuck"]), Tally(**stored["slipping"]))

    @property
    def row(self) -> str:
        """A row of the table."""
        cells = [self.kind, f"{self.ratio:g}", self.stuck.cases]
        for tally in (self.stuck, self.slipping):
            cells += [tally.peaks, tally.missing, tally.low]
        return f"| {' | '.join(map(str, cells))} |"


def page(
    results: Sequence[ClassResult],
    resonances: Sequence[ResonanceResult],
    highest: Sequence[HighestResult],
    ill_posed: str,
    when: str,
) -> str:
    """The whole page."""
    rows = [
        f"| {r.kind} | {LAWS[r.kind]} | {r.traced} of {r.count} ({100.0 * r.traced / r.count:.1f} %) | {r.seconds:.2f} s |"
        for r in results
    ]
    causes = [f"* {cause}" for result in results for cause in result.causes]
    failures = "\n".join(["Not traced, by cause:", "", *causes]) if causes else "No problem failed."
    wrong = [f"* {cause}" for result in resonances for tally in (result.stuck, result.slipping) for cause in tally.wrong]
    other = [f"* {cause}" for result in highest for cause in result.wrong]
    found = {
        "highest": "\n".join(result.row for result in highest),
        "wrong_highest": "\n".join(["Curves with another highest response:", "", *other])
        if other
        else "All curves that arrived are right.",
        "resonances": "\n".join(result.row for result in resonances),
        "wrong": "\n".join(["Cases with a peak missing or wrong:", "", *wrong]) if wrong else "No peak is missing or wrong.",
    }
    return TEXT.substitute(found, rows="\n".join(rows), when=when, failures=failures, ill_posed=ill_posed)
