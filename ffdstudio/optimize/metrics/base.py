"""What a metric is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ffdstudio.optimize.spec.words import sentence_of

if TYPE_CHECKING:
    from ffdstudio.optimize.variables.metrics import Surface


class Metric(ABC):
    """An inner product of functions on a surface: a row of the catalog.

    Attributes
    ----------
    name, title : str
        In files, and for people.
    plain : bool
        Whether the variables stay what they are, the displacements of control points.
    slopes : bool
        Whether it measures slopes, not displacements alone.
    responds : bool
        Whether it needs the surface's `response`.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    plain: ClassVar[bool] = False
    slopes: ClassVar[bool] = False
    responds: ClassVar[bool] = False

    @classmethod
    def about(cls) -> str:
        """What it does, in a sentence."""
        return sentence_of(cls.__doc__)

    @abstractmethod
    def factor(self, surface: Surface) -> Any:
        """Sparse (m, n) C whose C^T C is the inner product of functions at the points."""

    def measure(self, surface: Surface, coordinates: NDArray[np.intp]) -> Any:
        """Sparse (m, n * coordinates) factor for displacements along some coordinates."""
        from scipy.sparse import identity, kron

        count = len(coordinates)
        factor = self.factor(surface)
        return factor if count == 1 else kron(factor, identity(count)).tocsr()
