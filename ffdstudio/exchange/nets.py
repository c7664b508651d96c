"""Control nets as rows of a file: which index runs fastest, and along which axes they lie."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ffdstudio.aliases import Array

Z = np.array([0.0, 0.0, 1.0])
FLAT = 1e-9  # of the extent: the tolerance by which points lie on a face


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


def own_axes(net: Array) -> Array | None:
    """Axes of a curve or surface without extent along the first coordinate axes, else None.

    Other tools' files name no axes, and along x and y such a net embeds nothing. A surface
    that stands upright gets the horizontal direction of its plane, and z.

    Parameters
    ----------
    net : numpy.ndarray
        (*shape, 3) control points.

    Returns
    -------
    numpy.ndarray or None
        (d, 3) orthonormal rows.

    Examples
    --------
    >>> own_axes(np.array([[[0, 0, 0], [0, 0, 2]], [[0, 3, 0], [0, 3, 2.0]]]))
    array([[0., 1., 0.],
           [0., 0., 1.]])
    """
    d = net.ndim - 1
    flat = net.reshape(-1, 3)
    points = flat / (np.abs(flat).max() or 1.0)  # or squares may be too large for a number
    points -= points.mean(axis=0)
    extent = np.linalg.norm(points)
    if d == 3 or np.linalg.svd(points[:, :d], compute_uv=False)[-1] > FLAT * extent:
        return None
    axes = [_main_direction(points)] if d == 1 else [_main_direction(points * [1, 1, 0]), Z]
    spread = np.linalg.norm(points @ np.transpose(axes), axis=0)
    return np.array(axes) if spread.min() > FLAT * extent else None


def _main_direction(points: Array) -> Array:
    """Unit vector (3,) along which points around the origin extend most; zero without extent."""
    _, sizes, rows = np.linalg.svd(points, full_matrices=False)
    if sizes[0] == 0:
        return np.zeros(3)
    main = np.where(np.abs(rows[0]) < FLAT, 0.0, rows[0])
    main /= np.linalg.norm(main)
    result: Array = main * np.sign(main[np.abs(main).argmax()])
    return result
