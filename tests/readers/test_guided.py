"""Coverage-guided fuzzing: it finds what blind changes do not, and a small budget of it on readers and studies."""

import importlib.util
import random

import pytest
from readers.fuzzing import Victims, damaged, drawn, studies, study_answer
from readers.guided import Corpus, lines_reached

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

READER = """\
def read(content):
    if content[:1].isdigit():
        if content[8:9].isdigit():
            if content[16:17].isdigit():
                if content[24:25].isdigit():
                    raise KeyError("four steps deep")
"""
EXECUTIONS = 4000


@pytest.fixture
def reader(tmp_path):
    """A reader whose fault hides behind four conditions, and its folder."""
    path = tmp_path / "reader.py"
    path.write_text(READER)
    spec = importlib.util.spec_from_file_location("reader", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.read, (str(tmp_path),)


def found(corpus, draw):
    """Whether the hidden fault is found within the executions."""
    generator = random.Random(1)
    try:
        for _ in range(EXECUTIONS):
            corpus.run(*draw(corpus, generator))
    except KeyError:
        return True
    return False


def test_guided_changes_find_what_blind_ones_do_not(reader):
    read, folders = reader
    sound = b"-" * 32
    guided, blind = (Corpus(lambda which, changes: read(damaged(sound, changes)), folders) for _ in range(2))
    assert found(guided, Corpus.draw)
    assert not found(blind, lambda corpus, generator: (0, drawn(generator)))
    assert len(blind.lines) < len(guided.lines) == 5
    assert len(guided.kept) == 5  # one for each line, the one that raised too


def test_lines_of_other_folders_do_not_count(reader):
    read, _ = reader
    with lines_reached(("elsewhere",)) as lines:
        read(b"1")
    assert not lines


@pytest.mark.parametrize("kind", ["npz", "abaqus_substructure", "op4_text_dense", "dmig_free"])
def test_readers(kind, tmp_path):
    victims = Victims(tmp_path)
    corpus = Corpus(lambda which, changes: victims.answer(kind, which, changes))
    assert corpus.run(0, [])
    sound, generator = len(corpus.lines), random.Random(kind)
    for _ in range(40):
        corpus.run(*corpus.draw(generator))
    assert len(corpus.lines) > sound


def test_studies(chain, tmp_path):
    chain.save(tmp_path, "npz")
    seeds = studies(tmp_path)
    corpus = Corpus(lambda which, changes: study_answer(seeds[which % len(seeds)], tmp_path, changes))
    assert all(corpus.run(which, []) for which in range(len(seeds)))
    sound, generator = len(corpus.lines), random.Random(1)
    for _ in range(60):
        corpus.run(*corpus.draw(generator))
    assert len(corpus.lines) > sound
