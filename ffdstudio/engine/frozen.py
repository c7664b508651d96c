"""Frozen layers: the outermost control points of a lattice, which stay where they are.

k frozen layers at a face keep the deformation continuous there up to its derivative k - 1. A
face where the mesh ends, at a symmetry plane for example, may stay open: nothing tears there.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ffdstudio.errors import InputError

Face = tuple[int, ...]  # direction and side, 0 or 1


def frozen_mask(
    shape: tuple[int, ...], layers: int, open_faces: Iterable[Face] = ()
) -> NDArray[np.bool_]:
    """Bool array, true in the `layers` outermost layers of each face that is not open.

    Raises
    ------
    InputError
        If nothing would be left to move in some direction, or there is no such face.

    Examples
    --------
    >>> frozen_mask((4, 3), 1).astype(int)
    array([[1, 1, 1],
           [1, 0, 1],
           [1, 0, 1],
           [1, 1, 1]])
    >>> frozen_mask((4, 3), 1, [(1, 0)]).astype(int)
    array([[1, 1, 1],
           [0, 0, 1],
           [0, 0, 1],
           [1, 1, 1]])
    """
    if not leaves_some(shape, layers, open_faces):
        counts = "x".join(str(count) for count in shape)
        raise InputError(f"{layers} frozen layers on each face leave nothing of {counts} points")
    mask = np.ones(shape, dtype=bool)
    ends = _frozen_ends(shape, layers, open_faces)
    mask[
        tuple(slice(low, count - high) for count, (low, high) in zip(shape, ends, strict=True))
    ] = False
    return mask


def leaves_some(shape: tuple[int, ...], layers: int, open_faces: Iterable[Face] = ()) -> bool:
    """Whether frozen layers leave points that move.

    Examples
    --------
    >>> leaves_some((4, 2), 1), leaves_some((4, 2), 1, [(1, 0)])
    (False, True)
    """
    ends = _frozen_ends(shape, layers, open_faces)
    fits = all(low + high < count for count, (low, high) in zip(shape, ends, strict=True))
    return layers == 0 or (layers > 0 and fits)


def _frozen_ends(
    shape: tuple[int, ...], layers: int, open_faces: Iterable[Face]
) -> list[tuple[int, int]]:
    """Frozen layers at beginning and end of each direction."""
    faces = set(open_faces)
    if not faces <= {(axis, side) for axis in range(len(shape)) for side in (0, 1)}:
        raise InputError(f"a lattice of {len(shape)} directions has no such open faces")
    free = [
        [0 if (axis, side) in faces else layers for side in (0, 1)] for axis in range(len(shape))
    ]
    return [(low, high) for low, high in free]
