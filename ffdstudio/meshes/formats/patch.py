"""Coordinate patching: the file is the template, only numbers of nodes that moved change.

1. A format says where in the file each coordinate stands. Nothing else of the file is
   understood here, so nothing else can be lost.
2. "Changed" means other bits than the file's own value: at rest nothing is rewritten, and an
   undeformed mesh is written with the same bytes *through* this code.
3. Text gets the shortest decimal that reads back as the same double; binary files the value
   in their own type.
4. A node may stand in several places of a file (an STL repeats it for every facet): `slots`
   gives the node of each place.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ffdstudio.aliases import AnyArray, Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats.shortest_floats import shortest_texts
from ffdstudio.meshes.mesh import MeshWarning

CHUNK = 1 << 15
DOUBLE = np.dtype(np.float64)


class Edits:
    """Numbers to replace in a text: (k,) begin and end of each, and its new value.

    A `width` other than 0 is the number of characters that a number may have.
    """

    def __init__(self, starts: Indices, ends: Indices, values: Array, width: int = 0) -> None:
        self.width = width
        order = np.argsort(starts, kind="stable")
        self.starts, self.ends, self.values = starts[order], ends[order], values[order]

    def apply(self, data: bytes) -> bytes:
        """Return the text with the new numbers."""
        return b"".join(self._pieces(data))

    def _pieces(self, data: bytes) -> Iterator[bytes]:
        at = 0
        for k in range(0, len(self.values), CHUNK):
            part = slice(k, k + CHUNK)
            begin, end = self.starts[part].tolist(), self.ends[part].tolist()
            texts = shortest_texts(self.values[part])
            if self.width:
                texts = [_fitted(text, self.width) for text in texts]
            pieces = [b""] * (2 * len(texts))
            pieces[0::2] = [data[i:j] for i, j in zip([at, *end], begin, strict=False)]
            pieces[1::2] = texts
            yield b"".join(pieces)
            at = end[-1]
        yield data[at:]


def _fitted(text: bytes, width: int) -> bytes:
    """A number in so many characters, with as many of its digits as there is room for."""
    if len(text) <= width:
        return text
    value, exact = float(text), _compact(text.decode())
    if len(exact) <= width:
        return exact
    shorter = (_compact(f"{value:.{digits}g}") for digits in range(17, 0, -1))
    return next(s for s in shorter if len(s) <= width and np.isfinite(float(s)))


def _compact(text: str) -> bytes:
    """A number without the zeros that nobody needs: ``-0.5e-05`` is ``-.5e-5``."""
    mantissa, mark, exponent = text.partition("e")
    sign, digits = ("-", mantissa[1:]) if mantissa.startswith("-") else ("", mantissa)
    digits = digits[1:] if digits.startswith("0.") else digits
    return f"{sign}{digits}{mark}{int(exponent) if mark else ''}".encode()


def shortest(values: list[float]) -> list[str]:
    """Shortest decimals that read back as the same doubles."""
    return list(map(repr, values))


@dataclass(frozen=True, eq=False)
class TextTemplate:
    """A text file with the places of its coordinates.

    Attributes
    ----------
    data : bytes
    original : numpy.ndarray
        (n, 3) coordinates as in the file.
    starts, ends : numpy.ndarray
        (m, d) begin and end of each coordinate in `data`; d = 2 for a file without z, -1 where
        a single node has no place for one.
    slots : numpy.ndarray, optional
        (m,) node of each row; by default row i is node i.
    dtype : numpy.dtype
        Type that the file declares for its text; float32 rounds what is written.
    width : int
        Characters that a number may have in files of this format; 0 for any.
    """

    data: bytes
    original: Array
    starts: Indices
    ends: Indices
    slots: Indices | None = None
    dtype: np.dtype = DOUBLE
    width: int = 0

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates.

        Raises
        ------
        InputError
            If a node moves along z in a file without z.
        """
        return self.edits(points).apply(self.data)

    def edits(self, points: Array) -> Edits:
        """Find what changes in the file."""
        old, new = by_slot(self.original, points, self.slots, self.starts.shape[1])
        moved = changed(old, new)
        if (moved & (self.starts < 0)).any():
            row = int(np.flatnonzero((moved & (self.starts < 0)).any(axis=1))[0])
            node = row if self.slots is None else int(self.slots[row])
            raise InputError(
                f"node {node} (counted from 0) has fewer coordinates in its file than move"
            )
        values = rounded(new[moved], self.dtype).astype(np.float64)
        return Edits(self.starts[moved], self.ends[moved], values, self.width)

    def write(self, path: Path, points: Array) -> None:
        """Write the patched file; warn if its type cannot hold all digits."""
        warn_if_rounded(self.original, points, self.dtype, path)
        write_bytes(path, self.patched(points))


