"""Ctrl-C and SIGTERM: passed on where they can be, held back where they must not strike, never lost."""

import _thread
import ctypes
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from multiprocessing import resource_tracker
from types import FrameType

RETRY_SECONDS = 0.05
"""After which a Ctrl-C that could not be passed on comes again."""


def _in_compiler(frame: FrameType | None) -> bool:
    """Whether a frame was called by the compiler, whose callbacks cannot pass an exception on."""
    while frame is not None:
        if "llvmlite" in frame.f_code.co_filename:
            return True
        frame = frame.f_back
    return False


def raise_in(thread: threading.Thread, error: type[BaseException]) -> None:
    """Raise an exception in a thread, between two of its instructions of Python."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), ctypes.py_object(error))


@contextmanager
def raised_again() -> Iterator[Callable[[], None]]:
    """Ctrl-C that Python drops in the block comes again a moment later, in the thread that it was for; what makes it do so.

    From callbacks of the compiler, finalizers and callbacks of weak references Python drops an exception and reports it to
    `sys.unraisablehook` alone. What has not come again when Ctrl-C ends the block does not come any more: it would kill the
    process that ends.
    """
    report_dropped, pending = sys.unraisablehook, list[threading.Timer]()

    def again() -> None:
        thread = threading.current_thread()
        send: Callable[[], None] = partial(raise_in, thread, KeyboardInterrupt)
        if thread is threading.main_thread() and signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
            # On Windows `os.kill` ends the process, whatever the signal; elsewhere it alone wakes a thread that waits.
            send = _thread.interrupt_main if os.name == "nt" else partial(os.kill, os.getpid(), signal.SIGINT)
        timer = threading.Timer(RETRY_SECONDS, send)
        timer.daemon = True
        pending.append(timer)
        timer.start()

    def dropped(unraisable: "sys.UnraisableHookArgs") -> None:
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            again()
        else:
            report_dropped(unraisable)

    sys.unraisablehook = dropped
    try:
        yield again
    except KeyboardInterrupt:
        for each in pending:
            each.cancel()
        raise
    finally:
        sys.unraisablehook = report_dropped


@contextmanager
def deferred() -> Iterator[None]:
    """Ctrl-C that cannot be passed on comes again a moment later, till it can; callbacks of the compiler must not raise."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with raised_again() as again:

        def handle(number: int, frame: FrameType | None) -> None:
            if not _in_compiler(frame):
                raise KeyboardInterrupt
            again()

        before = signal.signal(signal.SIGINT, handle)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)


def is_behind(error: BaseException) -> bool:
    """Whether Ctrl-C led to an error: Python 3.11 makes a `RuntimeError` of it in `__set_name__`, where classes are made."""
    met: list[BaseException] = []
    while error not in met:
        met.append(error)
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__ or error
    return False


@contextmanager
def held_back() -> Iterator[None]:
    """Ctrl-C and SIGTERM in the block act at its end, where they raise an exception: for short work that is to be done whole or
    whose libraries take no interruption.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # which signals do not reach
        return
    met: list[int] = []
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    held = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in held:
        signal.signal(number, lambda number, frame: met.append(number))
    try:
        yield
    finally:
        for number, handler in held.items():
            signal.signal(number, handler)
        if met:
            signal.raise_signal(met[-1])


@contextmanager
def for_this_process_only() -> Iterator[None]:
    """Ctrl-C reaches every process of a terminal; those started in this block leave it to this one, which waits until they are.

    The mask alone would not do: a signal that another thread receives is handled in the main one all the same.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it lets the signal through again when it starts
    with held_back():
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def termination_as_interrupt() -> Iterator[threading.Event]:
    """SIGTERM, which batch systems, containers and `timeout` send, acts as Ctrl-C while the block runs; whether it came.

    It does so too where SIGINT is ignored, as in the background of a shell script.
    """
    received = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield received
        return

    def handle(number: int, frame: FrameType | None) -> None:
        received.set()
        as_ctrl_c = signal.getsignal(signal.SIGINT)
        if callable(as_ctrl_c):
            as_ctrl_c(signal.SIGINT, frame)
        else:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, handle)
    try:
        yield received
    finally:
        signal.signal(signal.SIGTERM, before)
