"""Work whose cases write down who began and ended them, for tests of executors. Workers import it too."""

import os
import signal
import time
from dataclasses import dataclass
from multiprocessing import active_children
from pathlib import Path
from threading import Timer

import numpy as np

from stickslip.runs.cases import CaseStopped
from stickslip.support.checks import Faults


@dataclass(frozen=True)
class LoggedCases:
    """Cases 0, 1, ... that last `seconds` each and give their square."""

    log: str
    count: int
    seconds: float

    @property
    def names(self):
        return [f"case {k}" for k in range(self.count)]

    @property
    def words(self):
        return self.names

    def prepare(self):
        pass

    def solve(self, case, report):
        self._write("began", case)
        time.sleep(self.seconds)
        self._write("ended", case)
        return {"square": np.array(case**2)}

    def _write(self, what, case):
        with Path(self.log).open("a") as file:
            file.write(f"{what} {case} {os.getpid()}\n")

    def lines(self, what):
        """(case, process) of all that began or ended, in order."""
        text = Path(self.log).read_text() if Path(self.log).exists() else ""
        lines = [line.split() for line in text.splitlines()]
        return [(int(case), int(process)) for kind, case, process in lines if kind == what]


@dataclass(frozen=True)
class SlowToPrepare(LoggedCases):
    """Begins case 0 before it is asked for, and is never prepared."""

    def prepare(self):
        self._write("began", 0)
        time.sleep(60.0)


@dataclass(frozen=True)
class Unprepared(LoggedCases):
    """Writes down the processes that run when it is prepared, and is then refused."""

    def prepare(self):
        for number, process in enumerate(active_children()):
            with Path(self.log).open("a") as file:
                file.write(f"beside {number} {process.pid}\n")
        raise Faults(["no compiler", "no cache"])


@dataclass(frozen=True)
class SlowToArrive(LoggedCases):
    """Takes a minute to come to another process."""

    def __reduce__(self):
        return _arrived_after_a_minute, (self.log, self.count, self.seconds)


def _arrived_after_a_minute(*arguments):
    time.sleep(60.0)
    return SlowToArrive(*arguments)


@dataclass(frozen=True)
class Deadly(LoggedCases):
    """Case 1 ends the process that computes it."""

    def solve(self, case, report):
        if case == 1:
            os._exit(1)
        return super().solve(case, report)


@dataclass(frozen=True)
class KilledWhileItAnswers(LoggedCases):
    """Another process than `home` is killed so many seconds after it began to send its first result of 16 MB."""

    home: int

    def solve(self, case, report):
        first = self._first_elsewhere()
        self._write("began", case)
        if os.getpid() == self.home:
            while self._first_elsewhere():
                time.sleep(0.01)
        elif first:
            Timer(self.seconds, os.kill, (os.getpid(), signal.SIGKILL)).start()
        return {"large": np.full(2_000_000, float(case))}

    def _first_elsewhere(self):
        return all(process == self.home for _, process in self.lines("began"))


@dataclass(frozen=True)
class Broken(LoggedCases):
    """A case lasts a minute in the process `home` and is refused in others."""

    home: int

    def solve(self, case, report):
        if os.getpid() != self.home:
            raise Faults(["a", "b"])
        for _ in range(6000):
            time.sleep(0.01)
        return super().solve(case, report)


@dataclass(frozen=True)
class Stoppable(LoggedCases):
    """Cases of many short steps, which give the steps done where they are stopped."""

    def solve(self, case, report):
        self._write("began", case)
        done = 0
        try:
            while done < 1000:
                time.sleep(0.01)
                done += 1
        except KeyboardInterrupt as stop:
            raise CaseStopped({"done": np.array(done)}) from stop
        return {"done": np.array(done)}


@dataclass(frozen=True)
class KillsWhatStarts(LoggedCases):
    """Kills the processes that have been started before any of them can begin."""

    def prepare(self):
        for child in active_children():
            child.kill()
