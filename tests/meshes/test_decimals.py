"""Shortest decimals in bulk are the very text of Python's repr."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.meshes.formats.shortest_floats import shortest_texts

RNG = np.random.default_rng(11)
POWERS_OF_TEN = 10.0 ** np.arange(-12, 25)
NUMBERS = {
    "unit": RNG.random(50_000) * 2 - 1,
    "all sizes": RNG.normal(size=50_000) * 10.0 ** RNG.integers(-8, 19, 50_000),
    "few digits": np.round(RNG.normal(size=20_000) * 100, 3),
    "sixteen digits": np.round(RNG.random(20_000), 16),
    "whole": RNG.integers(-(10**6), 10**6, 20_000).astype(float),
    "large and whole": RNG.integers(0, 2**53, 20_000).astype(float),
    "quarters": RNG.integers(0, 2**53, 20_000) / 4.0,
    "from single precision": RNG.random(20_000).astype(np.float32).astype(float),
    "powers of two": 2.0 ** np.arange(-60, 80),
    "beside powers of ten": np.concatenate(
        [POWERS_OF_TEN, np.nextafter(POWERS_OF_TEN, 0), np.nextafter(POWERS_OF_TEN, np.inf)]
    ),
    "extremes": np.array([0.0, -0.0, 5e-324, 1.7976931348623157e308, 9999999999999998.0, 1e16]),
    "none": np.empty(0),
}


@pytest.mark.parametrize("name", NUMBERS)
def test_texts_are_those_of_repr(name):
    values = NUMBERS[name]
    assert shortest_texts(values) == [repr(value).encode() for value in values.tolist()]
