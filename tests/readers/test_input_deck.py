"""Decks of Abaqus and CalculiX: places of nodes and members of sets worked out by hand; what is not obeyed is said."""

import numpy as np
import pytest
from each import each

import stickslip as ss
from stickslip.model.readers.input_cards import MODEL_CARDS
from stickslip.model.readers.input_deck import READ, read_deck
from stickslip.support.checks import InputError

NODES = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n4, 3., 0., 0.\n"
BLADE = f"*PART, NAME=BLADE\n{NODES}*NSET, NSET=PAD\n2, 3\n*END PART\n*ASSEMBLY, NAME=A\n"
ONE = "*INSTANCE, NAME=P-1, PART=BLADE\n*END INSTANCE\n"
TWO = ONE + "*INSTANCE, NAME=P-2, PART=BLADE\n0., 5., 0.\n*END INSTANCE\n"


def deck(folder, text, **files):
    for name, content in files.items():
        (folder / f"{name}.inp").write_text(content)
    (folder / "a.inp").write_text(text)
    return read_deck(folder / "a.inp")


def places(found, *nodes):
    return [pytest.approx(found.nodes[str(node)], abs=1e-12) for node in nodes]


def test_a_keyword_line_that_ends_in_a_comma_goes_on(tmp_path):
    found = deck(tmp_path, NODES + "*NSET, NSET=PAD,\n** a comment between\n GENERATE\n1, 4, 1\n")
    assert found.sets == {"PAD": ("1", "2", "3", "4")}
    assert found.notes == ()


def test_a_comma_too_many_and_parts_without_instances(tmp_path):
    """A number is no parameter, as CalculiX reads such lines, which knows no parts either; a name could be both."""
    found = deck(tmp_path, f"*PART, NAME=P\n{NODES}*NSET, NSET=A, \n 2, 3,\n4\n*NSET, NSET=B\nA\n")
    assert (found.sets, len(found.nodes), found.notes) == ({"A": ("2", "3", "4"), "B": ("2", "3", "4")}, 4, ())
    with pytest.raises(InputError, match=r"line 8, \*NSET: A parameter of \*NSET must be one of .* but is 'A'"):
        deck(tmp_path, NODES + "*NSET, NSET=A\n1\n*NSET, NSET=B,\nA, 2\n")


def test_sets_of_nfill_are_ascending_unless_unsorted(tmp_path):
    nodes = "*NODE\n1, 0., 0., 0.\n3, 2., 0., 0.\n11, 0., 2., 0.\n13, 2., 2., 0.\n"
    sets = "*NSET, NSET=A{}\n3, 1\n*NSET, NSET=B{}\n11, 13\n*NFILL\nA, B, 2, 5\n"
    assert places(deck(tmp_path, nodes + sets.format("", "")), 6, 8) == [(0.0, 1.0, 0.0), (2.0, 1.0, 0.0)]
    crossed = deck(tmp_path, nodes + sets.format(", UNSORTED", ", UNSORTED"))
    assert places(crossed, 6, 8) == [(1.0, 1.0, 0.0), (1.0, 1.0, 0.0)]


def test_members_of_sets_are_limited_in_all(tmp_path):
    card = "*NSET, NSET=A{}, GENERATE\n1, 600000\n"
    assert len(deck(tmp_path, card.format(1)).sets["A1"]) == 600_000
    listed = "*NSET, NSET=B{}\n" + "A1\n"
    with pytest.raises(InputError, match="Members of the sets of the deck must be at most 1000000 and one for each byte"):
        deck(tmp_path, card.format(1) + listed.format(1) + listed.format(2))


@pytest.mark.parametrize("last", [2241775, 10**17])
def test_a_range_beyond_what_a_cut_deck_holds(tmp_path, last):
    """As a pre-processor writes sets of all elements, of which a deck that was cut to its nodes holds none."""
    sets = f"*ELSET, ELSET=ALL, GENERATE\n1, {last}, 1\n*NSET, NSET=PAD\n1, 4\n*NSET, NSET=EVERY, GENERATE\n2, {last}\n"
    found = deck(tmp_path, NODES + sets)
    assert found.sets == {"PAD": ("1", "4"), "EVERY": ("2", "3", "4")}
    assert [note for note in found.notes if "in a range" in note] == [
        f"*ELSET ALL (a.inp, line 6) names {last} elements in a range, of which the deck holds 0 up to there: the others are "
        "left out.",
        f"*NSET EVERY (a.inp, line 10) names {last - 1} nodes in a range, of which the deck holds 3 up to there: the others are "
        "left out.",
    ]


