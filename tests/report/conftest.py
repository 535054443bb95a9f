"""Datasets for figures and report: `synthetic` of one mass with two contacts."""

import pytest
from report.synthetic import synthetic


@pytest.fixture
def dataset():
    return synthetic()


@pytest.fixture
def dataset_with_failures():
    return synthetic(failed=((1, 40, 2), (1, 41, 2), (3, 100, 2), (3, 101, 3)))
