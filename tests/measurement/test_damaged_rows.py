"""A damaged row is refused wherever it stands: the first one is no line of titles, and no row is left out in silence."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.laboratory.measurement.number_table import text_table

HEAD = "Frequency [Hz],Amplitude [mm/N],Phase [deg]"
ROWS = ["100.0,0.080,-1.4", "102.5,0.083,-1.5", "105.0,0.087,-1.6", "107.5,0.091,-1.7", "110.0,0.096,-1.8"]
DAMAGED = [
    *("1OO.0,0.080,-1.4", "l00.0,0.080,-1.4", "100.0,>range,-1.4", "100.0,OVERLOAD,-1.4", "100.0,0.0.80,-1.4", "100.0,0.080,--"),
    *("100.0,0.080", "100.0,0.080,-1.4,7", "#N/A,0.080,-1.4", "#REF!,0.080,-1.4", "---,0.080,-1.4", "100.0,#DIV/0!,-1.4"),
    "100.0;0.080;-1.4",
]


def written(tmp_path, lines, name="a.csv"):
    (tmp_path / name).write_text("\n".join(lines) + "\n")
    return tmp_path / name


@pytest.mark.parametrize("damaged", DAMAGED)
@pytest.mark.parametrize("units", [[], ["Hz,mm/N,deg"], ["[Hz],[mm/N],[deg]", ""]])
def test_a_damaged_row_is_refused_in_every_place(tmp_path, damaged, units):
    """The same words for the first row as for a later one."""
    for place in (0, 1, 2, 4):
        lines = [HEAD, *units, *ROWS]
        lines[1 + len(units) + place] = damaged
        with pytest.raises(ss.InputError, match=rf"(Line {2 + len(units) + place}|row {1 + place})\b"):
            ss.read_measured_response(written(tmp_path, lines), force=1.0)


def test_several_damaged_rows_at_the_start(tmp_path):
    """Half of the file was lost in silence."""
    lines = ["Frequency [Hz];Amplitude [mm/N];Phase [deg]", *(f"{f};>range;-1,4" for f in ("100", "102,5", "105"))]
    lines += ["107,5;0,091;-1,7", "110;0,096;-1,8", "112;0,10;-1,8"]
    with pytest.raises(ss.InputError, match=r"Line 2, column 2 of a\.csv must be a number, but is '>range'"):
        ss.read_measured_response(written(tmp_path, lines), force=1.0)


def test_an_empty_cell_in_the_first_row_is_a_gap_as_in_a_later_one(tmp_path):
    for place in (0, 1, 3):
        rows = [[100.0 + k, 2.0 + k, 3.0] for k in range(4)]
        lines = [",".join(f"{x:g}" for x in row) for row in rows]
        lines[place] = f"{rows[place][0]:g},,3"
        numbers = text_table(written(tmp_path, ["a,b,c", *lines])).numbers
        assert numbers.shape == (4, 3)
        assert np.argwhere(np.isnan(numbers)).tolist() == [[place, 1]]


@pytest.mark.parametrize(
    "above",
    [
        ["Points;1024"],
        ["Bench 3;5.0", "Operator;A. B.", "f;x"],
        ["01.02.2026;Bench 3"],
        ["f;2"],
        ["f;x", "Hz;1"],
        ["f;x", "# 99.0;1OO"],
        ["1024 0.5 settings"],
        ["5120"],
        ["f;x", "-;-"],
    ],
)
def test_settings_titles_and_units_above_the_numbers_are_no_rows(tmp_path, above):
    table = text_table(written(tmp_path, [*above, "1.0;2.0", "2.0;3.0", "3.0;4.0"]), lambda title: title == "f")
    assert table.numbers.tolist() == [[1.0, 2.0], [2.0, 3.0], [3.0, 4.0]]


def test_damaged_first_rows_of_other_records(tmp_path):
    rows = [f"{k / 2000:.6f},{np.exp(-0.004 * k) * np.cos(0.2 * k):.6f}" for k in range(2000)]
    rows[0] = "0.OOOOOO,1.000000"
    with pytest.raises(ss.InputError, match="Line 2, column 1"):
        ss.read_decay(written(tmp_path, ["time [s],displacement [mm]", *rows]))


@pytest.mark.parametrize(
    ("frequencies", "said"),
    [
        ([1.0, 2.0, 3.0, 4.0], None),
        ([4.0, 3.0, 2.0, 1.0], None),
        ([1.0, 2.0, 2.0, 3.0, 3.0], "2 frequencies are given again, the first at 2 Hz"),
        ([1.0, 2.0, 3.0, 1.5, 2.5], "not in order from row 4 on"),
        ([1.0, 2.0, 2.0, 1.0], "not in order throughout"),
    ],
)
def test_frequencies_twice_or_out_of_order_are_said(tmp_path, frequencies, said):
    rows = [f"{f},{1.0 + f}" for f in frequencies]
    test = ss.read_measured_response(written(tmp_path, ["frequency [Hz],receptance [mm/N]", *rows]), force=1.0)
    notes = [note for note in test.notes if "frequenc" in note and ("again" in note or "order" in note)]
    assert (len(notes) > 0) == (said is not None)
    assert said is None or any(said in note for note in notes)
    assert np.asarray(test.frequency).tolist() == frequencies


ROW = "330.00,0.003729,-9.507"


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("330.00,0.0037293729,-9.507", "must have 6 decimals, as all others of its column, but is '0.0037293729'"),
        ("330.001,0.003729,-9.507", "must have 2 decimals"),
        ("330.00,0.003729,-9.", "must have 3 decimals"),
        ("330.00,0.00379,-9.507", "must have 6 decimals"),
        ("330.00,0.003729,-9#.507", "must be a number"),
        ("330.00,0.003729,-9.-507", "must be a number"),
    ],
)
def test_a_number_with_other_digits_than_its_column(tmp_path, row, said):
    rows = [f"{330.0 + k:.2f},{0.003729 + 1e-6 * k * k:.6f},{-9.507 - 0.13 * k:.3f}" for k in range(30)]
    for place in (3, 29):
        lines = [*rows]
        lines[place] = row.replace("330", str(330 + place))
        with pytest.raises(ss.InputError, match=said):
            ss.read_measured_response(written(tmp_path, ["Frequency [Hz],Receptance [mm/N],Phase [deg]", *lines]), force=1.0)


@pytest.mark.parametrize("form", ["{:g}", "{:.4g}", "{:.3e}", "{!r}", "{:.5f}"])
def test_numbers_of_any_usual_form_are_read(tmp_path, form):
    """Significant digits, shortest numbers, exponents: whose decimals vary, or all but one of which may agree by chance."""
    generator = np.random.default_rng(0)
    for _ in range(40):
        size = int(generator.integers(10, 60))
        values = np.c_[
            np.arange(1, size + 1), 10.0 ** generator.uniform(-1.2, -0.8, size), generator.uniform(-180.0, 180.0, size)
        ]
        lines = [",".join(form.format(float(x)) for x in row) for row in values]
        assert text_table(written(tmp_path, ["f,a,b", *lines])).numbers.shape == values.shape


def test_what_is_left_out_or_cut_off_is_said(tmp_path):
    rows = [f"{330 + k},{0.1 + 0.01 * k:.2f},-9.{k:03d}" for k in range(6)]
    for lines, said in (
        ([*rows[:3], "#333,0.13,-9.003", *rows[4:]], "comments between the numbers are left out, line 5"),
        (rows, None),
    ):
        notes = text_table(written(tmp_path, ["f,a,b", *lines])).notes
        assert [note.partition(": ")[2].rstrip(".") for note in notes] == ([] if said is None else [said])
    above = text_table(written(tmp_path, [rows[0], "Operator", "f,a,b", *rows[1:]], "b.csv")).notes
    assert above == ("b.csv: numbers above the titles are left out, line 1.",)
    (tmp_path / "c.csv").write_text("\n".join(["f,a,b", *rows])[:-1])
    assert "Is it cut off?" in text_table(tmp_path / "c.csv").notes[0]
