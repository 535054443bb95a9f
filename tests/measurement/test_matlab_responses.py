"""Responses in MATLAB files: vectors beside each other and in structs, evenly spaced frequencies, columns of matrices."""

import numpy as np
import pytest
from scipy import io

import stickslip as ss

FREQUENCY = np.linspace(10.0, 20.0, 51)
RECEPTANCE = 1.0 / (15.0**2 - FREQUENCY**2 + 0.6j * FREQUENCY) / (2.0 * np.pi) ** 2
ACCELERANCE = -((2.0 * np.pi * FREQUENCY) ** 2) * RECEPTANCE


def of_testlab(values, label="(m/s^2)/N", factor=1.0):
    """A struct as Simcenter Testlab writes it."""
    quantity = {"label": label, "unit_transformation": {"factor": factor, "offset": 0.0}}
    x = {"start_value": 10.0, "increment": 0.2, "number_of_values": 51.0, "quantity": {"label": "Hz"}}
    return {"x_values": x, "y_values": {"values": values[:, None], "quantity": quantity}, "function_record": {"name": "H1"}}


def saved(tmp_path, **variables):
    io.savemat(tmp_path / "test.mat", variables)
    return tmp_path / "test.mat"


def test_a_struct_of_testlab(tmp_path):
    test = ss.read_measured_response(saved(tmp_path, FRF=of_testlab(ACCELERANCE)), force=2.0)
    assert test.frequency == pytest.approx(FREQUENCY)
    assert test.per_force == pytest.approx((2.0 * np.pi * FREQUENCY) ** 2 * RECEPTANCE)
    assert not any(unit.assumed for unit in test.units.values())
    in_g = saved(tmp_path, FRF=of_testlab(ACCELERANCE, "g/N", 9.80665))
    scaled = ss.read_measured_response(in_g, force=2.0)
    assert [key for key, unit in scaled.units.items() if unit.assumed] == ["acceleration"]  # it may be that of the values, or not
    stated = ss.read_measured_response(in_g, force=2.0, units={"amplitude": "g/N"})
    assert stated.per_force == pytest.approx(9.80665 * test.per_force)


def test_one_of_several_structs_is_chosen(tmp_path):
    path = saved(tmp_path, Signal_0=of_testlab(ACCELERANCE), Signal_1=of_testlab(3.0 * ACCELERANCE), comment="a run")
    with pytest.raises(ss.InputError) as raised:
        ss.read_measured_response(path, force=2.0)
    for said in (
        "The vectors of test.mat must be those of one response, of one length",
        "Signal_0.y_values.values (51), Signal_1.y_values.values (51), Signal_0.x_values (51)",
        "(--column 'amplitude=Signal_0.y_values.values')",
    ):
        assert said in str(raised.value)
    assert "hyst" not in str(raised.value)
    for name in ("Signal_1.y_values.values", "Signal_1"):
        test = ss.read_measured_response(path, force=2.0, columns={"amplitude": name}, quantity="acceleration")
        assert test.per_force == pytest.approx(3.0 * (2.0 * np.pi * FREQUENCY) ** 2 * RECEPTANCE)
    with pytest.raises(ss.InputError, match=r"must be one of the file, but is 'Signal_2'\. Did you mean 'Signal"):
        ss.read_measured_response(path, force=2.0, columns={"amplitude": "Signal_2"})


def test_structs_of_scripts(tmp_path):
    struct = {"f_Hz": FREQUENCY, "accelerance": ACCELERANCE, "name": "H1", "coherence": np.ones(51)}
    test = ss.read_measured_response(saved(tmp_path, run=struct), force=2.0)
    assert test.per_force == pytest.approx((2.0 * np.pi * FREQUENCY) ** 2 * RECEPTANCE)
    assert any("not used: coherence" in note for note in test.notes)
    both = saved(tmp_path, a={"f": FREQUENCY, "H": RECEPTANCE}, b={"f": FREQUENCY, "H": 2.0 * RECEPTANCE})
    test = ss.read_measured_response(both, force=2.0, columns={"amplitude": "b.H"}, units={"amplitude": "m/N"})
    assert test.per_force == pytest.approx(2.0 * RECEPTANCE)


def test_a_column_of_a_matrix_beside_a_vector_of_another_length(tmp_path):
    path = saved(tmp_path, freq=FREQUENCY, H=np.stack([RECEPTANCE, 2.0 * RECEPTANCE], axis=1), window=np.ones(128))
    test = ss.read_measured_response(path, force=1.0, columns={"amplitude": "H(:,2)"}, units={"amplitude": "m/N"})
    assert test.per_force == pytest.approx(2.0 * RECEPTANCE)
    with pytest.raises(ss.InputError, match="must name real once"):
        ss.read_measured_response(path, force=1.0)
    with pytest.raises(ss.InputError, match="must have one length"):
        ss.read_measured_response(path, force=1.0, columns={"amplitude": "window", "frequency": "freq"})


def test_files_without_a_response(tmp_path):
    for variables in (
        {"note": "empty"},
        {"a": np.ones((2, 2))},
        {"f": FREQUENCY},
        {"x_values": {"start_value": 1.0, "increment": 1.0, "number_of_values": 1e15}},
    ):
        with pytest.raises(ss.InputError, match="must be those of one response"):
            ss.read_measured_response(saved(tmp_path, **variables), force=1.0)


def test_a_struct_of_version_7_3(tmp_path):
    """Groups of HDF5, with texts as numbers."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "test.mat", "w", userblock_size=512) as file:
        for key, value in (("start_value", 10.0), ("increment", 0.2), ("number_of_values", 51.0)):
            file[f"FRF/x_values/{key}"] = np.array([[value]])
        file["FRF/x_values/quantity/label"] = np.array([[ord(c)] for c in "Hz"], dtype=np.uint16)
        stored = np.zeros((1, 51), dtype=[("real", "f8"), ("imag", "f8")])
        stored["real"], stored["imag"] = ACCELERANCE.real, ACCELERANCE.imag
        file["FRF/y_values/values"] = stored
        file["FRF/y_values/quantity/label"] = np.array([[ord(c)] for c in "(m/s^2)/N"], dtype=np.uint16)
    test = ss.read_measured_response(tmp_path / "test.mat", force=2.0)
    assert test.per_force == pytest.approx((2.0 * np.pi * FREQUENCY) ** 2 * RECEPTANCE)
    assert not any(unit.assumed for unit in test.units.values())
