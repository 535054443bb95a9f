"""What tests identify: contact laws from loops, contact parameters from cycles of a damper, any parameters from responses.

Each fits a computed answer to a measured one by least squares and judges the fit. Imports `measurement`, `analyses` and below.
Begin with `contact_law.py`, then `identify.py` and `identify_response.py`.
"""
