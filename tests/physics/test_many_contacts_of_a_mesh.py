"""A meshed beam on a ground that it touches at many nodes, against a program of its own that knows all degrees of freedom.

The program is written here from the equations: receptance of the whole structure, sliders followed sample by sample through two
periods, Newton-Krylov of SciPy on the displacements of the contacts. It shares with stickslip the matrices alone.
"""

import numpy as np
import pytest
from scipy import linalg
from scipy.optimize import newton_krylov
from scipy.sparse.linalg import LinearOperator

import stickslip as ss
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.solid import box_mesh, solid

KT, KN, MU, PRELOAD, RATIO = 4e6, 6e6, 0.3, 400.0, 0.01
H, SAMPLES = 3, 512


@pytest.fixture(scope="module")
def problem():
    """A clamped beam of steel, 100 x 20 x 10 mm, the outer third of its underside on the ground: 62 nodes, 186 rows."""
    body = solid(box_mesh(np.linspace(0.0, 0.1, 13), np.linspace(0.0, 0.02, 4), np.linspace(0.0, 0.01, 2)))
    free = np.flatnonzero(body.points[:, 0] > 1e-9)
    rows = body.numbers[free].ravel()
    M, K = (matrix.toarray()[np.ix_(rows, rows)] for matrix in (body.M, body.K))
    nodes = {str(k): tuple(map(float, body.points[k])) for k in free}
    underside = tuple(name for name, (x, _, z) in nodes.items() if z < 1e-9 and x > 0.0583 - 1e-6)
    dofs = tuple(f"{name}.{axis}" for name in nodes for axis in "xyz")
    beam = Structure(M, K, dofs, damping=ss.ModalDamping(RATIO), nodes=nodes, sets={"pad": underside})
    pad = ss.NodeSurface.of(beam, "pad", (0.0, 0.0, -1.0))
    law = ss.Macroslip(kt=KT, mu=MU, kn=KN, preload=PRELOAD)
    contacts = ss.surface_contacts("pad", law, pad, tangent=(1.0, 0.0, 0.0), balanced=True)
    tip = max(nodes, key=lambda name: (nodes[name][0], nodes[name][2], -abs(nodes[name][1] - 0.01)))
    return ss.Problem(beam, contacts, (ss.Force(f"{tip}.y", 1.0),), (f"{tip}.y",))


