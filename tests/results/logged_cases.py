"""Work whose cases write down who began and ended them, for tests of executors. Workers import it too."""

import os
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np


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

    def solve(self, case, tell):
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
class Deadly(LoggedCases):
    """Case 1 ends the process that computes it."""

    def solve(self, case, tell):
        if case == 1:
            os._exit(1)
        return super().solve(case, tell)
