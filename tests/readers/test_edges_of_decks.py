"""Edges of decks and tables: spellings of numbers, quoted names, nodes defined twice, marks of continuations, encodings.

Right values are what the manuals of the programs say.
"""

import numpy as np
import pytest

import stickslip as ss
from stickslip.laboratory.measurement.number_table import text_table
from stickslip.laboratory.measurement.records import read_record
from stickslip.model.readers.ansys_deck import read_archive
from stickslip.model.readers.input_deck import read_deck
from stickslip.model.readers.nastran_deck import read_grid
from stickslip.model.readers.numbers import number_of
from stickslip.support.checks import InputError

NO_NUMBERS = ("20_00.5", "1_0", "infinity", "inf", "-inf", "0x7d0", "1e", "１２", "1.2.3", "--1", "1 0")


@pytest.mark.parametrize("word", NO_NUMBERS)
def test_what_is_no_number_as_a_whole(word):
    assert number_of(word) is None


@pytest.mark.parametrize(
    ("word", "value"), [("2.5", 2.5), ("-.5", -0.5), ("1.", 1.0), ("2.0005D3", 2000.5), ("1.5-103", 1.5e-103), ("+7E+2", 700.0)]
)
def test_spellings_of_numbers(word, value):
    assert number_of(word) == value


@pytest.mark.parametrize("word", NO_NUMBERS[:7])
def test_tables_of_measurements_take_whole_numbers_alone(word, tmp_path):
    """Python's float reads 20_00.5 as 2000.5; an instrument that writes it, or infinity, did not mean a number."""
    rows = [f"{0.1 * k:.1f};{np.sin(k):.6f}" for k in range(20)]
    (tmp_path / "loop.csv").write_text("\n".join(["x [um];F [N]", *rows[:9], f"0.95;{word}", *rows[9:]]) + "\n")
    with pytest.raises(InputError, match="must be a number"):
        text_table(tmp_path / "loop.csv")
    table = "\n".join(["time [s];platform_x [um];force_x [N]", *(f"{row};1.0" for row in rows[:9]), f"0.95;{word};1.0"])
    (tmp_path / "record.csv").write_text(table + "\n")
    with pytest.raises(InputError, match="must be a number"):
        read_record(tmp_path / "record.csv")


def test_a_gap_of_a_record_may_be_empty_or_nan(tmp_path):
    """What then must not be there is said: cut these rows out."""
    rows = [f"{0.1 * k:.1f};{np.sin(k):.6f};{np.cos(k):.6f}" for k in range(20)]
    for gap in ("", "NaN"):
        table = ["time [s];platform_x [um];force_x [N]", *rows, f"2.0;{gap};1.000000"]
        (tmp_path / "record.csv").write_text("\n".join(table) + "\n")
        with pytest.raises(InputError, match="must be finite"):
            read_record(tmp_path / "record.csv")


@pytest.mark.parametrize(
    ("reader", "suffix", "deck"),
    [
        (read_deck, "inp", "*NODE\n1, {}, 0.0, 0.0\n"),
        (read_archive, "cdb", "/PREP7\nN,1,{},0.0,0.0\n"),
        (read_grid, "bdf", "BEGIN BULK\nGRID,1,,{},0.0,0.0\nENDDATA\n"),
    ],
)
@pytest.mark.parametrize("word", ["1_0", "infinity", "nan"])
def test_decks_take_whole_numbers_alone(reader, suffix, deck, word, tmp_path):
    (tmp_path / f"a.{suffix}").write_text(deck.format(word))
    with pytest.raises(InputError, match="number"):
        reader(tmp_path / f"a.{suffix}")


TWICE = {
    "inp": (read_deck, "*NODE\n1, 1.0, 2.0, 3.0\n*NODE\n1, {}, 2.0, 3.0\n"),
    "cdb": (read_archive, "/PREP7\nN,1,1.0,2.0,3.0\nN,1,{},2.0,3.0\n"),
    "bdf": (read_grid, "BEGIN BULK\nGRID,1,,1.0,2.0,3.0\nGRID,1,,{},2.0,3.0\nENDDATA\n"),
}


@pytest.mark.parametrize("suffix", TWICE)
def test_a_node_defined_twice(suffix, tmp_path):
    """At the same place it is noted, elsewhere refused: which one is meant?"""
    reader, deck = TWICE[suffix]
    path = tmp_path / f"a.{suffix}"
    path.write_text(deck.format("1.0"))
    found = reader(path)
    assert found.nodes == {"1": (1.0, 2.0, 3.0)}
    assert any("1 node is defined more than once" in note for note in found.notes)
    path.write_text(deck.format("7.0"))
    with pytest.raises(InputError, match="must be given once"):
        reader(path)


def test_commands_of_ansys_between_dollars(tmp_path):
    """$ parts commands, at the begin of a line too, but not in a title; ! begins a comment. (Condensed Data Input.)"""
    (tmp_path / "a.cdb").write_text("/TITLE,costs 3 $ N,9,9,9,9\n/PREP7 $ N,1,1,0,0 $N,2,2,0,0 ! $ N,3,3,0,0\n$N,4,4,0,0\n")
    assert read_archive(tmp_path / "a.cdb").nodes == {"1": (1.0, 0, 0), "2": (2.0, 0, 0), "4": (4.0, 0, 0)}