def test_few_bytes_cannot_include_many(tmp_path):
    """999 includes of one file took minutes."""
    (tmp_path / "big.inp").write_text("*NODE\n" + "".join(f"{k},0,0,0\n" for k in range(1, 20000)))
    with pytest.raises(InputError, match=r"must have at most \d+ bytes with the files that it includes again"):
        deck(tmp_path, "*INCLUDE, INPUT=big.inp\n" * 999)


def test_the_processor_time_of_a_deck_is_limited(tmp_path, monkeypatch):
    monkeypatch.setattr("stickslip.model.readers.deck.SECONDS", -1.0)
    with pytest.raises(InputError, match=r"must be read within .* s of processor time, but is 'at a\.inp, line 1 by then'"):
        deck(tmp_path, NODES)


@pytest.mark.parametrize("place", ["*NODE\n{},0,0,0\n", NODES + "*NSET, NSET=A\n{}\n", NODES + "*NGEN, NSET=A\n1, {}\n"])
def test_a_number_of_thousands_of_digits(tmp_path, place):
    with pytest.raises(InputError, match=r"a\.inp, line \d, \*(NODE|NSET|NGEN)"):
        deck(tmp_path, place.format("9" * 5000))


def test_a_byte_order_mark_is_no_part_of_the_first_card(tmp_path):
    assert len(deck(tmp_path, f"\ufeff{NODES}").nodes) == 4


