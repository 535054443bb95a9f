"""Parameters of the law harness: every law sample, every start rule."""

import pytest
from each import each
from laws.samples import SAMPLES, SMOOTH_SAMPLES

from stickslip.model.contact.point import MeanTraction, SliderOffset, TractionRatio

STARTS = {
    "virgin": SliderOffset(),
    "offset": SliderOffset(-0.35),
    "far offset": SliderOffset(40.0),
    "ratio": TractionRatio(-0.6),
    "full ratio": TractionRatio(1.0),
    "mean": MeanTraction(0.1),
    "large mean": MeanTraction(-30.0),
}


@pytest.fixture(params=SAMPLES, ids=lambda sample: sample.name)
def sample(request):
    return request.param


@pytest.fixture(params=[*SAMPLES, *SMOOTH_SAMPLES], ids=lambda sample: sample.name)
def any_sample(request):
    """A sample of independent directions, of sliders or of a law with kernels of its own."""
    return request.param


@pytest.fixture(params=[s for s in (*SAMPLES, *SMOOTH_SAMPLES) if any(e.mu > 0.0 for e in s.elements)], ids=lambda s: s.name)
def any_rubbing(request):
    """The same with friction."""
    return request.param


@pytest.fixture(params=[s for s in SAMPLES if any(e.mu > 0.0 for e in s.elements)], ids=lambda sample: sample.name)
def rubbing(request):
    """A sample with friction."""
    return request.param


@pytest.fixture(params=[s for s in (*SAMPLES, *SMOOTH_SAMPLES) if s.law.has_normal], ids=lambda sample: sample.name)
def touching(request):
    """A sample with a normal direction."""
    return request.param


every_start = each("start", STARTS.values(), ids=STARTS)
"""A test of one start rule, `start`, made one of all of them."""
