"""Is a point of a curve right? Integrate it in time: the response of one mass on a slider, with 1, 3 and 21 harmonics."""

import stickslip as ss

rig = ss.rigs.single_mass(kt=1.0, limit=1.0, force=1.0)
frequency = 0.175  # Hz, near the resonance

for harmonics in (1, 3, 21):
    response = ss.forced_response(rig, [0.05, frequency], harmonics=harmonics, samples=1024)
    check = response.verify_in_time(case=0, point=1)
    print(check)

amplitude_in_time = check.time_amplitude[0]
energy = check.time.dataset
print(
    f"In time: {amplitude_in_time:.6f} m; a period takes in {energy.input_work:.4f} J and rubs away {energy.dissipated[0]:.4f} J."
)
check.time.plot().savefig("check_a_point_in_time.png")
