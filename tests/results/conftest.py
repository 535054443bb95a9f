"""Small datasets of random numbers that fit the schema."""

import numpy as np
import pytest

from stickslip.results.files import SCHEMA, labelled

SIZES = {"case": 2, "point": 60, "output": 1, "harmonic": 4, "part": 2, "contact": 2, "direction": 3, "peak": 3}
SIZES |= {"linear_point": 5, "sample": 8, "mode": 2}
ATTRS = {"title": "Größe α", "study": "[study]\ntitle = 'x'\n", "harmonics": 3, "samples": 8, "cpu_seconds": 0.25}


def parts(**sizes):
    """Variables, coordinates and attributes for `labelled`."""
    sizes = SIZES | sizes
    random = np.random.default_rng(0)

    def values(variable):
        shape = [sizes[dim] for dim in variable.dims]
        if variable.kind == "str":
            return np.array(["Reached the end.", "Stopped: naïve µ"][: shape[0]])
        return np.ones(shape) if variable.kind == "int8" else random.random(shape)

    variables = {variable.name: values(variable) for variable in SCHEMA}
    if variables["frequency"].size:
        variables["frequency"][1, -1] = np.nan
        variables["outcome"][1, -1] = 0
    coords = {"force_level": [1.0, 80.0], "output": ["10.x"], "direction": ["t1", "t2", "n"]}
    coords["contact"] = [f"C{index} é" for index in range(sizes["contact"])]
    return variables, coords, ATTRS


@pytest.fixture
def variables_coords_attrs():
    return parts()


@pytest.fixture
def dataset():
    return labelled(*parts())


@pytest.fixture(params=[{}, {"contact": 0}, {"peak": 0}, {"mode": 0}], ids=["whole", "no contacts", "no peaks", "no modes"])
def any_dataset(request):
    return labelled(*parts(**request.param))