def test_cylindrical_nodes(tmp_path):
    """r = 2 at 0°, 90°, 180°, 270°."""
    found = deck(tmp_path, "*NODE, SYSTEM=C\n1, 2., 0., 0.\n2, 2., 90., 0.\n3, 2., 180., 0.\n4, 2., 270., 1.\n")
    assert places(found, 1, 2, 3, 4) == [(2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (-2.0, 0.0, 0.0), (0.0, -2.0, 1.0)]
    with pytest.raises(InputError, match=r"a\.inp, line 1, \*NODE: SYSTEM of \*NODE must be R or C, but is 'S'"):
        deck(tmp_path, "*NODE, SYSTEM=S\n1, 2., 0., 0.\n")


@each(
    ("points", "second"),
    [
        ("", (1.0, 0.0, 0.0)),
        ("100., 0., 7.\n", (101.0, 0.0, 7.0)),  # a alone moves the origin
        (",,,0.,1.,0.\n", (0.0, 1.0, 0.0)),  # a blank is 0
        ("100., 0., 0., 100., 1., 5.\n", (100.0, 1.0, 0.0)),  # without c: z stays, x' is that of b in the (x, y) plane
        ("100., 0., 0., 100., 1., 0.\n99., 0., 0.\n", (100.0, 1.0, 0.0)),
        ("100., 0., 0., 100., 1., 0., 99., 0., 0.\n", (100.0, 1.0, 0.0)),
        ("0., 0., 0., 0., 0., 3., 1., 0., 0.\n", (0.0, 0.0, 1.0)),  # x' along z
    ],
)
def test_axes_of_nodes(tmp_path, points, second):
    """Node 2 lies at 1 on the first axis; a second *SYSTEM ends the first."""
    found = deck(tmp_path, f"*SYSTEM\n{points}{NODES}*SYSTEM\n*NODE\n9, 1., 2., 3.\n")
    assert places(found, 2, 9) == [second, (1.0, 2.0, 3.0)]


def test_the_second_axis_of_nodes(tmp_path):
    """a = (100, 0, 0), x' along y, y' along −x: the point (0, 1, 2) lies at (99, 0, 2)."""
    found = deck(
        tmp_path, "*SYSTEM\n100., 0., 0., 100., 1., 0., 99., 0., 0.\n*NODE\n1, 0., 1., 2.\n*NODE, SYSTEM=C\n2, 3., 90., 0.\n"
    )
    assert places(found, 1, 2) == [(99.0, 0.0, 2.0), (97.0, 0.0, 0.0)]
    for line in ("1., 1., 1., 2., 2., 2., 3., 3., 3.", "1., 1., 1., 1., 1., 1.", "1., 2."):
        with pytest.raises(InputError, match=r"SYSTEM"):
            deck(tmp_path, f"*SYSTEM\n{line}\n")


def test_generated_nodes_on_a_line_and_an_arc(tmp_path):
    found = deck(tmp_path, "*NODE\n1, 0., 0., 0.\n5, 8., 0., 0.\n*NGEN, NSET=LINE\n1, 5, 1\n")
    assert places(found, 2, 3, 4) == [(2.0, 0.0, 0.0), (4.0, 0.0, 0.0), (6.0, 0.0, 0.0)]
    assert found.sets == {"LINE": ("1", "2", "3", "4", "5")}
    quarter = "*NODE\n1, 2., 0., 1.\n31, 0., 2., 1.\n99, 0., 0., 1.\n*NGEN, LINE=C\n"
    for extra in ("99", ", 0., 0., 1."):
        found = deck(tmp_path, quarter + f"1, 31, 10, {extra}\n")
        c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
        assert places(found, 11, 21) == [(2 * c, 2 * s, 1.0), (2 * s, 2 * c, 1.0)]
    found = deck(tmp_path, quarter + "1, 31, 10, 99, , , , 0., 0., -1.\n")  # the other way round: 270° in three steps
    assert places(found, 11, 21) == [(0.0, -2.0, 1.0), (-2.0, 0.0, 1.0)]
    with pytest.raises(InputError, match=r"must have a node as its centre where \*SYSTEM is in force"):
        deck(tmp_path, "*SYSTEM\n1., 0., 0.\n" + quarter + "1, 31, 10, , 0., 0., 1.\n")


def test_nodes_between_two_sets(tmp_path):
    """Four intervals between y = 0 and y = 4, numbers in steps of 100."""
    ends = "*NODE, NSET=A\n1, 0., 0., 0.\n2, 1., 0., 0.\n*NODE, NSET=B\n401, 0., 4., 0.\n402, 1., 8., 0.\n"
    text = f"{ends}*NFILL, NSET=ALL\nA, B, 4, 100\n"
    found = deck(tmp_path, text)
    assert places(found, 101, 301, 202) == [(0.0, 1.0, 0.0), (0.0, 3.0, 0.0), (1.0, 4.0, 0.0)]
    assert set(found.sets["ALL"]) == set(found.nodes)
    with pytest.raises(InputError, match=r"must have equal distances, but is 'BIAS'\. Write the nodes out"):
        deck(tmp_path, text.replace("NSET=ALL", "BIAS=1.2"))


def test_an_instance_is_moved_and_then_turned(tmp_path):
    """Moved by (0, 250, 0), then turned by 90° about the line through (0, 250, 0) along z: x becomes y."""
    placed = ONE.replace("\n", "\n0., 250., 0.\n0., 250., 0., 0., 250., 1., 90.\n", 1)
    found = deck(tmp_path, BLADE + placed + "*END ASSEMBLY\n")
    assert places(found, 1, 2, 4) == [(0.0, 250.0, 0.0), (0.0, 251.0, 0.0), (0.0, 253.0, 0.0)]
    assert found.sets == {"PAD": ("2", "3"), "P-1.PAD": ("2", "3")}
    assert found.notes == ()


def test_sets_of_an_assembly(tmp_path):
    sets = "*NSET, NSET=A\nP-1.2, P-1.4\n*NSET, NSET=B, INSTANCE=P-1, GENERATE\n1, 3, 2\n*NSET, NSET=C\nP-1.PAD, B\n"
    found = deck(tmp_path, BLADE + ONE + sets + "*END ASSEMBLY\n")
    assert {name: found.sets[name] for name in "ABC"} == {"A": ("2", "4"), "B": ("1", "3"), "C": ("2", "3", "1")}
    found = deck(tmp_path, BLADE + TWO + sets + "*NSET, NSET=D\nP-2.PAD\n*END ASSEMBLY\n")
    assert {name: found.sets[name] for name in "BD"} == {"B": ("P-1.1", "P-1.3"), "D": ("P-2.2", "P-2.3")}
    assert "PAD" not in found.sets  # each instance has one
    assert found.nodes["P-2.2"] == (1.0, 5.0, 0.0)
    assert "Abaqus renumbers the nodes of an assembly" in found.notes[0]


def test_nodes_of_an_assembly_that_share_a_number_with_its_instance(tmp_path):
    found = deck(tmp_path, BLADE + ONE + "*NODE\n1, 9., 9., 9.\n*NSET, NSET=R\n1\n*END ASSEMBLY\n")
    assert (found.nodes["1"], found.nodes["P-1.1"]) == ((9.0, 9.0, 9.0), (0.0, 0.0, 0.0))
    assert found.sets["R"] == ("1",)


def test_nodes_of_the_elements_of_a_set(tmp_path):
    """Of solids over two lines, beams, and elements that another set lists."""
    text = (
        NODES
        + "*ELEMENT, TYPE=C3D8, ELSET=SOLID\n7, 1, 2, 3, 4, 5,\n6, 7, 8\n*ELEMENT, TYPE=B31, ELSET=BEAM\n8, 3, 9\n9, 9, 10\n"
        "*ELSET, ELSET=BOTH\nBEAM, 7\n*ELSET, ELSET=LAST, GENERATE\n8, 9\n"
        "*NSET, NSET=S, ELSET=SOLID\n*NSET, NSET=B, ELSET=LAST\n*NSET, NSET=ALL, ELSET=BOTH\n"
    )
    found = deck(tmp_path, text)
    assert {name: sorted(map(int, members)) for name, members in found.sets.items()} == {
        "S": [1, 2, 3, 4, 5, 6, 7, 8],
        "B": [3, 9, 10],
        "ALL": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10],
    }


