"""The lower bounds of pyproject.toml as constraints for pip, one `name==version` a line.

`make test-oldest` makes its environment of them.
"""

import re
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"
TESTING = ("pytest", "hypothesis")
"""What the tests need besides; of the other tools for development only the newest are asked for."""


def lower_bounds() -> list[str]:
    """Every dependency at the lowest version that it may have."""
    project = tomllib.loads(PROJECT.read_text())
    tools = [need for need in project["dependency-groups"]["dev"] if re.match(r"[\w-]+", need)[0] in TESTING]
    fast = project["project"]["optional-dependencies"]["mkl"]
    return [need.replace(">=", "==") for need in (*project["project"]["dependencies"], *fast, *tools)]


if __name__ == "__main__":
    sys.stdout.write("\n".join(lower_bounds()) + "\n")