@dataclass(frozen=True, eq=False)
class BinaryTemplate:
    """A binary file with the places of its coordinates.

    Attributes
    ----------
    data, original, slots
        As in `TextTemplate`.
    dtype : numpy.dtype
        Floating-point type of the file with its byte order.
    places : numpy.ndarray
        (m, d) where each coordinate begins in `data`.
    """

    data: bytes
    original: Array
    dtype: np.dtype
    places: Indices
    slots: Indices | None = None

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates, rounded to the type of the file."""
        old, new = by_slot(self.original, points, self.slots, self.places.shape[1])
        moved = changed(old, new)
        if not moved.any():
            return self.data
        out = bytearray(self.data)
        put(out, self.places[moved], new[moved], self.dtype)
        return bytes(out)

    def write(self, path: Path, points: Array) -> None:
        """Write the patched file; warn if it cannot hold all digits."""
        data = self.patched(points)
        warn_if_rounded(self.original, points, self.dtype, path)
        write_bytes(path, data)


def put(out: bytearray, places: Indices, values: Array, dtype: DTypeLike) -> None:
    """Store values of a type at (k,) places of a file's content."""
    target = np.frombuffer(out, dtype=np.uint8)
    size = np.dtype(dtype).itemsize
    for k in range(0, len(values), CHUNK):
        part = slice(k, k + CHUNK)
        raw = rounded(values[part], dtype).view(np.uint8).reshape(-1, size)
        target[places[part, None] + np.arange(size)] = raw


def rounded(values: Array, dtype: DTypeLike) -> AnyArray:
    """Values in the type of a file; raises `InputError` if one is too large for it."""
    with np.errstate(over="ignore"):
        stored = np.ascontiguousarray(values).astype(dtype)
    if not np.isfinite(stored).all():
        raise InputError(f"a coordinate is too large for the file's type, {np.dtype(dtype).name}")
    return stored


def by_slot(
    original: Array, points: Array, slots: Indices | None, axes: int
) -> tuple[Array, Array]:
    """(m, axes) old and new coordinates in the order of the file."""
    refuse_missing_axes(original, points, axes)
    old, new = original[:, :axes], points[:, :axes]
    return (old, new) if slots is None else (old[slots], new[slots])


def changed(original: AnyArray, points: AnyArray) -> NDArray[np.bool_]:
    """Which coordinates have other bits."""
    bits = f"i{original.dtype.itemsize}"
    old, new = np.ascontiguousarray(original).view(bits), np.ascontiguousarray(points).view(bits)
    result: NDArray[np.bool_] = np.not_equal(old, new)
    return result


def refuse_missing_axes(original: Array, points: Array, axes: int) -> None:
    """Raise `InputError` where a coordinate changes that the file has no place for."""
    moved = original[:, axes:] != points[:, axes:]
    if moved.any():
        node = int(np.flatnonzero(moved.any(axis=1))[0])
        raise InputError(
            f"the file of this mesh holds {'xyz'[:axes]} only, but node {node} (counted from 0) "
            f"moves along {'xyz'[axes + int(np.argmax(moved[node]))]}"
        )


def warn_if_rounded(original: Array, points: Array, dtype: DTypeLike, path: Path) -> None:
    """Say so if coordinates that changed lose digits in the type of the file."""
    new = points[changed(original, points)]
    if np.dtype(dtype).itemsize < 8 and not np.array_equal(rounded(new, dtype), new):
        warnings.warn(
            f"{path.name}: this file stores single precision (float32); "
            "coordinates are rounded to it",
            MeshWarning,
            stacklevel=4,
        )