def test_nodes_of_the_elements_of_an_instance(tmp_path):
    part = BLADE.replace("*END PART", "*ELEMENT, TYPE=T3D2, ELSET=E\n5, 1, 2\n6, 3, 4\n*END PART")
    sets = "*ELSET, ELSET=E, INSTANCE=P-1\n6\n*NSET, NSET=A, ELSET=E\n*NSET, NSET=B, ELSET=P-1.E\n"
    sets += "*NSET, NSET=C, ELSET=E, INSTANCE=P-1\n"
    found = deck(tmp_path, part + ONE + sets + "*END ASSEMBLY\n")
    assert {name: found.sets[name] for name in "ABC"} == {"A": ("3", "4"), "B": ("1", "2", "3", "4"), "C": ("1", "2", "3", "4")}


def test_heat_elements_go_on_without_a_comma(tmp_path):
    """DC3D20 has as many nodes as its name says, whatever ends its first line."""
    text = (
        NODES + "*ELEMENT, TYPE=DC3D20, ELSET=E\n1, 1,2,3,4,5,6,7,8,9,10,11,12,13,14,15\n16,17,18,19,20\n*NSET, NSET=A, ELSET=E\n"
    )
    assert deck(tmp_path, text).sets["A"] == tuple(str(node) for node in range(1, 21))


def test_members_that_are_not_known_are_refused_with_the_line(tmp_path):
    for text in ("*NSET, NSET=A\n1, PADS\n", "*NSET, NSET=A, ELSET=E\n", "*ELSET, ELSET=E\nX\n"):
        with pytest.raises(InputError, match=r"a\.inp, line 8, .*must be a number or a set defined before"):
            deck(tmp_path, NODES + "*NSET, NSET=PAD\n1\n" + text)
    with pytest.raises(InputError, match=r"a\.inp, line 8, .*The elements of \*NSET, ELSET= must stand in the deck, but is '5'"):
        deck(tmp_path, NODES + "*ELSET, ELSET=E\n5\n*NSET, NSET=A, ELSET=E\n")


def test_rows_of_nodes_with_axes_of_their_own(tmp_path):
    """Abaqus writes their rows along these axes; CalculiX writes the same matrices as without *TRANSFORM (2.20, tried)."""
    text = NODES + "*NSET, NSET=A\n1, 2\n*TRANSFORM, NSET=A, TYPE=C\n0., 0., 0., 0., 0., 1.\n"
    (tmp_path / "job_STIF1.mtx").write_text("".join(f"{k},1, {k},1, 5.0\n" for k in (1, 2)))
    (tmp_path / "job_MASS1.mtx").write_text("".join(f"{k},1, {k},1, 1.0\n" for k in (1, 2)))
    (tmp_path / "job.inp").write_text(text)
    turned, note = ss.read_model(tmp_path / "job_STIF1.mtx").notes
    assert turned.startswith("job.inp gives local axes to 1 node (*TRANSFORM")
    assert note.startswith("job.inp has 1 node with axes of their own (*TRANSFORM")
    assert note.endswith("leaves rows out: 1.")  # it lies on the axis
    for name in ("sti", "mas"):
        (tmp_path / f"job.{name}").write_text("1 1 5.0\n")
    (tmp_path / "job.dof").write_text("1.1\n")
    assert ss.read_model(tmp_path / "job.sti").notes == ()


