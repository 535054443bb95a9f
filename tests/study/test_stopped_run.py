"""What Ctrl-C leaves of a forced response: a dataset with the curves that are complete and the points of that in work."""

import numpy as np
import pytest

from stickslip import study
from stickslip.results.files import open_results
from stickslip.show.report.answer import peaks_at_a_glance
from stickslip.study.run import Run
from stickslip.support.outcome import Outcome

STUDY = """
[study]
title = "One mass"
analysis = "forced_response"
[structure]
rig = "single_mass"
[sweep]
frequency = [0.08, 0.3]
force_levels = [0.4, 0.7, 1.4]
harmonics = 3
"""


def stopped(folder, share):
    """The results of a run that is stopped at a share of its work; a case is a third, of which sweeps take the first 0.15
    and the search for peaks what is left to a half."""

    def stop(fraction, text):
        if fraction > share:
            raise KeyboardInterrupt

    run = Run({"": study.job(STUDY, folder, "mass")}, folder / "out")
    kept = run.kept()
    with pytest.raises(KeyboardInterrupt):
        run.computed(kept, stop)
    return open_results(kept.folder / "results.nc"), len(kept)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run = Run({"": study.job(STUDY, folder, "mass")}, folder / "out")
    return run.computed(run.kept(), lambda fraction, text: None)[""]


def test_stopped_in_a_sweep(tmp_path, whole):
    found, kept = stopped(tmp_path, (1 + 0.5 * 0.15) / 3)
    assert kept == 1
    assert found["case_outcome"].values.tolist() == [Outcome.CONVERGED, Outcome.STOPPED, Outcome.STOPPED]
    assert float(found["peak_amplitude"][0, 0, 0]) == float(whole["peak_amplitude"][0, 0, 0])
    points = int(np.count_nonzero(found["outcome"][1] == Outcome.CONVERGED))
    assert 3 < points < int(np.count_nonzero(whole["outcome"][1] == Outcome.CONVERGED))
    assert found["frequency"].values[1, 0] == 0.08
    reached = found["frequency"].values[1, points - 1]
    assert 0.15 < reached < 0.25
    assert f"got to {reached:.6g} Hz" in str(found["case_message"].values[1])
    assert not np.any(found["outcome"][2])
    assert "not computed." in peaks_at_a_glance("a", found)


def test_stopped_in_the_search_for_peaks(tmp_path):
    """Every point of the sweep is there, and the largest stands for the peak."""
    found, kept = stopped(tmp_path, (1 + 0.3) / 3)
    assert kept == 1
    assert np.nanmax(found["frequency"].values[1]) == 0.3
    assert "not finished" in peaks_at_a_glance("a", found)


def test_nothing_is_saved_where_nothing_was_solved(tmp_path):
    run = Run({"": study.job(STUDY, tmp_path, "mass")}, tmp_path / "out")

    def stop(fraction, text):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run.computed(run.kept(), stop)
    assert not (tmp_path / "out").exists()
