"""Results files: round trips, whole or not at all, and clear words about files that are not results."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from results.conftest import parts

from stickslip.results.files import SCHEMA, labelled, open_results, save
from stickslip.support.checks import Faults, InputError
from stickslip.support.files import replacing
from stickslip.support.outcome import Outcome


def test_round_trip_is_identical(any_dataset, tmp_path):
    path = save(any_dataset, tmp_path / "new folder" / "results.nc")
    xr.testing.assert_identical(any_dataset, open_results(path))


def test_round_trip_keeps_types_and_padding(dataset, tmp_path):
    opened = open_results(save(dataset, tmp_path / "results.nc"))
    assert opened.outcome.dtype == np.int8
    assert opened.contact.values.tolist() == ["C0 é", "C1 é"]
    assert opened.contact.dtype.kind == "U"
    assert opened.attrs["title"] == "Größe α"
    assert isinstance(opened.attrs["file_format"], int)
    assert np.isnan(opened.frequency[1, -1])
    assert opened.outcome[1, -1] == Outcome.EMPTY


def test_outcome_carries_its_meanings(dataset, tmp_path):
    attrs = open_results(save(dataset, tmp_path / "results.nc")).outcome.attrs
    assert attrs["flag_values"].tolist() == [int(outcome) for outcome in Outcome]
    assert attrs["flag_meanings"].split() == [outcome.name.lower() for outcome in Outcome]


def test_every_variable_has_units_and_long_name(dataset):
    assert all({"units", "long_name"} <= set(variable.attrs) for variable in dataset.variables.values())
    assert ["frequency", *dataset.data_vars] == [variable.name for variable in SCHEMA]  # frequency is a coordinate


def test_file_is_plain_hdf5_without_pickle(dataset, tmp_path):
    with h5py.File(save(dataset, tmp_path / "results.nc")) as file:
        assert file["contact_force"].compression == "gzip"
        assert file["contact_force"].fletcher32
        kinds = {item.dtype.kind if h5py.check_string_dtype(item.dtype) is None else "string" for item in file.values()}
    assert kinds <= {"f", "i", "string"}


def test_file_is_closed_after_opening(dataset, tmp_path):
    path = save(dataset, tmp_path / "results.nc")
    first = open_results(path)
    save(dataset.assign_attrs(title="second"), path)
    assert first.frequency[0, 0] == open_results(path).frequency[0, 0]
    assert open_results(path).attrs["title"] == "second"


def test_failed_write_leaves_the_old_file_and_no_other(dataset, tmp_path, monkeypatch):
    path = save(dataset, tmp_path / "results.nc")
    before = path.read_bytes()

    def half(temporary, content):
        temporary.write_text("half a file")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(OSError, match="No space"):
        save(dataset, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_interrupted_write_leaves_nothing(tmp_path):
    def interrupted():
        with replacing(tmp_path / "a.txt") as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


def test_missing_file_is_said(tmp_path):
    with pytest.raises(InputError, match=r"must exist.*nothing\.nc"):
        open_results(tmp_path / "nothing.nc")


def test_folder_is_no_file(tmp_path):
    with pytest.raises(InputError, match=r"must be readable.*results\.nc in it"):
        open_results(tmp_path)


@pytest.mark.parametrize("content", [b"", b"CDF\x01 an old NetCDF file", b"not a results file at all"])
def test_foreign_file_is_said(tmp_path, content):
    (tmp_path / "r.nc").write_bytes(content)
    with pytest.raises(InputError, match="must be NetCDF-4"):
        open_results(tmp_path / "r.nc")


@pytest.mark.parametrize("share", [0.001, 0.02, 0.3, 0.7, 0.999])
def test_truncated_file_is_said(dataset, tmp_path, share):
    path = save(dataset, tmp_path / "results.nc")
    content = path.read_bytes()
    path.write_bytes(content[: max(9, int(share * len(content)))])
    with pytest.raises(InputError, match="truncated or damaged"):
        open_results(path)


def test_flipped_bits_are_noticed(dataset, tmp_path):
    path = save(dataset, tmp_path / "results.nc")
    with h5py.File(path) as file:
        chunk = file["contact_force"].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 0xFF
    path.write_bytes(content)
    with pytest.raises(InputError, match="truncated or damaged"):
        open_results(path)


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore")
def test_single_bits_that_flip_change_no_number(dataset, tmp_path):
    """A file that is read has every number, name and attribute as it was written; 50 flips of seeded places."""
    path, other, random = save(dataset, tmp_path / "results.nc"), tmp_path / "flipped.nc", np.random.default_rng(4)
    content, whole = path.read_bytes(), open_results(path)
    refused = 0
    for place, bit in zip(random.integers(len(content), size=50), random.integers(8, size=50), strict=True):
        flipped = bytearray(content)
        flipped[place] ^= 1 << int(bit)
        other.write_bytes(flipped)
        try:
            assert open_results(other).identical(whole)
        except InputError:
            refused += 1
    assert refused > 15


def test_changed_values_and_attributes_are_named(dataset, tmp_path):
    path = save(dataset, tmp_path / "results.nc")
    with h5py.File(path, "r+") as file:
        file["force_level"][0] = 3.0
    with pytest.raises(InputError, match="must be as it was written, but the variable 'force_level' changed since"):
        open_results(path)
    with h5py.File(path, "r+") as file:
        file["force_level"][0] = 1.0
        file.attrs["harmonics"] = 7
    with pytest.raises(InputError, match="but the attributes changed since"):
        open_results(path)


def test_files_without_checksums_are_read(dataset, tmp_path):
    """Those of earlier versions."""
    path = save(dataset, tmp_path / "results.nc")
    with h5py.File(path, "r+") as file:
        for part in (file, *file.values()):
            part.attrs.pop("crc32", None)
    assert open_results(path).identical(dataset)


def test_file_of_another_program_is_said(tmp_path):
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "r.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="must carry the attribute file_format"):
        open_results(tmp_path / "r.nc")


@pytest.mark.parametrize(("found", "words"), [(2, "newer stickslip"), (0, "Run the study again"), ("1", "Run the study again")])
def test_other_file_format_is_said(dataset, tmp_path, found, words):
    path = tmp_path / "r.nc"
    dataset.assign_attrs(file_format=found).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(InputError, match=f"must be 1, but is {found!r}.*{words}"):
        open_results(path)


def test_all_faults_of_the_schema_are_said_at_once(dataset, tmp_path):
    broken = dataset.drop_vars(["rms", "loop_force"]).drop_attrs(deep=False).assign_attrs(file_format=1)
    broken["residual"] = broken.residual.transpose()
    broken.to_netcdf(tmp_path / "r.nc", engine="h5netcdf")
    with pytest.raises(Faults) as raised:
        open_results(tmp_path / "r.nc")
    text = str(raised.value)
    assert all(word in text for word in ("'rms'", "'loop_force'", "'title'", "'residual' must have dimensions"))


def test_saving_refuses_what_is_not_in_the_schema(dataset, tmp_path):
    with pytest.raises(InputError, match="'amplitude' must be there"):
        save(dataset.drop_vars("amplitude"), tmp_path / "r.nc")
    assert list(tmp_path.iterdir()) == []


def test_labelled_refuses_names_beside_the_schema_and_misses_those_in_it(variables_coords_attrs):
    variables, coords, attrs = variables_coords_attrs
    amplitude = variables.pop("amplitude")
    with pytest.raises(KeyError, match="'amplitude'"):
        labelled(variables, coords, attrs)
    with pytest.raises(KeyError, match="not in the schema: amplitudes"):
        labelled({**variables, "amplitudes": amplitude}, coords, attrs)


def test_labelled_refuses_axes_that_do_not_fit(variables_coords_attrs):
    variables, coords, attrs = variables_coords_attrs
    with pytest.raises(ValueError, match="conflicting sizes for dimension 'point'"):
        labelled({**variables, "rms": variables["rms"][:, :-1]}, coords, attrs)
    with pytest.raises(ValueError, match="residual"):
        labelled({**variables, "residual": variables["residual"][0]}, coords, attrs)


def test_labelled_refuses_missing_attributes(variables_coords_attrs):
    variables, coords, attrs = variables_coords_attrs
    with pytest.raises(Faults, match="'harmonics' must be there"):
        labelled(variables, coords, {key: value for key, value in attrs.items() if key != "harmonics"})


def test_a_long_axis_without_a_coordinate_is_read(tmp_path):
    """For its length the file holds something of that size without any values."""
    dataset = labelled(*parts(sample=4096))
    xr.testing.assert_identical(open_results(save(dataset, tmp_path / "results.nc")), dataset)


@pytest.mark.parametrize("compression", [None, "gzip"])
def test_a_file_that_claims_what_it_does_not_hold_is_refused_unread(dataset, tmp_path, compression):
    """A hundred gigabytes of fill values, of which the file holds none."""
    path = save(dataset, tmp_path / "results.nc")
    with h5py.File(path, "r+") as file:
        file.create_dataset("zeros", (10**5, 10**5), "f8", chunks=(1000, 1000), compression=compression)
    with pytest.raises(InputError, match=r"results\.nc: zeros, entries must fit into a file of 1 bytes, but is 10000000000"):
        open_results(path)
