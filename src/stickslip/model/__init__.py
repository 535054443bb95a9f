"""What vibrates: structures, contacts, dampers and loads, joined to a problem M q̈ + C q̇ + K q + F(q) = f(t).

`structure` (matrices, meshes, reductions), `contact` (laws and contact points), `loads.py`, `dampers` (rigid bodies of several
shapes), `interfaces` (surfaces in contact) and `readers` (models of other programs) are the parts; `problem` joins them, `disks`
repeats a sector, `rigs` has the papers' rigs ready-made. Nothing here solves anything. Imports `support`.
"""
