"""A curve that no sweep meets, of a hardening oscillator with an absorber: found from its nonlinear mode, checked in time."""

import numpy as np

import stickslip as ss

m, k, c = 0.05, 0.0454, 0.0073  # kg, N/m, N s/m of the absorber, tuned to the oscillator of 1 kg and 1 N/m
structure = ss.Structure(
    M=np.diag([1.0, m]),
    K=np.array([[1.0 + k, -k], [-k, k]]),
    C=np.array([[0.0005 + c, -c], [-c, c]]),
    dofs=("1.x", "2.x"),
)
spring = ss.Contact("spring", ss.CubicSpring(1.0), (ss.between("1.x", "ground"),))  # N/m³
problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",), "Oscillator with an absorber")

swept = ss.forced_response(problem, ss.radians_per_second(0.7, 2.0), 0.038, samples=64)
mode = ss.nonlinear_modes(problem, 2, amplitude=(1e-2, 6.0), samples=64)
response = swept.with_isolated(mode).with_stability()

print(mode.peaks([0.038])[["frequency", "amplitude"]])  # three at one force level
print(response.peaks()[["frequency", "amplitude", "curve", "stability"]])
highest = response.dataset.peak_amplitude.values[:, 0, 0]
print(f"The sweep misses a peak {highest[1] / highest[0]:.2f} times as high.")

stable = np.flatnonzero(response.dataset.stability.values[1] == 1)
print(response.verify_in_time(1, int(stable[len(stable) // 2]), steps_per_period=500))
response.plot().savefig("isolated.png")
times_as_high = highest[1] / highest[0]