def test_axes_of_a_set_that_comes_later_and_of_an_instance(tmp_path):
    """Abaqus/CAE writes *TRANSFORM before its set."""
    turned = '*TRANSFORM, NSET="_T-Axes of 1"\n1., 0., 0., 0., 1., 0.\n*NSET, NSET="_T-Axes of 1"\n1, 3\n'
    assert list(deck(tmp_path, NODES + turned).turned.axes) == ["1", "3"]
    part = BLADE.replace("*END PART", turned + "*END PART")
    assert len(deck(tmp_path, part + TWO + "*END ASSEMBLY\n").turned.axes) == 4
    with pytest.raises(InputError, match="A member of a set must be a number or a set defined before, but is 'X'"):
        deck(tmp_path, NODES + "*TRANSFORM, NSET=X\n1., 0., 0., 0., 1., 0.\n")


def test_keywords_without_blanks_and_instances_of_flat_decks(tmp_path):
    """CalculiX takes both: *SHELLSECTION, and INSTANCE= where the deck has none."""
    found = deck(tmp_path, NODES + "*SHELLSECTION, ELSET=E\n0.1\n*NSET, NSET=A, INSTANCE=PART-1-1\n1, 2\n")
    assert (found.sets, found.notes) == ({"A": ("1", "2")}, ())
    assert deck(tmp_path, BLADE.replace("END PART", "ENDPART") + "*INSTANCE, NAME=I, PART=BLADE\n*ENDINSTANCE\n").nodes


def test_included_files_and_files_of_data(tmp_path):
    found = deck(
        tmp_path,
        "*INCLUDE,\n INPUT=b.inp\n*NSET, NSET=A\n*INCLUDE, INPUT=c.inp\n*NODE, INPUT=d.inp\n",
        b="*NODE\n*include, input=E.inp\n2, 1., 0., 0.\n",
        c="1\n",
        d="3, 5., 0., 0.\n",
        E="1, 7., 0., 0.\n",
    )
    assert found.nodes == {"1": (7.0, 0.0, 0.0), "2": (1.0, 0.0, 0.0), "3": (5.0, 0.0, 0.0)}
    assert found.sets == {"A": ("1",)}
    with pytest.raises(
        InputError, match=r"The file that a\.inp, line 2 includes must exist in the folder of the deck, but is 'f\.inp'"
    ):
        deck(tmp_path, "** x\n*INCLUDE, INPUT=f.inp\n")


def test_included_files_outside_of_the_folder_are_refused(tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "out.inp").write_text(NODES)
    (inner / "link.inp").symlink_to(tmp_path / "out.inp")
    for name in ("../out.inp", str(tmp_path / "out.inp"), "link.inp", "..\\out.inp"):
        with pytest.raises(InputError, match=r"must lie in the folder of the deck"):
            deck(inner, f"*INCLUDE, INPUT={name}\n")


def test_files_that_include_themselves_end(tmp_path):
    with pytest.raises(InputError, match=r"must include at most 1000 files, 20 deep"):
        deck(tmp_path, "*INCLUDE, INPUT=a.inp\n")
    with pytest.raises(InputError, match=r"must include at most 1000 files, 20 deep"):
        deck(tmp_path, "*INCLUDE, INPUT=b.inp\n" * 1001, b="** nothing\n")


def test_what_is_not_obeyed_is_refused_or_said(tmp_path):
    for card in MODEL_CARDS.refused:
        with pytest.raises(InputError, match=rf"a\.inp, line 6 must hold cards that this reader obeys, but is '\*{card}'"):
            deck(tmp_path, NODES + f"*{card}, X=1\n")
    for card in MODEL_CARDS.noted:
        (note,) = deck(tmp_path, NODES + f"*{card}\n").notes
        assert note.startswith(f"a.inp: *{card} is not read; ")
    (note,) = deck(tmp_path, NODES + "*NEW THING\n*NEW THING\n*STEP\n*NEWER THING\n*END STEP\n").notes
    assert note.startswith("a.inp: this reader does not know *NEWTHING (a.inp, line 6)")
    for card in MODEL_CARDS.harmless:
        assert deck(tmp_path, NODES + f"*{card}\n").notes == ()


