"""Study files: from TOML to a problem and its analysis. `read` is the entry point; it reports all faults of a file at once.

`__init__.pyi` names what is public here. It is imported when it is first used: the templates need none of it.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
