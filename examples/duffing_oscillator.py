"""Duffing's oscillator on a shaking base: a cubic spring bends the resonance until it folds; the closed form of one harmonic."""

from dataclasses import replace

import numpy as np

import stickslip as ss

k3, c, acceleration = 0.5, 0.04, 0.1  # N/m³, N s/m, m/s²
ground = ss.between("1.x", "ground")
structure = ss.Structure(M=np.eye(1), K=np.eye(1), dofs=("1.x",))
spring = ss.Contact("spring", ss.CubicSpring(k3), tangential=(ground,))
base = ss.BaseMotion({"1.x": 1.0}, acceleration)
problem = ss.Problem(structure, (spring,), (base,), outputs=("1.x",), dashpots=(ss.Dashpot(ground, c),))

response = ss.forced_response(problem, ss.radians_per_second(0.6, 2.0), harmonics=1)
peak = response.peaks()["amplitude"].max()

# (c⁴/4 + c² (1 + 3/4 k3 a² − c²/2)) a² = F² where a is largest
closed_form = np.sqrt(np.roots([0.75 * k3 * c**2, c**2 - 0.25 * c**4, -(acceleration**2)]).max())
print(f"Peak relative to the base {peak:.6f} m, closed form {closed_form:.6f} m")

# Its slope by the stiffness of the spring, at that very point: other branches of the curve pass its frequency.
stiffer = ss.Parameter(k3, lambda value: replace(problem, contacts=(spring.with_law(ss.CubicSpring(value)),)))
slope = response.sensitivity(0, response.peak_point(), {"k3": stiffer}).amplitude_slopes()["k3"][0]
print(f"A spring stiffer by 1 % lowers the peak by {-slope * k3 / peak:.3f} %")
print(f"Largest absolute amplitude: {float(response.absolute().amplitude.max()):.4f} m")