ABAQUS_NODES = """
*NODE, *NCOPY, *NFILL, *NGEN, *NMAP, *NSET, *SYSTEM, *TRANSFORM, *ELEMENT, *ELCOPY, *ELGEN, *ELSET, *PART, *END PART,
*INSTANCE, *END INSTANCE, *ASSEMBLY, *END ASSEMBLY, *INCLUDE, *IMPERFECTION, *IMPORT, *IMPORT NSET, *IMPORT ELSET, *SYMMETRIC
MODEL GENERATION, *PARAMETER, *PARAMETER SHAPE VARIATION, *ORIENTATION, *NORMAL, *NODAL THICKNESS
"""
"""Keywords Guide: nodes, elements and sets, in the chapters "Spatial modeling", "Assembly definition" and "Importing"."""
CALCULIX = """
*AMPLITUDE, *BEAM SECTION, *BOUNDARY, *CLEARANCE, *CONDUCTIVITY, *CONSTRAINT, *CONTACT DAMPING, *CONTACT PAIR, *CORRELATION
LENGTH, *COUPLING, *CREEP, *CYCLIC HARDENING, *CYCLIC SYMMETRY MODEL, *DAMPING, *DASHPOT, *DEFORMATION PLASTICITY, *DENSITY,
*DEPVAR, *DESIGN RESPONSE, *DESIGN VARIABLES, *DISTRIBUTING, *DISTRIBUTING COUPLING, *DISTRIBUTION, *ELASTIC, *ELECTRICAL
CONDUCTIVITY, *ELEMENT, *ELSET, *EQUATION, *EXPANSION, *FILTER, *FLUID CONSTANTS, *FLUID SECTION, *FRICTION, *GAP, *GAP
CONDUCTANCE, *GAP HEAT GENERATION, *GEOMETRIC TOLERANCES, *HEADING, *HYPERELASTIC, *HYPERFOAM, *INCLUDE, *INITIAL CONDITIONS,
*INITIAL STRAIN INCREASE, *KINEMATIC, *MAGNETIC PERMEABILITY, *MASS, *MATERIAL, *MEMBRANE SECTION, *MODEL CHANGE, *MOHR
COULOMB, *MOHR COULOMB HARDENING, *MPC, *NETWORK MPC, *NODAL THICKNESS, *NODE, *NORMAL, *NSET, *ORIENTATION, *PHYSICAL
CONSTANTS, *PLASTIC, *PRE-TENSION SECTION, *RANDOM FIELD, *REFINE MESH, *RESTART, *RIGID BODY, *ROBUST DESIGN, *SHELL SECTION,
*SOLID SECTION, *SPECIFIC GAS CONSTANT, *SPECIFIC HEAT, *SPRING, *SUBMODEL, *SURFACE, *SURFACE BEHAVIOR, *SURFACE INTERACTION,
*TIE, *TIME POINTS, *TRANSFORM, *USER ELEMENT, *USER MATERIAL, *USER SECTION, *VALUES AT INFINITY, *VIEWFACTOR
"""
"""CrunchiX User's Manual, Input deck format: the keywords that may stand before the first *STEP."""


@each("manual", [ABAQUS_NODES, CALCULIX])
def test_the_lists_know_the_cards_of_the_manuals(manual):
    listed = {" ".join(card.split()).strip("*") for card in manual.split(",")}
    assert listed - MODEL_CARDS.known == set()


def test_each_card_is_on_one_list():
    lists = (MODEL_CARDS.obeyed, MODEL_CARDS.harmless, MODEL_CARDS.refused.keys(), MODEL_CARDS.noted.keys())
    assert sum(map(len, lists)) == len(MODEL_CARDS.known)
    assert MODEL_CARDS.obeyed - {"INCLUDE"} == READ.keys()


def test_the_turn_of_an_instance_is_no_translation(tmp_path):
    turned = BLADE + "*INSTANCE, NAME=P-1, PART=BLADE\n0., 0., 0., 0., 0., 1., 90.\n*END INSTANCE\n*END ASSEMBLY\n"
    with pytest.raises(InputError, match=r"\*INSTANCE must be placed by a translation, and a line of two points and an angle"):
        deck(tmp_path, turned)
