"""Interference diagram: which nodal diameter an engine order excites, and how near a mode is."""

import numpy as np
import pytest

import stickslip as ss

DISK = ss.rigs.lumped_blisk("W", sectors=6, engine_order=2)


def excited_by(order: int, sectors: int) -> int:
    """The nodal diameter that a pressure pattern cos(EO φ) excites, by the Fourier transform of its samples at blades."""
    pattern = np.cos(2.0 * np.pi * order * np.arange(sectors) / sectors)
    return int(np.argmax(np.abs(np.fft.rfft(pattern))))


def test_engine_orders_excite_the_nodal_diameters_of_their_patterns():
    found = ss.interference_diagram(DISK, 3000.0).dataset
    assert found["engine_order"].values.tolist() == [1, 2, 3, 4, 5, 6]
    assert found["excited_diameter"].values.tolist() == [excited_by(order, 6) for order in range(1, 7)]
    assert found["wave"].values.tolist() == ["backward", "backward", "standing", "forward", "forward", "standing"]
    np.testing.assert_allclose(found["excitation_frequency"], 50.0 * np.arange(1, 7), rtol=1e-14)


def test_waves_are_those_of_blades_that_pass_a_pattern_at_rest():
    """Blade j, counted with the rotation, sees cos(EO (Ωt + 2πj/N)): it leads its predecessor, so the wave runs backward."""
    for order, wave in zip(range(1, 14), ss.interference_diagram(DISK, 1000.0, range(1, 14)).dataset["wave"].values, strict=True):
        lead = np.angle(np.exp(2j * np.pi * order / 6))
        standing = abs(np.sin(lead)) < 1e-9
        assert wave == ("standing" if standing else "backward" if lead > 0.0 else "forward")


def test_margins_are_those_of_the_nearest_mode_and_vanish_at_resonance():
    stuck = float(DISK.with_engine_order(2).frequencies(stuck=True)[0])
    found = ss.interference_diagram(DISK, 60.0 * stuck / 4.0, [4], modes=3)  # engine order 4 of 6 excites diameter 2
    one = found.dataset.sel(disk_state="stuck", engine_order=4)
    assert float(one["disk_margin"]) == pytest.approx(0.0, abs=1e-9)
    assert int(one["nearest_mode"]) == 1
    free = found.dataset["disk_frequency"].sel(disk_state="free").values[2] / stuck - 1.0
    expected = free[np.nanargmin(np.abs(free))]
    assert float(found.dataset["disk_margin"].sel(disk_state="free", engine_order=4)) == pytest.approx(expected, rel=1e-9)
    assert len(found.table()) == 2


def test_models_by_speed_are_taken_at_the_speed():
    faster = DISK.with_structure(DISK.structure)
    found = ss.interference_diagram({0.0: DISK, 3000.0: faster}, 1500.0, [1])
    np.testing.assert_allclose(found.dataset["disk_frequency"], ss.nodal_diameters(DISK).dataset["disk_frequency"], rtol=1e-12)


def test_the_line_of_excitation_folds_at_no_and_half_the_sectors(tmp_path):
    chart = ss.interference_diagram(DISK, 3000.0, [1, 2, 7]).plot()
    assert chart is not None
    lines = [layer for layer in _layers(DISK, 7) if getattr(layer, "label", "").startswith("excitation")]
    np.testing.assert_allclose(lines[0].x, [0.0, 3.0, 0.0, 1.0])
    np.testing.assert_allclose(lines[0].y, [0.0, 150.0, 300.0, 350.0])


def _layers(disk, highest):
    from stickslip.show.plots.speed_sweep import interference

    return interference(ss.interference_diagram(disk, 3000.0, [1, highest]).dataset).panels[0].layers


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((DISK, 0.0), "speed must be positive"),
        ((DISK, 100.0, []), "at least one"),
        ((DISK, 100.0, [0]), "engine_orders"),
        ((DISK, 100.0, [1, 1]), "engine_orders"),
        ((ss.rigs.single_mass(), 100.0), "models must be problems by speed"),
        ((lambda speed: ss.rigs.single_mass(), 100.0), "disk must be a TunedDisk"),
    ],
)
def test_wrong_input_is_refused(arguments, words):
    with pytest.raises(ss.InputError, match=words):
        ss.interference_diagram(*arguments)
