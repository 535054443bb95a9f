"""What a user sees while kernels are compiled: a bar on a terminal, in that of a command if there is one; else one sentence."""

import io

import pytest
from rich.console import Console
from rich.progress import Progress

from stickslip.support import compilation
from stickslip.support.compilation import SENTENCE, TITLE, CompilationNotice


@pytest.fixture
def notice():
    return CompilationNotice()


def test_a_file_gets_one_sentence_for_all_kernels(notice, caplog):
    for _ in range(3):
        notice.begin()
        notice.begin()  # a kernel that the first one calls
        notice.end()
        notice.end()
    assert [record.message for record in caplog.records] == [SENTENCE]


def test_a_file_gets_a_line_every_half_minute(notice, monkeypatch, caplog):
    clock = iter([0.0, 29.0, 31.0, 62.0])
    monkeypatch.setattr("time.monotonic", lambda: next(clock))
    for _ in range(3):
        notice.begin()
        notice.end()
    assert [record.message for record in caplog.records] == [
        SENTENCE, "2 kernels compiled after 31 s.", "3 kernels compiled after 62 s."
    ]  # fmt: skip


def test_a_terminal_gets_a_bar_as_long_as_a_kernel_is_compiled(notice, monkeypatch, caplog):
    monkeypatch.setattr(compilation, "_bar_is_seen", lambda: True)
    notice.begin()
    notice.begin()
    bar = notice._bar
    assert bar is not None
    assert bar.live.is_started
    notice.end()
    assert bar.tasks[0].completed == 1
    assert bar.live.is_started
    notice.end()
    assert not bar.live.is_started
    assert notice._bar is None
    assert caplog.records == []


def test_compilation_joins_the_bar_of_a_command_and_leaves_it_running(notice):
    with Progress(console=Console(file=io.StringIO(), force_terminal=True)) as bar:
        own = bar.add_task("Computing", total=1.0)
        notice.command_bar = bar
        notice.begin()
        assert [task.description for task in bar.tasks] == ["Computing", TITLE]
        notice.end()
        assert [task.id for task in bar.tasks] == [own]
        assert bar.live.is_started


def test_a_bar_of_another_library_is_left_alone(notice, monkeypatch):
    """rich allows one live display on a console: compilation then shows nothing, and nothing fails."""
    monkeypatch.setattr(compilation, "_own_bar", lambda: None)
    monkeypatch.setattr(compilation, "_bar_is_seen", lambda: True)
    notice.begin()
    notice.end()
    assert notice._bar is None
