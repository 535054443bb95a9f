"""The curve of a whole disk whose sectors all vibrate alike: their contacts change state at the same place of the curve."""

import numpy as np
import pytest

import stickslip as ss


@pytest.mark.parametrize("band", [(120.0, 160.0), (200.0, 100.0)])
def test_a_kink_of_all_sectors_at_once_is_no_fold(band):
    """The determinant of the whole disk changes its sign there, that of the sector does not: both curves go on."""
    disk = ss.rigs.lumped_blisk("W", engine_order=2, sectors=6)
    tuned, whole = (
        ss.forced_response(problem, ss.hertz(*band), force=40.0, harmonics=3, samples=96) for problem in (disk, disk.full([1]))
    )
    assert str(whole.dataset.case_message.values[0]).startswith("The curve reached the end of the band.")
    assert whole.dataset.sizes["point"] < 200
    np.testing.assert_allclose(whole.peaks().amplitude[0], tuned.peaks().amplitude[0], rtol=1e-6)
