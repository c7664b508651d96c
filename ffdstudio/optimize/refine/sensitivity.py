"""What an indicator knows of the cost: derivatives along functions on the surface.

1. `along` gives derivatives of the cost by functions, `measure` maps functions to where their
   inner products are those of the metric, `frame` is the present space there.
2. The metric is L2 or H1 of the surface. A cost with residuals brings a better one: with the
   Gauss-Newton Hessian a gain is the decrease of the linearised least squares.
3. `wanted` is the displacement that the metric's Newton step asks for, measured: relocation of
   knots brings the space as near to it as it can.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.variables.level import Level
from ffdstudio.optimize.variables.metrics import Whitening

LEAST = 1e-14  # of the largest entry: keeps the metric regular, and is below its rounding


class Sensitivity(Protocol):
    """See the module."""

    frame: Array
    framed: Array

    @property
    def surface(self) -> Array:
        """(n * coordinates,) gradient; raises `InputError` if there is none."""
        ...

    def along(self, functions: Array) -> Array:
        """(k,) derivatives along (n * coordinates, k) functions."""
        ...

    def measure(self, functions: Array) -> Array:
        """(m, k) functions in the metric."""
        ...

    def wanted(self, displacement: Array) -> Array:
        """(m,) measured displacement that the cost asks for, from the present one."""
        ...


class Adjoint:
    """From the (n, 3) gradient by the points; measured in the metric of the level."""

    def __init__(self, level: Level, gradient: Array) -> None:
        self.surface = level.flat(gradient)
        self.factor, self._strained = level.factor, level.body.surface.strain is not None
        self.frame, self.framed = level.white.frame, level.framed

    def along(self, functions: Array) -> Array:
        """Inner products with the gradient."""
        return self.surface @ functions

    def measure(self, functions: Array) -> Array:
        """Functions times the factor of the metric."""
        result: Array = self.factor @ functions
        return result

    def wanted(self, displacement: Array) -> Array:
        """Displacement minus the gradient's representative in the metric."""
        from scipy.sparse import eye_array
        from scipy.sparse.linalg import splu

        inner = (self.factor.T @ self.factor).tocsc()
        if self._strained:  # edges of bodies that follow, which may hang on nothing else
            least = LEAST * inner.diagonal().max()
            inner = (inner + least * eye_array(inner.shape[0])).tocsc()
        step = splu(inner).solve(self.surface)
        result: Array = self.factor @ (displacement - step)
        return result


class Residuals:
    """From residuals and their (m, n * coordinates) derivatives by the points."""

    def __init__(self, level: Level, residuals: Array, derivatives: Any) -> None:
        self.residuals, self.derivatives = residuals, derivatives
        white = Whitening.of(derivatives @ level.fields)
        self.frame, self.framed = white.frame, level.fields @ white.matrix

    @property
    def surface(self) -> Array:
        """Gradient of half the sum of squares."""
        result: Array = self.derivatives.T @ self.residuals
        return result

    def along(self, functions: Array) -> Array:
        """Changes of the residuals times the residuals."""
        result: Array = self.residuals @ (self.derivatives @ functions)
        return result

    def measure(self, functions: Array) -> Array:
        """Changes of the residuals."""
        result: Array = self.derivatives @ functions
        return result

    def wanted(self, displacement: Array) -> Array:
        """Displacement that would bring the linearised residuals to nothing."""
        result: Array = self.derivatives @ displacement - self.residuals
        return result


class Differences:
    """From finite differences of the cost, one evaluation for each function."""

    def __init__(self, level: Level, along: Callable[[Array], Array]) -> None:
        self.along = along
        self.factor = level.factor
        self.frame, self.framed = level.white.frame, level.framed

    @property
    def surface(self) -> Array:
        """There is none."""
        raise InputError(
            "this indicator needs the gradient by the points; without it take gain or gradient"
        )

    def measure(self, functions: Array) -> Array:
        """Functions times the factor of the metric."""
        result: Array = self.factor @ functions
        return result

    def wanted(self, displacement: Array) -> Array:
        """Not to be had from differences."""
        raise InputError("knots are relocated by the gradient by the points, which is missing")


class Wanted:
    """Distance to a wanted displacement, in the metric of another sensitivity."""

    def __init__(self, level: Level, metric: Sensitivity, wanted: Array) -> None:
        white = Whitening.of(metric.measure(level.fields))
        self.measure, self.target = metric.measure, wanted
        self.frame, self.framed = white.frame, level.fields @ white.matrix

    @property
    def surface(self) -> Array:
        """There is none; gains do without."""
        raise InputError("relocation knows the gain alone")

    def along(self, functions: Array) -> Array:
        """Derivative of half the squared distance from no displacement."""
        return -(self.target @ self.measure(functions))

    def wanted(self, displacement: Array) -> Array:
        """The target itself."""
        return self.target

    @property
    def distance(self) -> float:
        """Squared distance of the space from what is wanted."""
        left = self.target - self.frame @ (self.frame.T @ self.target)
        return float(left @ left)

    @property
    def nearest(self) -> Array:
        """(n * coordinates,) displacement of the space nearest to what is wanted."""
        return self.framed @ (self.frame.T @ self.target)
