"""Processor time of each test, that of its child processes included: what takes more than five seconds is slow or nightly.

Every run names the tests above the limit that are not; with `--cpu-limit SECONDS` they fail, and the slowest ones are listed.
Wall time would blame the tests that ran while the machine was busy. Compiling kernels happens once on a machine, in whichever
test comes first, and is not counted, but where a child process compiles; nor is a child that nobody has waited for.
"""

import os
import signal

import pytest
from numba.core import event

# In the background of a script Ctrl-C is ignored, also by the processes that tests start and end by it.
signal.signal(signal.SIGINT, signal.default_int_handler)

LIMIT = 5.0
LISTED = 30
MEASURED = "cpu_seconds"


def processor_time():
    return sum(os.times()[:4])  # user and system, own and children


class Compiling(event.Listener):
    """Seconds of this process spent in compiling; a kernel compiles those that it calls."""

    def __init__(self):
        self.total, self.depth, self.began = 0.0, 0, 0.0

    def on_start(self, what):
        self.depth += 1
        if self.depth == 1:
            self.began = processor_time()

    def on_end(self, what):
        self.depth -= 1
        if self.depth == 0:
            self.total += processor_time() - self.began


COMPILING = Compiling()
event.register("numba:compile", COMPILING)


@pytest.fixture
def unsaved_figures(monkeypatch):
    """Figures of a run are drawn, but not written to files, which takes most of the time of a small run."""
    monkeypatch.setattr("stickslip.show.plots.paper.write_figure", lambda figure, path, suffix: None)


def pytest_addoption(parser):
    parser.addoption(
        "--cpu-limit", type=float, metavar="SECONDS", help="fail tests that take more and are neither slow nor nightly"
    )


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    item.began = processor_time() - COMPILING.total
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if call.when == "call" and not (item.get_closest_marker("slow") or item.get_closest_marker("nightly")):
        seconds = processor_time() - COMPILING.total - item.began
        report.user_properties.append((MEASURED, seconds))
        limit = item.config.getoption("--cpu-limit")
        if report.passed and limit and seconds > limit:
            report.outcome = "failed"
            report.longrepr = f"{seconds:.1f} s of processor time: more than {limit:g} s, so make it cheaper or mark it."
    return report


def pytest_terminal_summary(terminalreporter):
    """The tests above the limit; with `--cpu-limit` the slowest ones and the sum."""
    reports = [report for each in ("passed", "failed") for report in terminalreporter.getreports(each)]
    found = [(dict(report.user_properties).get(MEASURED), report.nodeid) for report in reports if report.when == "call"]
    times = sorted((pair for pair in found if pair[0] is not None), reverse=True)
    limit = terminalreporter.config.getoption("--cpu-limit")
    shown = times[:LISTED] if limit else [pair for pair in times if pair[0] > LIMIT]
    if not shown:
        return
    terminalreporter.section(
        "processor time" if limit else f"more than {LIMIT:g} s of processor time, but neither slow nor nightly"
    )
    for seconds, name in shown:
        terminalreporter.write_line(f"{seconds:8.1f} s  {name}")
    if limit:
        terminalreporter.write_line(
            f"{sum(seconds for seconds, _ in times):8.1f} s  in all {len(times)} tests neither slow nor nightly"
        )
