"""Control nets as rows of a file: which index runs fastest."""

from __future__ import annotations

from collections.abc import Sequence

from ffdstudio.engine.knots import Array


def from_rows(rows: Array, shape: Sequence[int]) -> Array:
    """Rows (n, c) with the first index fastest -> array (*shape, c).

    Examples
    --------
    >>> import numpy as np
    >>> from_rows(np.arange(6.0)[:, None], (3, 2))[:, :, 0]
    array([[0., 3.],
           [1., 4.],
           [2., 5.]])
    """
    d = len(shape)
    return rows.reshape(*reversed(shape), rows.shape[-1]).transpose(*reversed(range(d)), d)


def to_rows(net: Array) -> Array:
    """Inverse of `from_rows`."""
    d = net.ndim - 1
    return net.transpose(*reversed(range(d)), d).reshape(-1, net.shape[-1])
