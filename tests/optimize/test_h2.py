"""The metric that measures bending."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.optimize.metrics.h1 import H1
from ffdstudio.optimize.metrics.h2 import H2
from ffdstudio.optimize.variables.metrics import Surface


def test_the_bending_of_a_curve_is_its_integral():
    x = np.linspace(0, 1, 2001)
    surface = Surface.curve(np.column_stack([x, 0 * x, 0 * x]))
    f = np.sin(np.pi * x) ** 3  # no slope at the ends
    own = np.sum((H2().factor(surface) @ f) ** 2) - np.sum((H1().factor(surface) @ f) ** 2)
    second = np.gradient(np.gradient(f, x), x)
    assert own == pytest.approx(np.trapezoid(second**2, x), rel=1e-2)
