"""Executor for cases on a Dask cluster (optional: pip install "stickslip[dask]").

The scheduler keeps how to make the work and each case, so a worker that is lost costs what it was computing: others do that
again. Results are fetched as they come; what is fetched is kept here and needs no worker any more.
"""

import logging
import re
from asyncio import CancelledError
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib import import_module, util
from pathlib import Path
from time import sleep
from typing import Any

import stickslip
from stickslip.runs.cases import Arrays, Keep, Progress, Work
from stickslip.support.checks import InputError, fault
from stickslip.support.machine import one_blas_thread

PACKAGE = "distributed"
ADDRESS = re.compile(r"(\w+://)?\S+:\d+")
PATIENCE = 5.0
"""Seconds in which a scheduler must answer, and at first a result must come."""
POLL = 0.1
"""Seconds between two looks for workers and results while there are none."""


def installed() -> bool:
    """Whether the package is there."""
    return util.find_spec(PACKAGE) is not None


@dataclass(frozen=True)
class DaskCluster:
    """The workers of a Dask scheduler at an address such as "tcp://10.0.0.1:8786". They must run the same version of stickslip,
    compared by the content of its source files.

    Everybody who reaches a scheduler can run programs on its workers: keep it in a trusted network, or use "tls://".

    >>> import stickslip as ss
    >>> cluster = ss.DaskCluster("tcp://127.0.0.1:8786")                                  # doctest: +SKIP
    >>> ss.forced_response(ss.rigs.single_mass(), ss.hertz(0.1, 0.3), [1, 2], workers=cluster)  # doctest: +SKIP
    """

    address: str

    def __post_init__(self) -> None:
        if not (ADDRESS.fullmatch(str(self.address))):
            raise fault("The address of a Dask scheduler", 'must read as "tcp://HOST:PORT" does', self.address)

    def workers(self) -> int:
        """How many workers there are now; refused when the scheduler does not answer."""
        with self._client() as client:
            return _count(client)

    def compute(self, work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
        """As of an `Executor`. With no worker yet, waits for the first."""
        if not cases:
            return
        with self._client() as client:
            _wait_for_workers(client, self.address, progress)
            made = client.submit(_as_it_is, work, pure=False)
            prepared = client.submit(_prepare, made, own_version(), pure=False)
            ready = client.submit(_is_ready, prepared, pure=False)
            preparing = "preparing (the first run on a machine compiles the kernels)"
            for _ in self._as_they_come(client, {ready: "the preparation"}, lambda: progress(0.0, preparing)):
                pass
            futures = {client.submit(_solve, prepared, case, own_version(), pure=False): case for case in cases}
            done = 0

            def report() -> None:
                progress(done / len(cases), f"{done} of {len(cases)} done, {_count(client)} workers of {self.address}")

            for future, arrays in self._as_they_come(client, {future: work.words[futures[future]] for future in futures}, report):
                keep(futures[future], arrays)
                done += 1
                report()

    def _as_they_come(self, client: Any, words: Mapping[Any, str], report: Callable[[], None]) -> Iterator[tuple[Any, Arrays]]:
        """Futures with their results, as they are done. With no worker left, waits for one.

        A result whose worker has gone with it is computed again; nothing else waits for that.
        """
        order, patience = import_module(PACKAGE).as_completed(list(words), loop=client.loop), PATIENCE
        while not order.is_empty():
            ready = order.next_batch(block=False)
            if client.status != "running":
                raise self._gone()
            if not ready:
                report()
                sleep(POLL)
            for future in ready:
                try:
                    arrays = self._result(future, words[future], patience)
                except TimeoutError:
                    if future.status == "error":
                        raise
                    order.add(future)
                    patience *= 2.0
                    continue
                yield future, arrays
                future.release()

    @contextmanager
    def _client(self) -> Iterator[Any]:
        """A connection, closed at the end, which ends what is not finished."""
        if not installed():
            raise fault("A Dask cluster", "must have its package", "not installed", 'Get it: pip install "stickslip[dask]".')
        try:
            client = import_module(PACKAGE).Client(self.address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            rule = f"must be that of a Dask scheduler that answers within {PATIENCE:g} s"
            remedy = f"Start one by `dask scheduler` and give the address it prints. ({error})"
            raise fault("The address", rule, self.address, remedy) from None
        with _quiet(), client:
            try:
                yield client
            except _losses():
                raise self._gone() from None

    def _gone(self) -> ConnectionError:
        """What a run ends with when its connection to the scheduler breaks: that has forgotten what it was asked for."""
        return ConnectionError(f"the scheduler at {self.address} has gone; start it and its workers again.")

    def _result(self, future: Any, words: str, patience: float) -> Arrays:
        """What a worker found; failures that only a cluster has are explained."""
        try:
            return future.result(timeout=patience)  # type: ignore[no-any-return]
        except import_module(PACKAGE).KilledWorker:
            raise InputError(
                f"Workers must survive a case, but {words} ended every one that tried it. Give each more memory."
            ) from None
        except ImportError as error:
            raise fault("Every worker", "must have stickslip and its packages", str(error)) from None


def _losses() -> tuple[type[BaseException], ...]:
    """What Dask raises when the connection to the scheduler breaks, by what it was doing then."""
    return (
        CancelledError,
        import_module(f"{PACKAGE}.client").FutureCancelledError,
        import_module(f"{PACKAGE}.comm").CommClosedError,
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask writes a traceback about each lost connection, which ends here in one sentence."""
    loggers = [logging.getLogger(name) for name in (PACKAGE, f"{PACKAGE}.client")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)


def _count(client: Any) -> int:
    try:
        return len(client.scheduler_info(n_workers=-1)["workers"])
    except OSError as error:
        raise import_module(f"{PACKAGE}.comm").CommClosedError(str(error)) from error


def _wait_for_workers(client: Any, address: str, progress: Progress) -> None:
    while not _count(client):
        progress(0.0, f"waiting for workers of {address}")
        try:
            client.wait_for_workers(1, timeout=POLL)
        except TimeoutError:
            continue


def _as_it_is(work: Work) -> Work:
    """On a worker: the work itself, which the others then fetch; the scheduler can have it made again."""
    return work


def _prepare(work: Work, version: str) -> Work:
    """On one worker: the work with all that is done once, whose kernels workers of the same files then load."""
    _same_version(version)
    work.prepare()
    return work


def _is_ready(work: Work) -> Arrays:
    """On a worker: says that the work is prepared, which stays there."""
    return {}


def _solve(work: Work, case: int, version: str) -> Arrays:
    """On a worker: one case, by the version that asks for it."""
    _same_version(version)
    with one_blas_thread():
        return work.solve(case, _untold)


@cache
def own_version() -> str:
    """The version of stickslip and a digest of its source files, so that two states of a clone differ."""
    package = Path(stickslip.__file__).parent
    digest = sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(f"{path.relative_to(package).as_posix()}\n".encode())
        digest.update(path.read_bytes().replace(b"\r\n", b"\n"))
    return f"{stickslip.__version__} ({digest.hexdigest()[:12]})"


def _same_version(version: str) -> None:
    if version != own_version():
        remedy = "Install the same files here and on all workers; the digest in brackets is that of the source files."
        raise fault("stickslip on all workers", f"must be version {version}", own_version(), remedy)


def _untold(fraction: float) -> None:
    """Workers report completed cases, not the progress within one."""
