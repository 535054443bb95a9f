"""From the test rig to contact parameters: measured data and what they identify.

`measurement` reads and corrects records; `identification` fits models to them. Imports `analyses` and below.
"""
