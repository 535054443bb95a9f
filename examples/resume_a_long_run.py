"""A long computation that may be interrupted: every finished curve is kept on disk and given back to the next attempt."""

import stickslip as ss

chain = ss.rigs.chain(masses=6, sliders=(4, 5, 6), forced=3)
kept = ss.CheckpointFolder("unfinished")
band, levels = ss.radians_per_second(0.1, 0.5), [0.5, 1.0, 2.0]


def interrupt_after_two(fraction, text):
    if fraction > 0.7:
        raise KeyboardInterrupt


try:
    ss.forced_response(chain, band, levels, checkpoint=kept, progress=interrupt_after_two)
except KeyboardInterrupt:
    print(f"Interrupted with {len(kept)} of {len(levels)} curves finished.")

finished_before = len(kept)
response = ss.forced_response(chain, band, levels, checkpoint=kept)  # only the last curve is computed
whole = ss.forced_response(chain, band, levels)
equal = response.dataset.equals(whole.dataset)
print(f"Equal to an uninterrupted run: {equal}.")
