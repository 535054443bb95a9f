"""Code on the pages runs, and computes what the page says."""

import re
from pathlib import Path

import numpy as np

import stickslip as ss

DOCS = Path(__file__).parents[2] / "docs"


def test_the_problem_of_another_code_is_the_same_here():
    """The three masses of docs/other_codes.md are the rig that is compared with the other code's curves."""
    (block,) = re.findall(r"```python\n(.*?)```", (DOCS / "other_codes.md").read_text(), re.S)
    names = {}
    exec(block, names)
    peaks = names["response"].peaks()
    rig = ss.forced_response(ss.rigs.chain_of_three(), ss.radians_per_second(0.5, 2.0), harmonics=7, samples=1024).peaks()
    for column in ("frequency", "amplitude"):
        np.testing.assert_allclose(peaks[column], rig[column], rtol=1e-6)


REFERENCES = {
    "faq",
    "examples",
    "glossary",
    "verification",
    "robustness",
    "mutation",
    "calibration",
    "benchmarks",
    "api",
    "decisions",
}
"""Pages that nobody reads from the start to the end."""

PAGES = sorted(set(re.findall(r"^[a-z_]+$", (DOCS / "index.md").read_text(), re.M)) - REFERENCES)
"""All others in the contents."""

EQUATIONS = {"conventions", "theory"}
"""Pages without results to show."""


def test_the_contents_are_read():
    assert len(PAGES) > 20
    assert {path.stem for path in DOCS.glob("*.md")} >= REFERENCES | EQUATIONS


def lacks(name):
    """What a page lacks; its first paragraph says what it does, the picture stands before the second heading of a part."""
    text = (DOCS / f"{name}.md").read_text()
    title, purpose, _ = text.split("\n\n", 2)
    opening = "## ".join(re.split(r"^## ", text, flags=re.M)[:2])
    has = {
        "title": title.startswith("# "),
        "purpose": purpose.startswith("This page "),
        "picture": name in EQUATIONS or re.search(r"^!\[.+\]\(|^```\{image\} ", opening, re.M),
        "next": re.match(r"Next: .*\]\([a-z_]+\.md\)", text.rstrip().rpartition("\n\n")[2], re.S),
    }
    return [part for part, there in has.items() if not there]


def test_a_page_opens_with_its_purpose_and_a_picture_and_ends_with_what_to_read_next():
    assert {name: lacks(name) for name in PAGES if lacks(name)} == {}