class OwnProgram:
    """w = e − G f(w) at the contacts, G of the structure without contacts; sliders with the limit μN, N = max(p + kn w_n, 0)."""

    def __init__(self, problem):
        structure, pad = problem.structure, problem.structure.sets["pad"]
        self.rows = np.array([[structure.dofs.index(f"{node}.{axis}") for axis in "xyz"] for node in pad]).ravel()
        self.out = structure.dofs.index(problem.outputs[0])
        share = np.array([self._share(problem, node) for node in pad])
        self.kt, self.kn, self.preload = KT * share, KN * share, PRELOAD * share
        stiffness = np.column_stack([self.kt, self.kt, self.kn]).ravel()
        stuck = structure.K.copy()
        stuck[self.rows, self.rows] += stiffness
        squares, modes = linalg.eigh(stuck, structure.M)
        C = structure.M @ modes @ np.diag(2.0 * RATIO * np.sqrt(squares)) @ modes.T @ structure.M
        self.parts, self.stiffness = (structure.K, C, structure.M), stiffness

    @staticmethod
    def _share(problem, node):
        """The share of a node in the area, of its contact in the stiffness of all."""
        (own,) = [contact for contact in problem.contacts if any(name.split(".")[0] == node for name in contact.normal)]
        return own.elements.normal.stiffness.sum() / KN

    def receptances(self, omega):
        """Harmonic 0 to H of contact rows and output under contact rows, and of both under the load."""
        K, C, M = self.parts
        kept, pushed = np.append(self.rows, self.out), np.zeros((K.shape[0], self.rows.size + 1))
        pushed[self.rows, np.arange(self.rows.size)] = 1.0
        pushed[self.out, -1] = 1.0
        return [np.linalg.solve(K + 1j * h * omega * C - (h * omega) ** 2 * M, pushed)[kept] for h in range(H + 1)]

    def forces(self, w):
        """f (rows, H+1) of displacements w (rows, H+1): complex amplitudes, mean first."""
        t = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
        motion = np.real(w @ np.exp(1j * np.outer(np.arange(H + 1), t))).reshape(-1, 3, SAMPLES)
        normal = np.maximum(self.preload[:, None] + self.kn[:, None] * self.pressing * motion[:, 2], 0.0)
        limit, force = MU * normal, np.zeros((len(normal), 2))
        history = np.empty((len(normal), 3, SAMPLES))
        for k in range(-SAMPLES, SAMPLES):
            moved = motion[:, :2, k % SAMPLES] - motion[:, :2, (k - 1) % SAMPLES]
            bound = limit[:, k % SAMPLES, None]
            force = np.clip(force + self.kt[:, None] * moved, -bound, bound)
            history[:, :2, k % SAMPLES] = force
        history[:, 2] = self.pressing * (normal - self.preload[:, None])
        waves = np.fft.rfft(history.reshape(-1, SAMPLES), axis=1)[:, : H + 1] * 2.0 / SAMPLES
        waves[:, 0] *= 0.5
        return waves

    pressing = -1.0
    """The beam presses where it moves downwards."""

    def amplitude(self, hertz, force):
        """|X₁| of the output."""
        G = self.receptances(2.0 * np.pi * hertz)
        count = self.rows.size
        driven = np.zeros((count + 1, H + 1), dtype=complex)
        driven[:, 1] = force * G[1][:, -1]
        stuck = [np.linalg.inv(np.eye(count) + g[:count, :count] * self.stiffness) for g in G]

        def packed(x):
            return np.concatenate([x[:, 0].real, x[:, 1:].real.ravel(), x[:, 1:].imag.ravel()])

        def unpacked(x):
            real, imaginary = x[count:].reshape(2, count, H)
            return np.column_stack([x[:count].astype(complex), real + 1j * imaginary])

        def missed(x):
            w = unpacked(x)
            f = self.forces(w)
            return packed(w - driven[:count] + np.column_stack([G[h][:count, :count] @ f[:, h] for h in range(H + 1)]))

        def undone(x):
            r = unpacked(x)
            return packed(np.column_stack([stuck[h] @ r[:, h] for h in range(H + 1)]))

        start = packed(np.column_stack([stuck[h] @ driven[:count, h] for h in range(H + 1)]))
        size = start.size
        solved = newton_krylov(
            missed, start, method="lgmres", inner_M=LinearOperator((size, size), undone, dtype=float), f_tol=1e-12, maxiter=60
        )
        f = self.forces(unpacked(solved))
        return abs(driven[count, 1] - G[1][count, :count] @ f[:, 1])


@pytest.mark.slow
def test_peaks_are_those_of_a_program_on_all_degrees_of_freedom(problem):
    """All nodes stuck, and slipping up to 30 and 65 % of the period; with the error of the few coordinates that is reported."""
    own, levels = OwnProgram(problem), [1.0, 10.0, 80.0]
    data = ss.forced_response(problem, ss.hertz(1700.0, 2100.0), levels, harmonics=H, samples=512).dataset
    assert data.attrs["coordinates"] < 60 < problem.structure.size
    slip = data.share_slip.max(("point", "contact", "direction")).values
    assert slip[0] == 0.0 < slip[1] < slip[2]
    for case, level in enumerate(levels):
        highest, error = int(np.nanargmax(data.peak_amplitude.values[case, 0])), float(data.modal_error[case, 0])
        hertz, peak = (float(data[f"peak_{name}"][case, 0, highest]) for name in ("frequency", "amplitude"))
        assert own.amplitude(hertz, level) == pytest.approx(peak * (1.0 + error), rel=2e-4 if case else 1e-8)
    for beside in (0.99, 1.01):
        assert own.amplitude(beside * hertz, level) < peak
