"""The problem: structure, contacts, loads and outputs together, checked once, and the linear systems that its harmonics see.

Imports `structure`, `contact`, `loads` and `dampers`. Begin with `problem.py`.
"""

from stickslip.model.problem.problem import Problem as Problem
from stickslip.model.problem.problem import modal_damping_matrix as modal_damping_matrix
