"""Says to the notice when a kernel is being compiled."""

from numba.core import event

from stickslip.support.compilation import NOTICE


class _Compilations(event.Listener):
    """Passes on which kernels are compiled; numba's own functions inside them do not count."""

    def on_start(self, what: event.Event) -> None:
        if _of_this_package(what):
            NOTICE.begin()

    def on_end(self, what: event.Event) -> None:
        if _of_this_package(what):
            NOTICE.end()


def _of_this_package(what: event.Event) -> bool:
    return bool(what.data["dispatcher"].py_func.__module__.startswith("stickslip."))


event.register("numba:compile", _Compilations())
