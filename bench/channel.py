"""Requests and answers between the benchmark and a code under test, which runs in a process and an environment of its own.

One JSON object a line each way. The process that measures stays warm between requests, so that two codes can be timed in turn.
"""

from __future__ import annotations

import json
import os
import resource
import selectors
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

Answer = dict[str, Any]
Handler = Callable[[dict[str, Any]], Answer]

BAD_END = "the process ended"
WALL_LIMIT = 3600.0
"""Seconds to wait for an answer on a crowded machine; the sides bound their own CPU time."""


def serve(handlers: Mapping[str, Handler], greeting: Answer) -> None:
    """Answer requests from standard input until it closes. What the handlers print goes to standard error."""
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    print(json.dumps(greeting), file=out, flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = handlers[request.pop("do")](request)
        except Exception as reason:  # a benchmark reports the failure of a code and goes on
            answer = {"failed": f"{type(reason).__name__}: {reason}"[:400]}
        answer["peak_memory_MiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        print(json.dumps(answer), file=out, flush=True)


class Side:
    """One code under test: a process that is started when first asked."""

    def __init__(self, name: str, command: Sequence[str], environment: Mapping[str, str], folder: str) -> None:
        self.name, self.command, self.environment, self.folder = name, list(command), dict(environment), folder
        self.process: subprocess.Popen[str] | None = None
        self.greeting: Answer = {}

    def start(self) -> Answer:
        """Start the process afresh and return its greeting: import time and versions."""
        self.close()
        self.process = subprocess.Popen(
            self.command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | self.environment,
            cwd=self.folder,
            text=True,
            bufsize=1,
        )
        self.greeting = self._read(WALL_LIMIT)
        return self.greeting

    def ask(self, do: str, limit: float = WALL_LIMIT, **request: Any) -> Answer:
        """The answer to a request; {"failed": why} where there is none within `limit` seconds of wall time."""
        if self.process is None:
            self.start()
        assert self.process is not None
        assert self.process.stdin is not None
        try:
            print(json.dumps({"do": do, **request}), file=self.process.stdin, flush=True)
        except BrokenPipeError:
            self.close()
            return {"failed": BAD_END}
        return self._read(limit)

    def _read(self, limit: float) -> Answer:
        assert self.process is not None
        assert self.process.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(self.process.stdout, selectors.EVENT_READ)
            began = time.monotonic()
            ready = selector.select(limit)
        line = self.process.stdout.readline() if ready else ""
        if line:
            return json.loads(line)
        self.close()
        return {"failed": BAD_END if ready else f"no answer within {limit:.0f} s", "waited": time.monotonic() - began}

    def close(self) -> None:
        """End the process that this side started."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None
