"""HDF5 files that would have other files of the machine read are refused, and nothing of these is shown."""

import h5py
import numpy as np
import pytest
from results.conftest import parts

from stickslip.laboratory.measurement.number_table import matlab_tables
from stickslip.model.readers.read import read_model
from stickslip.results.files import labelled, open_results, save
from stickslip.support.checks import InputError

SECRET = b"root:x:0:0:secret"


def external_link(group, name, folder):
    group[name] = h5py.ExternalLink(str(folder / "other.h5"), "secret")


def soft_link_through_an_external_one(group, name, folder):
    group[f"{name}_door"] = h5py.ExternalLink(str(folder / "other.h5"), "/")
    group[name] = h5py.SoftLink(f"{group.name.rstrip('/')}/{name}_door/secret")


def external_storage(group, name, folder):
    group.create_dataset(name, (len(SECRET), 1), np.uint8, external=[(str(folder / "secret"), 0, len(SECRET))])


def virtual_dataset(group, name, folder):
    layout = h5py.VirtualLayout((len(SECRET), 1), np.uint8)
    layout[...] = h5py.VirtualSource(str(folder / "other.h5"), "secret", layout.shape)
    group.create_virtual_dataset(name, layout)


TRICKS = {
    "an external link": external_link,
    "an external link, by a soft one": soft_link_through_an_external_one,
    "external storage": external_storage,
    "a virtual dataset": virtual_dataset,
}
tricks = pytest.mark.parametrize(("said", "trick"), TRICKS.items(), ids=TRICKS)


@pytest.fixture
def others(tmp_path):
    """Files of the machine that are not to be read."""
    (tmp_path / "secret").write_bytes(SECRET)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["secret"] = np.frombuffer(SECRET, np.uint8)[:, None]
    return tmp_path


def refusal(read, path, said):
    with pytest.raises(InputError) as caught:
        read(path)
    message = str(caught.value)
    assert f"must be stored in its own file, but is '{said.partition(',')[0]}'. No file but the one that is named" in message
    assert path.name in message
    assert "root:x" not in message
    return message


@tricks
@pytest.mark.parametrize("place", ["/", "/deep/in/groups", "/#refs#"])
def test_a_model(chain, others, said, trick, place):
    path = chain.save(others, "mat73")
    with h5py.File(path, "r+") as file:
        trick(file.require_group(place), "door", others)
    assert f"{place.strip('/')}/door".strip("/") in refusal(read_model, path, said)


@tricks
@pytest.mark.parametrize("name", ["M", "dofs", "K/data"])
def test_a_part_of_a_model_that_is_read(chain, others, said, trick, name):
    path = chain.save(others, "mat73")
    with h5py.File(path, "r+") as file:
        group, _, last = name.rpartition("/")
        del file[name]
        trick(file[group or "/"], last, others)
    refusal(read_model, path, said)


@pytest.mark.parametrize("said", ["external storage", "a virtual dataset"])
def test_a_name_that_only_a_reference_leads_to(chain, others, said):
    """The group of a cell array says that it is empty: no link leads to the cell, a reference does."""
    path = chain.save(others, "mat73")
    with h5py.File(path, "r+") as file:
        TRICKS[said](file.create_group("hidden"), "door", others)
        del file["dofs"]
        file["dofs"] = np.array([[file["hidden/door"].ref] * 6], dtype=h5py.ref_dtype).T
    content = path.read_bytes()
    node = content.rindex(b"SNOD\x01\0\x01\0")
    path.write_bytes(content[: node + 6] + b"\0\0" + content[node + 8 :])
    with h5py.File(path) as file:
        assert list(file["hidden"]) == []
    refusal(read_model, path, said)


@tricks
def test_a_table_of_numbers(chain, others, said, trick):
    path = chain.save(others, "mat73")
    with h5py.File(path, "r+") as file:
        trick(file, "hyst", others)
    refusal(lambda path: matlab_tables([path]), path, said)


@tricks
@pytest.mark.parametrize("place", ["/", "/deep/in/groups"])
def test_results(others, said, trick, place):
    path = save(labelled(*parts()), others / "results.nc")
    with h5py.File(path, "r+") as file:
        trick(file.require_group(place), "door", others)
    refusal(open_results, path, said)


@tricks
def test_a_variable_of_results(others, said, trick):
    path = save(labelled(*parts()), others / "results.nc")
    with h5py.File(path, "r+") as file:
        del file["response"]
        trick(file, "response", others)
    refusal(open_results, path, said)


def test_links_within_a_file_are_followed(chain, tmp_path):
    path = chain.save(tmp_path, "mat73")
    with h5py.File(path, "r+") as file:
        file["kept"] = file["M"]
        file["deep/loop"] = file["/"]
        del file["M"]
        file["M"] = h5py.SoftLink("/kept")
    np.testing.assert_array_equal(read_model(path).M.toarray(), chain.M)
