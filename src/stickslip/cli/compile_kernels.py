"""The command `compile`: all kernels ahead of their first use, for images and clusters.

A kernel is compiled for the types of its first call. The smallest cases of each analysis make these calls.
"""

from collections.abc import Callable
from dataclasses import dataclass
from inspect import isabstract
from typing import TYPE_CHECKING, Any

import typer

from stickslip.cli.app import guarded
from stickslip.support.console import progress_bar, progress_is_seen, say

if TYPE_CHECKING:
    from stickslip.model.contact.law import Law
    from stickslip.model.problem import Problem
    from stickslip.runs.cases import Arrays, Report


@guarded
def compile_kernels(ctx: typer.Context) -> None:
    """Compile all numerical kernels for this processor now, instead of each at its first use, and keep them on disk. This takes
    a few minutes on two cores."""
    import time

    began = time.monotonic()
    compile_all()
    say(f"All kernels are compiled, in {time.monotonic() - began:.0f} s.")


def compile_all(workers: int = 2) -> None:
    """Run the smallest cases of each analysis, in two processes: more of them would compile the same kernels.

    Both are others than this one, which thus answers Ctrl-C and SIGTERM at once instead of when a kernel is compiled.
    """
    from stickslip.runs.cases import Processes

    work, logged, done = Compilation(), not progress_is_seen(), list[int]()
    with progress_bar("Compiling") as report:

        def keep(case: int, _: "Arrays") -> None:
            done.append(case)
            if logged:
                say(f"Compiled {len(done)} of {len(work.names)}: {work.names[case]}.")

        Processes(workers, apart=True).compute(work, range(len(work.names)), keep, report)


@dataclass(frozen=True)
class Compilation:
    """The smallest cases as work for several processes."""

    @property
    def names(self) -> list[str]:
        return list(small_cases())

    words = names

    def prepare(self) -> None:
        """The processes prepare themselves."""

    def solve(self, case: int, report: "Report") -> "Arrays":
        """Run a case, with kernels for this processor, also where the package brought others."""
        from stickslip.support.kernels import cache

        cache.OWN_ONLY = True
        list(small_cases().values())[case]()
        return {}


def small_cases() -> dict[str, Callable[[], Any]]:
    """The analyses by name, each with a problem of a few rows; the steps of laws compile first, as all analyses call some.

    The longest comes next. What follows shares few kernels with it, and what has many of them comes when it is done.
    """
    import numpy as np

    import stickslip as ss
    from stickslip.laboratory.identification.contact_law.fit import ContactLoop, law_force
    from stickslip.model.contact.march import prepare
    from stickslip.model.dampers import in_phase
    from stickslip.model.rigs import laboratory_damper, single_mass
    from stickslip.solve.balance import mode_iteration, newton_matrix
    from stickslip.solve.platforms.relaxation import elements_of, relaxed_cycle
    from stickslip.support.kernels import compiled

    on_states = newton_matrix.factorised_on_states, newton_matrix.solve_on_states
    on_coordinates = mode_iteration.factorised_on_coordinates, mode_iteration.solve_on_coordinates
    mass, damper, motion = single_mass(), laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)), in_phase(30e-6)
    band, laws, loop = ss.Band(0.15, 0.25), mass_with_laws(), np.sin(np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False))
    return {
        "steps of laws": lambda: prepare(*every_law()),
        "forced response": lambda: ss.forced_response(mass, band, 1.0, harmonics=3, samples=64).at([0.16]),
        "damper cycle": lambda: ss.damper_cycle(damper, motion, steps=64),
        "damper cycle in time": lambda: ss.damper_cycle(damper, motion, steps=64, method=ss.Newmark(), frequency=50.0),
        "identification": lambda: relaxed_cycle(elements_of(damper), 50.0, motion.samples(64)),
        "contact law": lambda: law_force(ContactLoop(1e-6 * loop, 10.0 * loop, 50.0), ss.Dahl(1e7, 0.5, normal_load=1.0)),
        "time": lambda: ss.time_response(laws, 0.17, steps_per_period=100, harmonics=3, periods=3),
        "nonlinear mode": lambda: ss.nonlinear_modes(mass, 1, (0.1, 3.0), harmonics=3, samples=64),
        "stability": lambda: ss.forced_response(laws, band, 1.0, harmonics=3, samples=64).with_stability(),
        "many contacts": lambda: compiled(*on_states, *on_coordinates),
        "branch points": lambda: transposed_system(mass),
        "mistuned wheel": lambda: answered(mass),
        "sensitivity": lambda: ss.sensitivity(mass, 0.17, {}, harmonics=3, samples=64),
        "controlled response": lambda: ss.controlled_response(mass, band, 0.5, harmonics=3, samples=64),
        "bounds": lambda: ss.response_bounds(mass, [0.17], 1.0, points=2, cloud=4, starts=1, harmonics=3, samples=64),
    }


def transposed_system(problem: "Problem") -> None:
    """Solve Newton's linear system with its transpose, as the search of branch points does."""
    import numpy as np

    from stickslip.solve.balance.balance import HarmonicBalance, Point
    from stickslip.solve.continuation.sensitivity import solved_factors

    balance = HarmonicBalance(problem, 3, 64)
    forces = np.zeros((balance.rows, balance.columns))
    factors = solved_factors(balance, balance.evaluate(Point(forces, 1.0, 10.0)))
    factors.solve_transposed(np.ones((1, factors.bordered.offsets[-1] + 1)))


def answered(problem: "Problem") -> None:
    """What contacts answer to a motion, as balances in Python ask them."""
    import numpy as np

    from stickslip.solve.balance.balance import HarmonicBalance
    from stickslip.solve.balance.contact_forces import contact_answer

    balance = HarmonicBalance(problem, 3, 64)
    contact_answer(balance.table, balance.tables, np.zeros((balance.rows, balance.columns)), 1.0)


def every_law() -> "list[type[Law]]":
    """The laws that study files know."""
    from stickslip.model.contact.law import Law
    from stickslip.study import contacts

    members = [each for each in vars(contacts).values() if isinstance(each, type) and issubclass(each, Law)]
    return [each for each in members if not isabstract(each)]


def mass_with_laws() -> "Problem":
    """A mass in space on springs to ground, with contacts of laws of each kind: coupled, with a period of its own or not, by the
    velocity, and without friction."""
    import numpy as np

    import stickslip as ss

    structure = ss.Structure(np.eye(3), np.diag([1.0, 1.2, 2.0]), ("1.x", "1.y", "1.z"), C=0.02 * np.eye(3))
    along, across, closing = {"1.x": 1.0}, {"1.y": 1.0}, {"1.z": 1.0}
    contacts = (
        ss.Contact("disc", ss.FrictionDisc(kt=1.0, mu=0.5, kn=1.0, preload=0.5), (along, across), closing),
        ss.Contact("dahl", ss.Dahl(kt=0.5, mu=0.5, normal_load=0.2), (along,)),
        ss.Contact("valanis", ss.Valanis(kt=0.5, mu=0.5, kappa=0.5, normal_load=0.2), (along,)),
        ss.Contact("tanh", ss.TanhCoulomb(mu=0.5, v0=1.0, normal_load=0.2), (across,)),
        ss.Contact("cubic", ss.CubicSpring(0.1), (along,)),
    )
    return ss.Problem(structure, contacts, (ss.Force("1.x", 0.5), ss.Force("1.z", 0.2)), ("1.x",), "A mass with all laws")
