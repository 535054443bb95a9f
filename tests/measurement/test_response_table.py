"""Measured frequency responses from text files: titles, units, and what is refused."""

import numpy as np
import pytest

import stickslip as ss


def written(tmp_path, text):
    file = tmp_path / "level_2.csv"
    file.write_text(text)
    return file


def test_titles_and_units(tmp_path):
    text = "Phase [deg]; Force [mN]; Frequency [kHz]; Acceleration [g]\n-90;500;0,08;0,5\n-91;600;0,081;0,5\n-92;700;0,082;1\n"
    test = ss.read_measured_response(written(tmp_path, text), held="response", settings={"load": 2.0})
    assert test.name == "level_2"
    assert test.frequency == pytest.approx([80.0, 81.0, 82.0])
    assert test.force == pytest.approx([0.5, 0.6, 0.7])
    assert test.amplitude == pytest.approx([4.903325, 4.903325, 9.80665])
    assert test.phase == pytest.approx(np.radians([-90, -91, -92]))
    assert test.held == "response"
    assert test.per_force[0] == pytest.approx(-9.80665j)


def test_without_phase_and_with_a_force_that_is_known(tmp_path):
    test = ss.read_measured_response(written(tmp_path, "f,a\n80,1\n81,2\n82,1\n"), force=3.0, name="three")
    assert test.phase is None
    assert test.name == "three"
    assert test.per_force == pytest.approx([1 / 3, 2 / 3, 1 / 3])


def test_refused(tmp_path):
    with pytest.raises(ss.InputError, match="must name force"):
        ss.read_measured_response(written(tmp_path, "f,a\n80,1\n81,2\n82,1\n"))
    with pytest.raises(ss.InputError, match=r"The unit of force in level_2\.csv must be one of"):
        ss.read_measured_response(written(tmp_path, "f [Hz],a [m/s2],force [lbf]\n80,1,1\n81,2,1\n82,1,1\n"))
    with pytest.raises(ss.InputError, match="amplitude must be positive"):
        ss.read_measured_response(written(tmp_path, "f [Hz],a [m/s2],force [N]\n80,1,1\n81,-2,1\n82,1,1\n"))


def test_the_column_of_the_quantity_is_taken_in_a_unit_of_it(tmp_path):
    text = "frequency [Hz], acceleration [m/s2], displacement [um], force [N]\n" + "\n".join(
        f"{80 + k}, {10.0 + k}, {40.0 + k}, 2.0" for k in range(4)
    )
    path = written(tmp_path, text)
    assert ss.read_measured_response(path).amplitude[0] == 10.0
    assert ss.read_measured_response(path, quantity="displacement").amplitude[0] == pytest.approx(40e-6)
    only = written(tmp_path, "frequency [Hz], displacement [um], force [N]\n80, 1, 1\n81, 2, 1\n82, 1, 1\n")
    assert ss.read_measured_response(only).quantity == "displacement"
    assert ss.read_measured_response(only).amplitude[1] == pytest.approx(2e-6)
    with pytest.raises(ss.InputError, match="must name amplitude"):
        ss.read_measured_response(only, quantity="velocity")
    titled = written(tmp_path, "frequency [Hz], amplitude [mm], force [N]\n80, 1, 1\n81, 2, 1\n82, 1, 1\n")
    with pytest.raises(ss.InputError, match=r"unit of acceleration in .* must be one of m/s2"):
        ss.read_measured_response(titled)


def test_meganewtons_are_no_millinewtons(tmp_path):
    rows = "80, 1, 1\n81, 2, 1\n82, 1, 1\n"
    for unit, factor in (("MN", 1e6), ("mN", 1e-3), ("kn", 1e3)):
        path = written(tmp_path, f"frequency [Hz], acceleration [m/s2], force [{unit}]\n{rows}")
        assert ss.read_measured_response(path).force[0] == pytest.approx(factor)
