"""stickslip: vibration of turbine blades and bladed disks with friction dampers.

The public names stand in `__init__.pyi`, by topic; each is loaded from its module when it is first used, so that importing the
package costs next to nothing:

>>> import stickslip as ss
>>> ss.hertz(480, 600)
Band(start=480.0, stop=600.0)
"""

import sys
from typing import Any

import lazy_loader

from stickslip.support import library_settings, renderers

__version__ = "0.2.0"

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'stickslip' has no attribute {name!r}", name=name, obj=sys.modules[__name__])
    return _load(name)


library_settings.ignore_working_folder()

# The rooms that show things register there when they are imported, which is when the first thing is shown.
renderers.FIGURES.registered_in = "stickslip.show.plots.catalogue"
renderers.SENTENCES.registered_in = "stickslip.show.report.answer"
