"""The figure of a time integration holds the histories of the last period."""

import numpy as np

from stickslip.analyses.time_response import time_response
from stickslip.model.rigs import three_mass_wedge
from stickslip.show.plots.time_response import widest_loops


def test_the_last_period_is_drawn():
    found = time_response(three_mass_wedge(), 222.0, steps_per_period=300, tolerance=1e-2, periods=40)
    figure = found.plot()
    outputs, contacts = figure.axes
    data = found.dataset
    drawn = {line.get_label(): line for line in outputs.lines}
    assert list(drawn) == list(data["output"].values)
    np.testing.assert_allclose(drawn["2.y"].get_ydata(), 1e6 * data["displacement"].sel(output="2.y"))
    rows = widest_loops(data)
    assert len(contacts.lines) == len(rows) > 0
    first = contacts.lines[0]
    np.testing.assert_allclose(first.get_ydata()[:-1], data["force_history"].values[rows[0]])
    assert (first.get_xdata()[0], first.get_ydata()[0]) == (first.get_xdata()[-1], first.get_ydata()[-1]), "loops are closed"
    assert "last of" in figure.get_suptitle()
