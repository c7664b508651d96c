"""Derivatives of embedded points by control points and by weights.

With R = sum_i w_i B_i P_i / W and W = sum_i w_i B_i (The NURBS Book, eq. 4.1):
dR/dP_i = w_i B_i / W, the same for each coordinate, and dR/dw_i = B_i (P_i - R) / W.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.evaluate import support
from ffdstudio.engine.lattice import Lattice

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def jacobian(current: Lattice, parameters: Array, inside: NDArray[np.bool_]) -> csr_array:
    """(n, control points) CSR matrix d x / d P; rows outside are empty.

    Only the weights of the current lattice matter.
    """
    from scipy.sparse import csr_array

    columns, values = _functions(current, parameters[inside])
    values *= current.weights.ravel()[columns]
    values /= values.sum(axis=1, keepdims=True)
    starts = np.concatenate([[0], np.cumsum(inside * columns.shape[1])])
    shape = (len(inside), current.weights.size)
    return csr_array((values.ravel(), columns.ravel(), starts), shape=shape)


def weight_jacobian(current: Lattice, parameters: Array, inside: NDArray[np.bool_]) -> Array:
    """(n, 3, control points) derivatives d x / d w; zero in rows outside."""
    columns, values = _functions(current, parameters[inside])
    net = current.control_points.reshape(-1, 3)
    shares = values * current.weights.ravel()[columns]
    total = shares.sum(axis=1, keepdims=True)
    points = np.einsum("mi,mik->mk", shares / total, net[columns])
    out = np.zeros((len(inside), 3, len(net)))
    rows = np.flatnonzero(inside)
    for k in range(3):
        out[rows[:, None], k, columns] = values * (net[columns, k] - points[:, k : k + 1]) / total
    return out


def _functions(lattice: Lattice, u: Array) -> tuple[NDArray[np.intp], Array]:
    """Flat indices and values, (m, terms) each, of the basis functions at each parameter."""
    terms = list(support(lattice, u, (0,) * lattice.dimension))
    columns = np.stack([index for index, _ in terms], axis=1)
    return columns, np.stack([value for _, value in terms], axis=1)
