"""Reading a mesh from a file of any format."""

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from pathlib import Path

from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes
from ffdstudio.meshes.byte_order_mark import MARK, Marked
from ffdstudio.meshes.compressed import Packed, inner, is_packed, unpacked
from ffdstudio.meshes.formats import Progress, recognise
from ffdstudio.meshes.mesh import Mesh, MeshWarning
from ffdstudio.paths import as_path, is_folder

HEAD = 65536


def read_mesh(path: str | os.PathLike[str], progress: Progress | None = None) -> Mesh:
    """Read a mesh; the format is told by the file's suffix and content.

    Parameters
    ----------
    path : path-like
        File, or folder of a format that is one.
    progress : callable, optional
        Called with the fraction done, 0 to 1, from time to time and in the calling thread.
        Whatever it raises ends the reading and reaches the caller: that is how to cancel.

    Returns
    -------
    Mesh
        Coordinates are float64 from the file itself.

    Raises
    ------
    InputError
        If the file cannot be read or is damaged; the message names file, place and cause.

    Examples
    --------
    >>> from ffdstudio.samples import sample
    >>> mesh = read_mesh(sample("naca0012.su2"))
    >>> mesh.counts, mesh.marker_counts
    ({'triangle': 8026, 'quad': 1649}, {'airfoil': 200, 'farfield': 52})
    """
    source = as_path(path)
    report = progress or _silent
    report(0.0)
    data = b"" if is_folder(source) else read_bytes(source)
    raw = data
    if is_packed(source) and data:
        data = unpacked(source, data)
    raw_content = data
    marked = data.startswith(MARK)
    data = data[len(MARK) :] if marked else data
    row = recognise(source, data[:HEAD])
    if b'"ffdstudio-lattice"' in data[:HEAD]:
        raise InputError(f"{source}: this is a lattice, where a mesh is needed")
    try:
        mesh: Mesh = row.load().read(inner(source), data, report)
    except MemoryError as error:
        raise InputError(f"{source}: not enough memory to read this file") from error
    except InputError as error:
        raise _named(error, source) from error
    if len(mesh.points) == 0:
        raise InputError(f"{source}: there are no nodes in this file")
    if mesh.template is None:
        warnings.warn(
            f"{source.name}: files of this format can only be read; what is deformed is written "
            "as a new file of another one",
            MeshWarning,
            stacklevel=2,
        )
    if marked and mesh.template is not None:
        mesh = replace(mesh, template=Marked(mesh.template))
    if is_packed(source) and mesh.template is not None:
        mesh = replace(mesh, template=Packed(mesh.template, raw, raw_content))
    report(1.0)
    return replace(mesh, path=source, format=row.name)


def _named(error: InputError, source: Path) -> InputError:
    """Error that names the file as it is on the disk, also where it was unpacked."""
    text, plain = str(error), str(inner(source))
    if plain == str(source) or not text.startswith(plain):
        return error
    return InputError(str(source) + text.removeprefix(plain))


def _silent(fraction: float) -> None:
    """Take no notice of the progress."""
