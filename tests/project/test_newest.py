"""The newest Python of the machine, and nothing of SciPy whose meaning is about to change."""

import re
import sys
from pathlib import Path

from newest import newest, promised, version

ROOT = Path(__file__).parents[2]
MATRICES = re.compile(
    r"\b(?:(?:bsr|coo|csc|csr|dia|dok|lil)_matrix|sparse\.(?:identity|eye|diags|bmat|rand|random)|spmatrix=True)\b(?!_)"
)
"""What makes SciPy's sparse matrices, of which `*` is a product of matrices; sparse arrays are to replace them."""


def test_the_newest_python_starts_and_is_promised():
    found = newest()
    assert version(found)[:2] in promised()
    assert version(found) >= sys.version_info[:3]


def test_sparse_arrays_are_used_throughout():
    lines = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for folder in ("src", "tests", "verify", "robustness", "bench", "tools", "examples", "docs")
        for path in (ROOT / folder).rglob("*.py")
        if path != Path(__file__) and "_build" not in path.parts
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if MATRICES.search(line)
    ]
    assert lines == []
