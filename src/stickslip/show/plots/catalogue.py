"""Imports every figure of this folder, each of which registers itself for what it shows (`stickslip.support.renderers`)."""

from importlib import import_module
from pkgutil import iter_modules

from stickslip.show import plots

for _module in iter_modules(plots.__path__, f"{plots.__name__}."):
    if _module.name != __name__:
        import_module(_module.name)
