"""Rules: which control points may move, in which directions, and which move together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Mask
from ffdstudio.errors import InputError

Vector = tuple[float, float, float]
AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Rules:
    """What may move. Rules hold for a lattice and for each refinement of it.

    Attributes
    ----------
    directions : tuple of vectors
        Directions of displacement; each control point gets one variable a direction.
    frozen : int or tuple of int
        Outermost layers of control points that stay, one number for all directions of the
        lattice or one for each.
    fixed : tuple of tuples
        Indices (i, j, k) of further control points that stay.
    mirror : tuple, optional
        (direction of the lattice, normal of any length): control points at opposite ends of that
        direction move as mirror images.
    linked : tuple of int
        Directions of the lattice along which all control points move as one.
    weights : tuple of float, optional
        Positive lower and upper bound of weights that are variables too; fixed without.

    Raises
    ------
    InputError
        If the bounds of the weights are not positive numbers in order, or the normal is zero.

    Examples
    --------
    >>> rules = Rules(frozen=(1, 0))
    >>> rules.basis(rules.movable((5, 2))).shape
    (30, 6)
    """

    directions: tuple[Vector, ...] = ((0.0, 1.0, 0.0),)
    frozen: int | tuple[int, ...] = 0
    fixed: tuple[tuple[int, ...], ...] = ()
    mirror: tuple[int, Vector] | None = None
    linked: tuple[int, ...] = ()
    weights: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        bounds = self.weights
        if bounds is not None and not 0 < bounds[0] < bounds[1] < np.inf:
            raise InputError(f"weights need bounds with 0 < lower < upper, got {bounds}")
        if self.mirror is not None and not np.any(self.mirror[1]):
            raise InputError("the normal of a mirror has no length")

    def layers(self, dimension: int) -> tuple[int, ...]:
        """Frozen layers of each direction."""
        frozen = self.frozen
        return (frozen,) * dimension if isinstance(frozen, int) else tuple(frozen)

    def refinable(self, axis: int) -> bool:
        """Whether a knot in that direction brings new shapes that keep the rules."""
        return axis not in self.linked and (self.mirror is None or self.mirror[0] != axis)

    def movable(self, shape: tuple[int, ...]) -> Mask:
        """Control points outside the frozen layers.

        Raises
        ------
        InputError
            If the layers leave nothing.
        """
        mask = np.ones(shape, dtype=bool)
        for axis, k in enumerate(self.layers(len(shape))):
            if not 0 <= 2 * k < shape[axis]:
                raise InputError(
                    f"{k} frozen layers leave nothing of {shape[axis]} control points in "
                    f"direction {'ijk'[axis]}"
                )
            along = np.moveaxis(mask, axis, 0)
            along[:k] = False
            along[len(along) - k :] = False
        return mask

    def held(self, shape: tuple[int, ...]) -> Mask:
        """Control points that `fixed` names."""
        mask = np.zeros(shape, dtype=bool)
        for index in self.fixed:
            if len(index) != len(shape) or not all(
                0 <= i < n for i, n in zip(index, shape, strict=True)
            ):
                raise InputError(f"there is no control point {index} in a lattice of {shape}")
            mask[tuple(index)] = True
        return mask

    def basis(self, movable: Mask) -> Any:
        """Sparse (3 * control points, N): displacements of all control points by variables."""
        from scipy.sparse import csc_array

        points = np.flatnonzero(movable)
        vectors = np.array(self.directions, dtype=np.float64).reshape(-1, 3)
        if np.linalg.matrix_rank(vectors) < len(vectors):
            raise InputError(f"the directions {self.directions} are not independent")
        group = self._groups(movable.shape)[points]
        names = group[:, None] * len(vectors) + np.arange(len(vectors))
        names, column = np.unique(names.ravel(), return_inverse=True)
        rows = 3 * np.repeat(points, len(vectors))[:, None] + np.arange(3)
        entries = np.tile(vectors, (len(points), 1)).ravel()
        place = (rows.ravel(), np.repeat(column, 3))
        matrix = csc_array((entries, place), (3 * movable.size, len(names)))
        return _without_empty(
            matrix if self.mirror is None else self._mirrored(matrix, movable.shape)
        )

    def _groups(self, shape: tuple[int, ...]) -> NDArray[np.intp]:
        """First control point of the group that each one moves with."""
        index = np.arange(np.prod(shape, dtype=int)).reshape(shape)
        for axis in self.linked:
            index = np.broadcast_to(np.take(index, [0], axis=axis), shape)
        return index.ravel()

    def _mirrored(self, matrix: Any, shape: tuple[int, ...]) -> Any:
        """The mean of each column and its mirror image, one of each pair."""
        from scipy.sparse import csr_array, kron

        assert self.mirror is not None
        axis, normal = self.mirror[0], np.array(self.mirror[1], dtype=np.float64)
        index = np.arange(np.prod(shape, dtype=int)).reshape(shape)
        partner = np.flip(index, axis=axis).ravel()
        swap = csr_array((np.ones(partner.size), (index.ravel(), partner)))
        normal /= np.linalg.norm(normal)
        image = kron(swap, np.eye(3) - 2 * np.outer(normal, normal)) @ matrix
        matrix.sort_indices()
        own = matrix.indices[matrix.indptr[:-1]] // 3
        both = (matrix + image).tocsc()[:, np.flatnonzero(own <= partner[own])]
        on_plane = own[own <= partner[own]] == partner[own[own <= partner[own]]]
        return both.multiply(np.where(on_plane, 0.5, 1.0)[None, :])


def _without_empty(matrix: Any) -> Any:
    matrix = matrix.tocsc()
    matrix.eliminate_zeros()
    return matrix[:, np.flatnonzero(np.diff(matrix.indptr))]
