"""Libraries of tables, datasets, meshes and HDF5 files, which take up to a second to load: each is loaded when it is first used.

`from stickslip.support.late import xr` stands in place of `import xarray as xr`, in annotations too. `Axes` and
`Figure` of matplotlib are for annotations alone.
"""

from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import h5py
    import pandas as pd
    import skfem
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
else:

    class Late(ModuleType):
        """A module that is imported when one of its names is asked for."""

        def __getattr__(self, name: str) -> Any:
            from importlib import import_module

            return getattr(import_module(self.__name__), name)

    h5py, pd, skfem, xr = (Late(name) for name in ("h5py", "pandas", "skfem", "xarray"))
    Axes = Figure = Any

__all__ = ["Axes", "Figure", "h5py", "pd", "skfem", "xr"]
