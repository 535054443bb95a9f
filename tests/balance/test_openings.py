"""Harmonics of a gap's force, integrated over its openings: against quadrature between the roots of the series."""

from __future__ import annotations

import numpy as np
import pytest
from laws.kernel import carried, evaluated
from laws.quadrature import normal_harmonics
from laws.samples import Element

from stickslip.model.contact.cubic import Gap
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import Contact, between
from stickslip.model.contact.protocol import HELD, SLIPPING
from stickslip.solve.balance.energy import cycle_work

H = 5


def stop(kn=3.0, gap=0.0, preload=0.0):
    return Contact("stop", Gap(kn=kn, gap=gap, preload=preload), (), between("1.z", "ground"))


def integrated(kn, gap, preload, w):
    return normal_harmonics(Element(kn=kn, gap=gap, preload=preload), w)


def motions(count, seed=1):
    rng = np.random.default_rng(seed)
    decay = np.repeat(1.0 / np.arange(1, H + 1), 2)
    return [np.concatenate([[rng.normal()], rng.normal(size=2 * H) * decay]) for _ in range(count)]


@pytest.mark.parametrize("samples", [22, 64, 512])
def test_forces_are_exact_whatever_the_samples(samples):
    for w in motions(20):
        expected = integrated(3.0, 0.2, 0.1, w)
        np.testing.assert_allclose(carried(stop(3.0, 0.2, 0.1), w[None], samples)[0], expected, atol=1e-12)


def test_several_elements_open_one_after_the_other():
    law = MicroslipArray((1.0, 1.0, 1.0), 0.3, (1.0, 2.0, 0.5), preload=(0.5, -0.4, 0.1))
    contact = Contact("pad", law, (between("1.x", "ground"),), between("1.z", "ground"))
    for w in motions(5, seed=2):
        expected = sum(integrated(k, 0.0, c, w) for k, c in ((1.0, 0.5), (2.0, -0.4), (0.5, 0.1)))
        np.testing.assert_allclose(carried(contact, np.array([w, w]), 64)[1], expected, atol=1e-12)


def test_the_derivative_is_that_of_the_force_and_symmetric():
    for w in motions(10, seed=3):
        own = evaluated(stop(), w[None], 64).own[0]
        steps = 1e-6 * np.eye(w.size)
        both = [[evaluated(stop(), (w + side * step)[None], 64).target[0] for side in (1, -1)] for step in steps]
        np.testing.assert_allclose(own, np.array([(a - b) / 2e-6 for a, b in both]).T, atol=1e-7)
        energy = np.concatenate([[2.0], np.ones(2 * H)])
        np.testing.assert_allclose(energy[:, None] * own, (energy[:, None] * own).T, atol=1e-14)


def test_normal_forces_do_no_work_whatever_the_samples():
    for w in motions(20, seed=4):
        assert abs(cycle_work(carried(stop(), w[None], 24)[0], w)) < 1e-12


PAD = Contact("pad", Macroslip(kt=1.0, mu=0.3, kn=3.0), (between("1.x", "ground"),), between("1.z", "ground"))


@pytest.mark.parametrize("contact", [stop(), PAD], ids=["stop", "pad"])
@pytest.mark.parametrize("depth", [1e-3, 1e-6, -1e-6])
def test_openings_and_closings_between_two_samples_are_seen(contact, depth):
    """Contact is lost, or made, for less than a step between two samples; the force grows from nothing, without a jump."""
    middle = 2.0 * np.pi * 6.5 / 32
    w = np.array([1.0 - depth, -np.cos(middle), -np.sin(middle), 0.0, 0.0])
    rows = len(contact.tangential) + 1
    for motion, closed in ((w, 3.0 * w), (-w, 0.0 * w)):
        found = evaluated(contact, np.tile(motion, (rows, 1)), 32)
        expected = integrated(3.0, 0.0, 0.0, motion) if depth > 0.0 else closed
        np.testing.assert_allclose(found.target[-1] + 3.0 * motion, expected, atol=1e-13)
    assert evaluated(contact, np.tile(w, (rows, 1)), 32).unknown[-1] == (SLIPPING if depth > 0.0 else HELD)


def test_a_contact_that_only_touches_keeps_its_spring():
    """The motion comes down to the level and goes up again."""
    w = np.array([1.0, 1.0, 0.0])
    np.testing.assert_allclose(carried(stop(), w[None], 16)[0], 3.0 * w, atol=1e-12)
    w[0] = -1.0
    np.testing.assert_allclose(carried(stop(), w[None], 16)[0], 0.0, atol=1e-12)
