"""The .full file that ansys-mapdl-reader ships: a clamped beam, against the frequencies that its documentation prints.

Needs the extra `ansys` (pip install "stickslip[ansys]"); without it, only the refusal is tested.
"""

from pathlib import Path

import pytest

import stickslip as ss
from stickslip.model.readers.ansys import installed
from stickslip.model.readers.model import describe
from stickslip.support.checks import InputError

needs_reader = pytest.mark.skipif(not installed(), reason='needs ansys-mapdl-reader: pip install "stickslip[ansys]"')


@needs_reader
@pytest.mark.filterwarnings("ignore")
def test_frequencies_of_the_shipped_example():
    from ansys.mapdl.reader import examples

    found = describe(ss.read_model(examples.fullfile))
    assert [f"{value:.3f}" for value in found.modes.frequencies[:4]] == ["1283.200", "1283.200", "5781.975", "6919.399"]
    assert found.model.size == 900
    assert found.odd == ("63 constrained rows of the file are left out.",)


@needs_reader
@pytest.mark.filterwarnings("ignore")
def test_another_file_of_ansys_is_refused(tmp_path):
    from ansys.mapdl.reader import examples

    path = tmp_path / "result.full"
    path.write_bytes(Path(examples.rstfile).read_bytes())
    with pytest.raises(InputError, match=r"result\.full"):
        ss.read_model(path)


@pytest.mark.skipif(installed(), reason="the reader is installed")
def test_without_the_reader_the_remedy_is_said(tmp_path):
    (tmp_path / "a.full").write_bytes(b"x")
    with pytest.raises(InputError, match=r"must have their reader, but is 'not installed'.*stickslip\[ansys\]"):
        ss.read_model(tmp_path / "a.full")
