"""Running independent cases: what an analysis states as its work, the loop over its cases, and where they are computed.

This process, several of this machine or a Dask cluster; completed cases are kept in a checkpoint. Imports nothing of the
mechanics. Begin with `cases.py`: the interfaces, the checkpoint and the loop.
"""
