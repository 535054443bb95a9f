"""The sum and the moment of contact forces on a damper, independent of the rows of its contacts."""

import numpy as np


def wrench(damper, surface, forces):
    """Force and moment about the mass centre, (6,), of contact forces (points, 3) given along t1, t2, n on the damper."""
    place = damper.surface(surface)
    vectors = np.asarray(forces) @ np.asarray(place.frame)
    arms = np.asarray(place.points) - np.asarray(damper.body.centre)
    return np.concatenate([vectors.sum(axis=0), np.cross(arms, vectors).sum(axis=0)])
