"""Linear structures: mass, damping and stiffness matrices with named degrees of freedom, their modes, reduction and sectors.

Damping models, Craig-Bampton reduction and cyclic symmetry live here; contacts and loads do not. Imports only
`support`. Begin with `matrices.py` (`Structure`).
"""
