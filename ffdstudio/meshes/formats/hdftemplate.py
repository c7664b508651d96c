"""Coordinates in arrays of a file of named arrays, such as HDF5: patched in place where possible.

1. A piece says which numbers of which arrays are the coordinates of which nodes.
2. Where every array lies in one piece of the file, only its bytes change. Arrays in pieces or
   compressed are written through h5py, and only those in which a node moves.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats.cgns_nodes import opened
from ffdstudio.meshes.formats.patch import (
    BinaryTemplate,
    changed,
    refuse_missing_axes,
    rounded,
    warn_if_rounded,
)
from ffdstudio.meshes.formats.source import Source


class DatasetPlace(NamedTuple):
    """An array in a file: its path, where it begins (-1 in pieces), and its type."""

    path: str
    begin: int
    dtype: np.dtype


class Piece(NamedTuple):
    """Coordinates of nodes: an array for each axis and (k, axes) places in these arrays.

    ``flat[i, a]`` is where `arrays[a]`, seen flat, has coordinate a of node ``nodes[i]``.
    """

    arrays: tuple[DatasetPlace, ...]
    flat: Indices
    nodes: Indices


def template_of(source: Source, points: Array, pieces: list[Piece]) -> BinaryTemplate | HdfTemplate:
    """Template of a file whose (n, 3) coordinates stand in these pieces.

    Raises
    ------
    InputError
        If the arrays are not all of one floating-point type.
    """
    arrays = [array for piece in pieces for array in piece.arrays]
    dtypes = {array.dtype for array in arrays}
    if len(dtypes) != 1 or len({len(piece.arrays) for piece in pieces}) != 1:
        raise source.failure("zones with different kinds of coordinates in one file")
    dtype = dtypes.pop()
    if any(array.begin < 0 for array in arrays):
        return HdfTemplate(source, points, pieces, dtype)
    begins = [np.array([array.begin for array in piece.arrays]) for piece in pieces]
    parts = zip(begins, pieces, strict=True)
    places = np.concatenate([begin + dtype.itemsize * piece.flat for begin, piece in parts])
    nodes = np.concatenate([piece.nodes for piece in pieces])
    plain = len(nodes) == len(points) and np.array_equal(nodes, np.arange(len(points)))
    return BinaryTemplate(source.data, points, dtype, places, None if plain else nodes)


@dataclass(frozen=True, eq=False)
class HdfTemplate:
    """HDF5 file whose coordinates lie in pieces or are compressed: written through h5py."""

    source: Source
    original: Array
    pieces: list[Piece]
    dtype: np.dtype

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates."""
        refuse_missing_axes(self.original, points, len(self.pieces[0].arrays))
        moved = changed(self.original, points)
        if not moved.any():
            return self.source.data
        stream = io.BytesIO(self.source.data)
        with opened(self.source, "r+", stream) as file:
            for piece in self.pieces:
                for axis, array in enumerate(piece.arrays):
                    chosen = moved[piece.nodes, axis]
                    if not chosen.any():
                        continue
                    values = np.asarray(file[array.path][()])
                    new = rounded(points[piece.nodes[chosen], axis], self.dtype)
                    values.reshape(-1)[piece.flat[chosen, axis]] = new
                    file[array.path][...] = values
        return stream.getvalue()

    def write(self, path: Path, points: Array) -> None:
        """Write the file with these coordinates."""
        warn_if_rounded(self.original, points, self.dtype, path)
        write_bytes(path, self.patched(points))
