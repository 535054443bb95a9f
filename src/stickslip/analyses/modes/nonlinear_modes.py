"""Nonlinear modes: natural frequency and damping of a structure with friction over the amplitude of its vibration."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.forced_response import ForcedResponse
from stickslip.analyses.modes.characteristic import with_solved
from stickslip.analyses.modes.dataset import with_phase_at
from stickslip.analyses.modes.limit_cycles import LimitCycles, limit_cycles_of
from stickslip.analyses.modes.synthesis import ForcePattern, Synthesis
from stickslip.analyses.modes.work import NonlinearModesWork, with_decays
from stickslip.analyses.settings import output_of, takes
from stickslip.model.contact.point import TractionRatio
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.support.checks import between, fault, of_kind, positive, vector
from stickslip.support.late import pd, xr

SAME_RESONANCE = 0.1
"""Relative distance in frequency within which a peak of a response is that of the mode."""


@dataclass(frozen=True, eq=False, repr=False)
class NonlinearModes(Result):
    """Curves of one or several modes: `dataset` with axes (case, point, ...), a case per mode, and the problem that made them."""

    dataset: xr.Dataset
    problem: Problem

    def peaks(self, force_levels: ArrayLike, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """Resonance peaks of all force levels from one mode: force_level, frequency [Hz], amplitude [m] of an output,
        modal_amplitude [m kg^0.5], damping_ratio, other_modes, phase [rad], solved_frequency and solved_amplitude; a row a peak,
        where a level has several the highest first. other_modes: their linear response relative to the motion of the mode, with
        which a peak may be wrong. solved_...: of the forced motion solved at the peak, NaN where that fails.

        forces: the harmonic forces whose pattern excites the mode, those of the problem unless given. Besides the mode the
        other modes of the stuck structure respond linearly. Raises `InputError` for a level beyond the amplitudes of the curve.
        """
        row = output_of(self.problem, output)
        table = self._synthesis(case, forces).peaks(vector("force_levels", force_levels), row)
        loaded = self.problem if forces is None else self.problem.with_forces(tuple(forces))
        return with_solved(table, self.dataset, loaded, case, row)

    def response(self, force_level: float, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """The forced response around the resonance of one force level from one mode: frequency [Hz], amplitude [m] and phase
        [rad] of an output, modal_amplitude [m kg^0.5], and `mode_alone`, the amplitude without the linear response of the other
        modes; in the order of travel, over the peak and through folds."""
        return self._synthesis(case, forces).response(positive("force_level", force_level), output_of(self.problem, output))

    def phase_resonance(self, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """Phase resonance, the force in quadrature with the motion, at every point of a curve: force_level, frequency [Hz],
        amplitude [m] of an output, damping_ratio."""
        return self._synthesis(case, forces).phase_resonance(output_of(self.problem, output))

    def against(self, response: ForcedResponse, case: int = 0) -> pd.DataFrame:
        """Peaks from a mode beside those of a forced response of the same problem: force_level, output, `swept` and `from_mode`
        [m], `difference`, relative to the swept one, and the frequencies of both [Hz]. Of the peaks of the response that nearest
        to the mode's counts; NaN where none is within 10 % of its frequency, as on a curve that was lost or in another band."""
        peaks = of_kind("response", response, ForcedResponse).peaks("displacement", "amplitude")
        rows = []
        for level in response.dataset["force_level"].values.tolist():
            for number, name in enumerate(self.problem.output_names):
                mode = self.peaks([level], case, number)
                own = peaks[(peaks["force_level"] == level) & (peaks["output"] == name)]
                away = (own["frequency"] / float(mode["frequency"][0]) - 1.0).abs()
                near = own.loc[away.idxmin()] if away.min() < SAME_RESONANCE else {"amplitude": np.nan, "frequency": np.nan}
                ends = float(near["amplitude"]), float(mode["amplitude"][0])
                rows.append((level, name, *ends, ends[1] / ends[0] - 1.0, float(near["frequency"]), float(mode["frequency"][0])))
        columns = ["force_level", "output", "swept", "from_mode", "difference", "swept_frequency", "mode_frequency"]
        return pd.DataFrame(rows, columns=columns)

    def with_decays(self) -> NonlinearModes:
        """A copy whose dataset also says how free decays along these modes fall: `swing` [m] (case, point, output), half the
        distance between the turning points, `decay_damping_ratio` (case, point, output), NaN where there is none, and
        `decay_message` (case,), where a decay is not one of the mode. `with_modes` of a decay asks for it. The modes are followed
        again, and the phases are those of their own coordinates."""
        if "decay_damping_ratio" in self.dataset:
            return self
        return replace(self, dataset=with_decays(self.dataset, self.problem))

    def limit_cycles(self, aerodynamic_damping: ArrayLike = 0.0) -> LimitCycles:
        """Limit cycles of these modes, amplitudes A with ζ(A) + aerodynamic_damping = 0; arguments as for `ss.limit_cycles`."""
        return limit_cycles_of(self.dataset, self.problem, aerodynamic_damping)

    def _synthesis(self, case: int, forces: ForcePattern | None) -> Synthesis:
        return Synthesis.of(self.dataset, self.problem, between("case", case, 0, self.dataset.sizes["case"] - 1), forces)


@takes(NonlinearModesWork)
def nonlinear_modes(work: NonlinearModesWork) -> NonlinearModes:
    """Natural frequency ω and damping ratio ζ of a mode over its amplitude, from stuck contacts to full slip.

    The periodic motions of M q̈ + (C − 2ζωM) q̇ + K q + Bᵀ f(Bq) = static loads: where the damping of friction and dashpots takes
    as much from the motion as −2ζωM gives, the motion neither grows nor decays. ω is the frequency and ζ the damping ratio with
    which the structure vibrates freely at that amplitude, positive where the motion decays by exp(−ζωt).

    mode: number of the stuck mode to follow, 1 the lowest, or several; or by frequency: the stuck mode nearest to it, Hz; or
    largest_at_output: the stuck mode with the largest share in the static compliance of the output. The first unless given.
    amplitude: largest amplitude, or (lowest, largest), as the amplitude [m] that `output` has in the stuck mode's shape; unless
    given from half to 1000 times the amplitude at which the first contact slips. harmonics, samples: as for `forced_response`.
    extended: "first" puts −2ζωM into the equation of the first harmonic alone, "all" into those of all harmonics. The two differ
    where damping is high: with "all" the negative damping acts on the other modes too, which higher harmonics then excite.
    phase_at: number of the output whose first harmonic is real and positive, at all amplitudes; unless given it is the
    coordinate of the followed stuck mode. Start states are those of the contacts; a traction ratio counts from the
    instant of the largest modal coordinate.
    workers, checkpoint, progress: as for `forced_response`, a case a mode.

    Source: M. Krack, Nonlinear modal analysis of nonconservative systems: extension of the periodic motion concept, Computers
    and Structures 154 (2015).
    """
    work.refuse_amplitudes()
    turned = None if work.phase_at is None else output_of(work.problem, work.phase_at, "phase_at")
    # A traction ratio holds at an instant of the period, so that the phase of a motion matters.
    ratios = any(start.code == TractionRatio.code for contact in work.problem.contacts for start in contact.starts)
    if turned is not None and ratios:
        remedy = "Leave phase_at out, or start from slider offsets."
        raise fault("phase_at", "must not be given with traction ratios, which hold at an instant of the period", turned, remedy)
    dataset = work.dataset(all_cases(work, work.checkpoint, work.workers, work.progress))
    return NonlinearModes(dataset if turned is None else with_phase_at(dataset, turned), work.problem)
