"""What each law declares of itself is true: rate independence, sticking, memory of the start, coupling of directions."""

from dataclasses import replace

import numpy as np
import pytest
from each import each
from laws.kernel import OMEGA, answer, forces, random_motion
from laws.samples import every_law, samples_of

from stickslip.model.contact.point import Contact, SliderOffset, TractionRatio, between, contact_table
from stickslip.model.contact.protocol import SLIPPING, kind_of
from stickslip.model.contact.valanis import Valanis
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import InputError

H, NT = 3, 64
LAWS = every_law()
VIRGIN = SliderOffset()
STARTS = (VIRGIN, SliderOffset(0.05), TractionRatio(0.4))


def rubbing(law):
    """The samples of a law along tangential directions, those without any friction left out."""
    found = [s for s in samples_of(law) if s.tangential]
    return [s for s in found if not s.elements or any(e.mu > 0.0 for e in s.elements)]


def moved(sample, size, seed=5):
    """Motion (rows, 2H+1) with the contact pressed on all the time."""
    w = random_motion(sample, H, np.random.default_rng(seed), size)
    if sample.law.has_normal:
        w[-1] *= 0.1
        w[-1, 0] = 2.0
    return w


@each("law", LAWS, ids=lambda law: law.__name__)
def test_rate_independence(law):
    """The same path passed faster: the same forces to the last bit, or others."""
    for sample in samples_of(law):
        w = moved(sample, 1.0)
        slow, fast = (answer(sample, VIRGIN, w, NT, omega) for omega in (OMEGA, 3.0 * OMEGA))
        if law.rate_independent:
            np.testing.assert_array_equal(slow.target, fast.target)
            assert not slow.by_omega.any()
        else:
            assert np.abs(fast.target - slow.target).max() > 1e-2 * np.abs(slow.target).max()
            assert slow.by_omega.any()


@each("law", LAWS, ids=lambda law: law.__name__)
def test_sticking(law):
    """A small motion: λ̂ of no harmonic but the mean and a loop without energy, or every harmonic unknown."""
    for sample in rubbing(law):
        w = moved(sample, 1e-3)
        found, rows = answer(sample, VIRGIN, w, NT), slice(0, sample.tangential)
        work = cycle_work(found.target, w)[rows]
        if law.sticks:
            assert np.all(found.unknown[rows] < SLIPPING)
            assert not found.target[rows, 1:].any()
        else:
            assert np.all(found.unknown[rows] == SLIPPING)
            assert found.target[rows, 1:].any()
        assert np.all(work == 0.0) if law.sticks else np.all(work > -1e-15)
    assert not law.sticks or rubbing(law), f"{law.__name__} has no tangential direction to stick along"


@each("law", LAWS, ids=lambda law: law.__name__)
def test_memory_of_the_start(law):
    """A small motion from several starts: different means, or the same forces to the last bit, as without friction."""
    remembers = []
    for sample in rubbing(law):
        w = moved(sample, 1e-3)
        found = [forces(sample, start, w, NT)[: sample.tangential] for start in STARTS]
        remembers.append(all(np.abs(other - found[0]).max() > 1e-3 for other in found[1:]))
        if not law.remembers_start:
            for other in found[1:]:
                np.testing.assert_array_equal(other, found[0])
    assert all(remembers) if remembers and law.remembers_start else not any(remembers)
    assert remembers or not law.remembers_start


@each("law", LAWS, ids=lambda law: law.__name__)
def test_coupling_of_directions(law):
    """A motion along t2 changes the force along t1, or does not."""
    plane = [sample for sample in rubbing(law) if sample.tangential == 2]
    assert plane or not law.couples_directions
    for sample in plane:
        w = moved(sample, 2.0)
        other = w.copy()
        other[1] *= 0.5
        found = [forces(sample, VIRGIN, each, NT)[0] for each in (w, other)]
        assert np.array_equal(*found) != law.couples_directions


def test_every_law_of_its_own_kernels_has_its_own_kind():
    kinds = [kind_of(law) for law in LAWS if law.kernels()]
    assert len(set(kinds)) == len(kinds)


def test_a_law_that_sticks_must_bring_its_period():
    """A march from rest would find one of its steady forces only."""

    class Sticking(Valanis):
        sticks = True

    with pytest.raises(InputError, match="Sticking must bring a kernel for its period, or declare sticks = False"):
        contact_table([Contact("c", Sticking(1.0, 0.5, 0.3, normal_load=1.0), (between("1.x", "ground"),))])


@each("law", LAWS, ids=lambda law: law.__name__)
def test_every_parameter_has_a_scale(law):
    """`sensitivity` steps each of a law's own parameters by a share of its scale."""
    for sample in samples_of(law):
        scales = sample.law.parameter_scales(2.0, 1e-3)
        assert scales.shape == (len(sample.law.elements(sample.tangential, sample.law.has_normal).parameters),)
        assert np.all(scales > 0.0)


@each("law", LAWS, ids=lambda law: law.__name__)
def test_shares_of_a_surface_add_up_to_the_whole(law):
    """Points that move alike, of 30 % and 70 %: each has its share of every force."""
    for sample in samples_of(law):
        w = moved(sample, 1.0)
        whole = answer(sample, VIRGIN, w, NT).target
        for share in (0.3, 0.7):
            part = answer(replace(sample, law=sample.law.share(share)), VIRGIN, w, NT).target
            np.testing.assert_allclose(part, share * whole, rtol=1e-9, atol=1e-9 * np.abs(whole).max(initial=1.0))
