"""Contact surfaces of meshes: node sets with areas and normals, and the contacts between two of them, a rigid body or the ground.

Laws, structures and dampers come from below; problems are made above. Imports `contact`, `structure` and below.
Begin with `surface_contacts` of `node_surface.py`, which holds the geometry, too.
"""
