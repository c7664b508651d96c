"""HDF5 files whose coordinates lie in pieces or are compressed."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats.cgns_nodes import opened
from ffdstudio.meshes.formats.patch import changed, refuse_missing_axes, rounded, warn_if_rounded
from ffdstudio.meshes.formats.source import Source


@dataclass(frozen=True, eq=False)
class HdfTemplate:
    """HDF5 file whose coordinates lie in pieces or are compressed: written through h5py."""

    source: Source
    original: Array
    arrays: list[tuple[str, int, int, int]]  # dataset, axis, first node, number of nodes
    axes: int
    dtype: np.dtype

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates."""
        refuse_missing_axes(self.original, points, self.axes)
        if not changed(self.original, points).any():
            return self.source.data
        stream = io.BytesIO(self.source.data)
        with opened(self.source, "r+", stream) as file:
            for path, axis, first, count in self.arrays:
                new = rounded(points[first : first + count, axis], self.dtype)
                file[path][...] = new.reshape(file[path].shape)
        return stream.getvalue()

    def write(self, path: Path, points: Array) -> None:
        """Write the file with these coordinates."""
        warn_if_rounded(self.original, points, self.dtype, path)
        write_bytes(path, self.patched(points))