def test_a_node_of_ansys_without_number_is_the_next_one(tmp_path):
    """N, NODE, X, Y, Z: NODE defaults to the maximum node number plus 1. (Command Reference, N.)"""
    (tmp_path / "a.cdb").write_text("/PREP7\nN,,1,0,0\nN,7,0,2,0\nN,,0,0,3\n")
    assert read_archive(tmp_path / "a.cdb").nodes == {"1": (1.0, 0, 0), "7": (0, 2.0, 0), "8": (0, 0, 3.0)}


def test_empty_coordinates_of_abaqus_are_zero(tmp_path):
    """An empty field of a data line is the default, 0 for a coordinate; a node has none. (Input syntax rules, *NODE.)"""
    (tmp_path / "a.inp").write_text("*NODE\n1,,1\n2, 3\n")
    assert read_deck(tmp_path / "a.inp").nodes == {"1": (0.0, 1.0, 0.0), "2": (3.0, 0.0, 0.0)}
    (tmp_path / "a.inp").write_text("*NODE\n, 1.0, 0.0, 0.0\n")
    with pytest.raises(InputError, match="must hold a number and coordinates"):
        read_deck(tmp_path / "a.inp")


def test_names_of_abaqus_in_quotation_marks(tmp_path):
    """Labels in quotation marks may hold blanks and commas, also as one part of INSTANCE.SET. (Input syntax rules.)"""
    (tmp_path / "a.inp").write_text(
        '*PART, NAME="Blade 1"\n*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n*NSET, NSET="Tip, upper"\n2\n*END PART\n*ASSEMBLY, NAME=A\n'
        '*INSTANCE, NAME="Blade 1-1", PART="Blade 1"\n*END INSTANCE\n*INSTANCE, NAME=B, PART="Blade 1"\n*END INSTANCE\n'
        '*NSET, NSET=ALL\n"Blade 1-1"."Tip, upper"\n"Blade 1-1".1\n'
        '*NSET, NSET="pad b", INSTANCE="Blade 1-1"\n1\n*END ASSEMBLY\n'
    )
    sets = read_deck(tmp_path / "a.inp").sets
    assert sets["ALL"] == ("BLADE 1-1.2", "BLADE 1-1.1")
    assert sets["PAD B"] == ("BLADE 1-1.1",)
    assert sets["BLADE 1-1.TIP, UPPER"] == ("BLADE 1-1.2",)


def small(*fields, mark=""):
    return "".join(f"{field:<8}" for field in fields).ljust(72) + mark + "\n"


def test_continuations_of_nastran_stand_behind_their_line(tmp_path):
    """A continuation has the mark of the line it continues; one of another line would give another system of coordinates."""
    first = small("CORD2R", "1", "", "0.", "0.", "0.", "0.", "0.", "1.", mark="+A")
    second = small("CORD2R", "2", "", "0.", "0.", "0.", "0.", "0.", "1.", mark="+B")
    ends = small("+A", "1.", "0.", "0."), small("+B", "0.", "1.", "0.")
    grid = small("GRID", "5", "2", "1.", "0.", "0.")
    (tmp_path / "a.bdf").write_text("".join(("BEGIN BULK\n", first, ends[0], second, ends[1], grid, "ENDDATA\n")))
    np.testing.assert_allclose(read_grid(tmp_path / "a.bdf").nodes["5"], (0.0, 1.0, 0.0), atol=1e-15)
    for lines in ((first, ends[1], second, ends[0]), (first, second, *ends), (ends[0], first)):
        (tmp_path / "a.bdf").write_text("".join(("BEGIN BULK\n", *lines, grid, "ENDDATA\n")))
        with pytest.raises(InputError, match="must follow the line it continues"):
            read_grid(tmp_path / "a.bdf")
    (tmp_path / "a.bdf").write_text("BEGIN BULK\nCORD2R,2,,0.,0.,0.,0.,0.,1.,+X\n+Y,0.,1.,0.\nENDDATA\n")
    with pytest.raises(InputError, match="must follow"):
        read_grid(tmp_path / "a.bdf")


@pytest.mark.parametrize("mark", ["", "+"])
def test_continuations_without_marks(mark, tmp_path):
    """Blank marks, or a bare +, continue the line before."""
    lines = small("CORD2R", "2", "", "0.", "0.", "0.", "0.", "0.", "1.", mark=mark) + small(mark, "0.", "1.", "0.")
    (tmp_path / "a.bdf").write_text(f"BEGIN BULK\n{lines}{small('GRID', '5', '2', '1.', '0.', '0.')}ENDDATA\n")
    np.testing.assert_allclose(read_grid(tmp_path / "a.bdf").nodes["5"], (0.0, 1.0, 0.0), atol=1e-15)


@pytest.mark.parametrize("suffix", TWICE)
@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le"])
def test_decks_in_utf_16_are_refused_as_such(suffix, encoding, tmp_path):
    reader, deck = TWICE[suffix]
    (tmp_path / f"a.{suffix}").write_text(deck.format("1.0"), encoding=encoding)
    with pytest.raises(InputError, match=r"UTF-16.*Save it again"):
        reader(tmp_path / f"a.{suffix}")


def test_a_matrix_in_utf_16_is_refused_as_such(tmp_path):
    for name in ("M", "K"):
        (tmp_path / f"a_{name}.mtx").write_text("1,1,1,1,1.0\n", encoding="utf-16")
    with pytest.raises(InputError, match="UTF-16"):
        ss.read_model(tmp_path / "a_K.mtx")
