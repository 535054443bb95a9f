"""How much higher than on a tuned disk is the worst blade of a mistuned one? Dampers, 0.3 % scatter of the blade frequencies."""

import stickslip as ss

disk = ss.rigs.lumped_blisk("W")
band = ss.hertz(140, 156)
population = ss.mistuned_population(disk, band, 2, ss.Scatter(blade=0.003), force=0.4, harmonics=3, samples=96, seed=1)

for sample in range(2):
    one = population.dataset.isel(sample=sample)
    print(f"disk {sample + 1}: amplification {float(one.amplification):.3f}, blade {int(one.worst_blade)}")

population.plot().savefig("all_blades.png")
population.plot(figure="worst_blade").savefig("worst_blade.png")

amplification = float(population.dataset.amplification[0])
