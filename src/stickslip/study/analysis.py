"""Interface of analyses in study files: each states how its tables become a `Plan`, on which reading and running rely.

The tables and the plan of an analysis stand together in `study/analyses/`. An analysis has in `[study] analysis` the name of its
module there, whose `KIND` describes it.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import MappingProxyType
from typing import Annotated, Any, Literal, Protocol

from pydantic import Field

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem.meshed import promised
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.runs.cases import Arrays, Checkpoint, Progress, Work, Workers
from stickslip.solve.balance.fourier import checked_harmonics, in_words
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.study import analyses
from stickslip.study.fields import AnyTable, Table, Units
from stickslip.support.checks import counted
from stickslip.support.late import xr
from stickslip.support.units import Band


class Plan(Protocol):
    """A study made ready to be computed."""

    @property
    def summary(self) -> str:
        """What will be computed, in half a line."""

    @property
    def works(self) -> Mapping[str, Work]:
        """What is to be computed, in independent cases, by a name for each kind of work; "" for the only one."""

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> "xr.Dataset":
        """The labelled results of all works."""

    def searched(
        self, results: Mapping[str, Sequence[Arrays]], checkpoint: Checkpoint, workers: Workers, progress: Progress
    ) -> "xr.Dataset":
        """The same of an analysis that goes on from its cases by a search, whose own cases are kept as well."""
        return self.dataset(results)

    def begin(self, progress: Progress) -> None:
        """Compute what all cases share and only a run needs, before the first of them."""

    @property
    def content(self) -> str:
        """Identifies the content of the files that its tables name; "" where they name none."""
        return ""

    @property
    def reads(self) -> tuple[Path, ...]:
        """The files of results that it reads, which its own must not replace."""
        return ()

    @property
    def condition(self) -> str:
        """When the structure of the study is as it is given: "at 6000 rev/min"; "" where that does not change."""
        return ""


@dataclass(frozen=True, eq=False)
class Works:
    """The plan of most analyses: one work, whose results are those of the study, or several by name.

    work: as it is, or what makes it when it is asked for, where that reads files or takes long. gathered: the dataset of work and
    arrays of its cases, both by name where there are several works, unless that is `work.gathered(arrays).dataset`. search: the
    same where the analysis goes on from its cases by a search, from work, arrays, checkpoint, workers and progress. on_mesh: the
    work once more where only a run finds out how contacts deform its model.
    """

    work: Work | Mapping[str, Work] | Callable[[], Work | Mapping[str, Work]]
    summary: str
    gathered: "Callable[[Any, Any], xr.Dataset]" = lambda work, arrays: work.gathered(arrays).dataset
    content: str = ""
    condition: str = ""
    reads: tuple[Path, ...] = ()
    search: "Callable[..., xr.Dataset] | None" = None
    on_mesh: Callable[[Progress], Work | Mapping[str, Work]] | None = None

    def begin(self, progress: Progress) -> None:
        """Of a finite-element model with many contacts, the work on the coordinates that they need."""
        if self.on_mesh is not None:
            self.__dict__["works"] = _by_name(self.on_mesh(progress))

    @cached_property
    def works(self) -> Mapping[str, Work]:
        return _by_name(self.work() if callable(self.work) else self.work)

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> "xr.Dataset":
        return self.gathered(*((self.works[""], results[""]) if len(self.works) == 1 else (self.works, results)))

    def searched(
        self, results: Mapping[str, Sequence[Arrays]], checkpoint: Checkpoint, workers: Workers, progress: Progress
    ) -> "xr.Dataset":
        if self.search is None:
            return self.dataset(results)
        return self.search(self.works[""], results[""], checkpoint, workers, progress)


def _by_name(made: Work | Mapping[str, Work]) -> Mapping[str, Work]:
    return made if isinstance(made, Mapping) else {"": made}


def content_of(files: Iterable[Path]) -> str:
    """Identifies the content of files, as far as they exist."""
    return sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()


def summary_of(sweep: ForcedResponseSettings, with_levels: bool = True) -> str:
    """A problem with where and how finely to compute it, in half a line."""
    problem = sweep.problem
    where = f"at {counted(len(sweep.frequencies), 'frequency', 'frequencies')}" if sweep.listed else "over a band"
    size = counted(problem.freedoms, "degree of freedom", "degrees of freedom")
    harmonics = 'harmonics = "auto"' if isinstance(sweep.harmonics, str) else in_words(checked_harmonics(sweep.harmonics))
    levels = f"{counted(len(sweep.levels), 'force level')} " if with_levels else ""
    of = "" if sweep.measured == DISPLACEMENT_AMPLITUDE else f", peaks of the {sweep.measured.words}"
    contacts = counted(len(problem.contacts), "contact")
    orders = f"{problem.orders_in_words}, " if isinstance(problem, TunedDisk) else ""
    samples = problem.systems.enough_samples(sweep.samples)
    return f"{size}, {contacts}, {orders}{levels}{where}, {harmonics}, {samples} samples{of}"


@dataclass(frozen=True, eq=False)
class Asked:
    """What a sound study file holds: its own tables by key, the problem and the settings of [sweep] where the analysis has one,
    units, and its folder; rig: the name of the ready problem, "" without one, and its parameters; disks: of a sector whose
    speed is given, the structure by rotor speed in rev/min; document: the file as it stands."""

    tables: Mapping[str, Table]
    sweep: ForcedResponseSettings | None
    units: Units
    folder: Path
    rig: tuple[str, Mapping[str, Any]] = ("", MappingProxyType({}))
    disks: Mapping[float, CyclicStructure] = field(default_factory=dict)
    document: Mapping[str, Any] = field(default_factory=dict)

    def table(self, kind: type[AnyTable]) -> AnyTable | None:
        """The table of a kind; None where the file has none."""
        return next((table for table in self.tables.values() if isinstance(table, kind)), None)


def taken_over(base: ForcedResponseWork) -> dict[str, Any]:
    """The settings that other analyses take over from a forced response; a run finds the shapes that a mesh lacks before it."""
    return {"problem": promised(base.problem), "harmonics": base.harmonics, "samples": base.samples, **base.measure.attributes}


@dataclass(frozen=True)
class Kind:
    """An analysis of study files.

    plan: what the file asks for, made ready; it raises the faults it sees.
    tables: the tables that only this analysis has, by key, and `optional`: those of them that may be left out.
    on_problem: whether the file states a problem with a sweep; an analysis without one has only its own tables.
    repeats: whether the frequencies of `at` may come back to where they were, upwards and downwards.
    band: of the excitation, from the tables of its own, where these say where to compute and [sweep] only how finely.
    whole_disk: whether it solves more of a disk than one sector under its engine orders.
    from_mesh: whether large models with many contacts are reduced by these, without a kept row.
    without: keys of [sweep] that have no effect on it; check_of_sweep: what it asks of [sweep] beyond the table's own rules.
    """

    plan: Callable[[Asked], Plan]
    tables: Mapping[str, type[Table]] = field(default_factory=dict)
    optional: Collection[str] = ()
    on_problem: bool = True
    repeats: bool = False
    band: Callable[[Mapping[str, Table]], Band | None] | None = None
    without: tuple[str, ...] = ()
    check_of_sweep: Callable[[Any], object] | None = None
    whole_disk: bool = False
    from_mesh: bool = False


PEAKS = ("tolerance", "peak_tolerance", "quantity", "measure")
"""Keys of [sweep] without effect where no peaks of curves are sought."""
LEVELS_AND_PEAKS = ("force_levels", *PEAKS)
"""The same where there are no force levels either."""

NAMES = tuple(module.name for module in iter_modules(analyses.__path__))


class _Kinds(Mapping[str, Kind]):
    """The kinds by name. Each module is imported when its kind is first asked for: all take as long as a small study."""

    def __getitem__(self, name: str) -> Kind:
        if name not in NAMES:
            raise KeyError(name)
        kind: Kind = import_module(f"{analyses.__name__}.{name}").KIND
        return kind

    def __iter__(self) -> Iterator[str]:
        return iter(NAMES)

    def __len__(self) -> int:
        return len(NAMES)


KINDS = _Kinds()


class StudyTable(Table):
    """What the study is."""

    title: Annotated[str, Field(description="title of results and report")] = ""
    analysis: Annotated[Literal[NAMES], Field(description="what to compute")]  # type: ignore[valid-type]


PROBLEM_KEYS = (
    "structure",
    "body",
    "rotation",
    "load_step",
    "damping",
    "contact",
    "force",
    "excitation",
    "mean_spring",
    "dashpot",
    "base",
    "aerodynamics",
    "sweep",
)
"""Tables that state a problem and where to compute it, for every analysis of one."""
COMMON_KEYS = ("units", "study", *PROBLEM_KEYS)


def keys_of(kind: Kind) -> tuple[str, ...]:
    """The keys that a study file of a kind may have."""
    return ("units", "study", *PROBLEM_KEYS * kind.on_problem, *kind.tables)


def owners(key: str) -> list[str]:
    """The analyses that a table belongs to."""
    return [name for name, kind in KINDS.items() if key in keys_of(kind)]


def all_keys() -> tuple[str, ...]:
    """Every key of study files."""
    return (*COMMON_KEYS, *dict.fromkeys(key for kind in KINDS.values() for key in kind.tables))
