"""The highest and lowest response of a wedge over all states of its contacts, what they do there, and a law of the states.

Writes the figures that the documentation shows.
"""

import numpy as np
from scipy import stats

import stickslip as ss

wedge = ss.rigs.three_mass_wedge()
frequencies = np.linspace(204.0, 234.0, 11)

bounds = ss.response_bounds(wedge, frequencies)
low, high = bounds.dataset["amplitude"].sel(frequency=222.0).values[0]
print(f"At 222 Hz the amplitude may be anything from {1e6 * low:.2f} to {1e6 * high:.2f} µm, all inputs alike.")
bounds.plot().savefig("bounds.svg")

# What the contacts do at both bounds, with other start states in grey: one side slips, the other sticks at any mean force.
samples = ss.response_samples(wedge, [222.0], starts=30)
bounds.plot(figure="contact_forces", frequency=222.0, samples=samples.dataset).savefig("bounds_forces.svg")
bounds.plot(figure="loops", frequency=222.0, samples=samples.dataset).savefig("bounds_loops.svg")

# When start states in the middle are likelier than those at the ends: percentiles follow from the law.
law = stats.beta(2.0, 2.0)
drawn = ss.response_samples(wedge, frequencies, starts=60, distribution=law, rule="traction_ratio")
drawn.plot(figure="percentiles").savefig("percentiles.svg")
tenth = drawn.percentiles([90.0]).sel(frequency=222.0, percent=90.0).item()
print(f"Of such start states, one in ten exceeds {1e6 * tenth:.1f} µm at 222 Hz.")

ratio = high / low
