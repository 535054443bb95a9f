"""The glossary names what exists, each term once, and words that it replaced do not come back."""

import importlib
import inspect
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import typer

import stickslip as ss
from stickslip.cli import app
from stickslip.study.templates import KINDS
from tools.reference import SECTIONS

ROOT = Path(__file__).parents[2]
GLOSSARY = ROOT / "docs" / "glossary.md"
HEAD = re.compile(r"\| (term|analysis) \|")

# Words that the glossary's terms replaced, as regular expressions without regard to case.
REPLACED = {
    r"summit": "peak",
    r"\bcrests?_|_crest\b|\bCrest\b|corner crest": "peak band",
    r"doubt(?!\"|ed\b|ful)": "warning",
    r"densif": "refine",
    r"\bleft_out\b|LeftOut": "truncation",
    r"falls?_apart": "uncoupled waves",
    r"curve apart": "isola",
    r"\bfollower\b": "peak continuation",
    r"(?-i:\bRoom\b)": "workspace",
    r"foret(old|ell)": "predicted",
    r"\btold\b|\btell(s|ing)?\b|_tell\b|_told\b": "report",
    r"what[_-]?matters": "sensitivity indices",
    r"design_damper": "damper_design",
    r"MistunedDisks": "MistunedPopulation",
    r"FinishedFolder": "CheckpointFolder",
    r"results_told": "results_representative",
}
READ = sorted(
    path
    for pattern in ("src/**/*.py", "src/**/*.js", "src/**/*.toml", "docs/*.md", "examples/*.py", "README.md", "CONTRIBUTING.md")
    for path in ROOT.glob(pattern)
)


def entries(page: str) -> list[tuple[str, str, list[str], list[str]]]:
    """Term, meaning, Python names, and study keys or commands, of each row."""
    rows = [[cell.strip() for cell in line.strip("|\n").split("|")] for line in page.splitlines() if line.startswith("| ")]
    named = [row for row in rows if not HEAD.match(f"| {row[0]} |") and set(row[0]) != {"-"}]
    return [(row[0], row[1], re.findall("`([^`]+)`", row[2]), re.findall("`([^`]+)`", row[3])) for row in named]


def resolved(name: str) -> object:
    """What a public name, a name below a module, or a method, field or argument of these, refers to; raises LookupError."""
    head, *rest = name.split(".")
    found = getattr(ss, head, None)
    if found is None or inspect.ismodule(found):
        found, rest = module_of([head, *rest])
    for part in rest:
        if callable(found) and part in inspect.signature(found).parameters:
            return found
        if not hasattr(found, part):
            raise LookupError(name)
        found = getattr(found, part)
    return found


def module_of(parts: list[str]) -> tuple[object, list[str]]:
    """The innermost module that the parts name, and the parts beyond it."""
    for count in range(len(parts), 0, -1):
        try:
            return importlib.import_module(".".join(["stickslip", *parts[:count]])), parts[count:]
        except ModuleNotFoundError:
            continue
    raise LookupError(".".join(parts))


def exists(key: str) -> bool:
    """Whether a table or key of a study file, or a command with its arguments, exists."""
    if not key.startswith("stickslip "):
        table, _, name = key.partition(" ")
        models = SECTIONS.get(table, ())
        return bool(models) and (not name or any(name in model.model_fields for model in models))
    _, name, *arguments = key.split()
    command = typer.main.get_command(app).commands.get(name)  # type: ignore[attr-defined]
    known = {option for parameter in command.params for option in parameter.opts} if command else set()
    return command is not None and all(word in known or (name == "new" and word in KINDS) for word in arguments)


def occurrences(pattern: str, flags: re.RegexFlag = re.IGNORECASE) -> Iterator[str]:
    for path in READ:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            if re.search(pattern, line, flags):
                yield f"{path.relative_to(ROOT)}:{number}: {line.strip()}"


ENTRIES = entries(GLOSSARY.read_text(encoding="utf-8"))


def test_the_glossary_holds_its_terms_once_and_is_linked() -> None:
    terms = [term for term, *_ in ENTRIES]
    assert len(terms) >= 60
    assert sorted(set(terms)) == sorted(terms)
    assert all(meaning for _, meaning, *_ in ENTRIES)
    assert "(glossary.md)" in (ROOT / "docs" / "index.md").read_text(encoding="utf-8")


def missing(names: Iterable[str]) -> list[str]:
    """Those of some Python names that name nothing."""
    found = []
    for name in names:
        try:
            resolved(name)
        except LookupError:
            found.append(name)
    return found


def test_python_names_exist() -> None:
    assert missing(sorted({name for _, _, names, _ in ENTRIES for name in names})) == []


def test_study_keys_and_commands_exist() -> None:
    assert [key for key in sorted({key for *_, keys in ENTRIES for key in keys}) if not exists(key)] == []


def test_wrong_names_keys_and_commands_are_found() -> None:
    names = ["Strukture", "Structure.dof", "solve.summits", "forced_response.harmonic"]
    assert missing(names) == names
    keys = ["[sweeps]", "[sweep] harmonic", "stickslip solve", "stickslip run --resumed", "stickslip new x"]
    assert [key for key in keys if exists(key)] == []


def test_replaced_words_do_not_come_back() -> None:
    found = [f"write {new!r}: {line}" for pattern, new in REPLACED.items() for line in occurrences(pattern)]
    assert not found, "\n".join(found)


def test_papers_are_cited_by_title_or_authors() -> None:
    found = list(occurrences(r"\(S[0-9][): ]|\bS[0-9] \(?equation", re.RegexFlag(0)))
    assert not found, "\n".join(found)
