"""How objects of lower rooms are shown by rooms above them: what draws or describes a class registers itself here.

A room that shows something knows what it shows, not the other way round. The package (`__init__.py`), which knows all rooms,
says which module to import before the first renderer is asked for.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, TypeVar

Renderer = TypeVar("Renderer", bound=Callable[..., Any])


class Renderers:
    """Functions that show objects, by the name of their class, the usual one as "" and others by name.

    registered_in: the module that imports all that register.
    """

    def __init__(self) -> None:
        self.registered_in = ""
        self._known: dict[str, dict[str, Callable[..., Any]]] = {}

    def of(self, shown: str, name: str = "") -> Callable[[Renderer], Renderer]:
        """Register the decorated function, or class, as what shows objects of a class: `@FIGURES.of("Campbell")`."""

        def register(renderer: Renderer) -> Renderer:
            self._known.setdefault(shown, {})[name] = renderer
            return renderer

        return register

    def known(self, shown: str) -> Mapping[str, Callable[..., Any]]:
        """What shows objects of a class, by name."""
        import_module(self.registered_in)
        return self._known.get(shown, {})


FIGURES = Renderers()
"""Charts and drawings."""

SENTENCES = Renderers()
"""What `print` and notebooks say."""
