"""Which lattice formats there are, and which one a file is in.

Modules are imported when their format is met, so that the table costs nothing. Each has
``recognises(data)``, ``read(data, name, block)`` and ``write(path, content, ...)``.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.files import read_bytes
from ffdstudio.paths import as_path


@dataclass(frozen=True)
class LatticeFormat:
    """A row of the table; the first suffix that fits decides what is written."""

    module: str
    title: str
    suffixes: tuple[str, ...]
    options: tuple[str, ...] = ()  # of writing, besides `adapt`

    def load(self) -> Any:
        """Import and return the format's module."""
        return importlib.import_module(f"ffdstudio.exchange.{self.module}")


FORMATS = (
    LatticeFormat("native", "FFD Studio lattice", (".lattice.json",)),
    LatticeFormat("geomdl", "geomdl JSON", (".geomdl.json",)),
    LatticeFormat("splinepy", "splinepy JSON", (".splinepy.json",)),
    LatticeFormat("plot3d", "PLOT3D (pyGeo)", (".xyz", ".fmt")),
    LatticeFormat("su2", "SU2 mesh with FFD boxes", (".su2",), ("tag", "markers")),
    LatticeFormat("su2config", "SU2 configuration (FFD_DEFINITION)", (".cfg",), ("tag",)),
    LatticeFormat("gotools", "GoTools volume", (".g2",)),
    LatticeFormat("pygem", "PyGeM parameters", (".prm",)),
)


def read_lattice_file(path: str | os.PathLike[str], block: int | str | None = None) -> LatticeFile:
    """Read a lattice file of any known format.

    Parameters
    ----------
    path : path-like
        The file; its suffix tells the format, else its content.
    block : int or str, optional
        Which lattice of a file that holds several: index from 0, or name. The first by default.

    Returns
    -------
    LatticeFile

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds no such lattice.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "box.lattice.json"
    >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 3, 3))
    >>> _ = write_lattice(path, box, frozen=1, units="mm")
    >>> found = read_lattice_file(path)
    >>> found.frozen, found.units, found.format
    (1, 'mm', 'ffdstudio-lattice')
    """
    source = as_path(path)
    name = os.fspath(path)
    data = read_bytes(source)
    if not data.strip():
        raise InputError(f"{name}: the file is empty")
    found: LatticeFile = _recognised(source, data).load().read(data, name, block)
    return found


def read_lattice(
    path: str | os.PathLike[str], block: int | str | None = None
) -> tuple[Lattice, Lattice]:
    """Read the lattice at rest and the deformed one from a file of any known format.

    Formats that hold one net give it as both. See `read_lattice_file` for the parameters and
    for what else a file says.

    Examples
    --------
    >>> import tempfile
    >>> path = tempfile.mkdtemp() + "/box.lattice.json"
    >>> _ = write_lattice(path, Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 3, 2)))
    >>> rest, current = read_lattice(path)
    >>> rest == current, rest.shape
    (True, (4, 3, 2))
    """
    found = read_lattice_file(path, block)
    return found.rest, found.current


def write_lattice(
    path: str | os.PathLike[str],
    rest: Lattice,
    current: Lattice | None = None,
    *,
    frozen: int = 0,
    units: str = "",
    adapt: str = "refuse",
    open_faces: Iterable[tuple[int, ...]] = (),
    **options: Any,
) -> Exactness:
    """Write a lattice in the format that the suffix of `path` names.

    Parameters
    ----------
    path : path-like
        ``.lattice.json`` (ours), ``.xyz`` or ``.fmt`` (PLOT3D), ``.su2`` (a box in that
        existing mesh), ``.cfg``, ``.g2``, ``.prm``, ``.geomdl.json``, ``.splinepy.json``.
    rest, current : Lattice
        At rest and deformed; a format with one net gets the deformed one.
    frozen : int
        Outermost layers of control points on every face that do not move.
    units : str
        Unit of length, kept by our own format.
    adapt : {"refuse", "exact", "resample"}
        What to do with a lattice the format cannot express: refuse, change it without
        changing the shape (insert knots), or resample it and state the error.
    open_faces : iterable of tuple of int
        Direction and side, 0 or 1, of faces without frozen layers; kept by our own format.
    **options
        What the format knows besides, such as ``tag`` and ``markers`` of SU2.

    Returns
    -------
    Exactness
        What the file keeps, and what it does not.

    Raises
    ------
    InputError
        If the format cannot express the lattice, or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(6, 4, 4))
    >>> print(write_lattice(folder / "box.lattice.json", box))
    exact
    >>> finer = box.insert_knots(0, [1 / 6])
    >>> print(write_lattice(folder / "box.xyz", finer, adapt="exact"))
    exact: 2 knots were inserted in direction i
    """
    if adapt not in ("refuse", "exact", "resample"):
        raise InputError(f'adapt must be "refuse", "exact" or "resample", got {adapt!r}')
    now, faces = rest if current is None else current, tuple(open_faces)
    content = LatticeFile(rest, now, frozen, faces, units=units)
    target = as_path(path)
    row = _named(target)
    for option in options.keys() - set(row.options):
        raise InputError(f"{target}: {row.title} has no option {option}")
    if row.module != "native":
        options["adapt"] = adapt
    result: Exactness = row.load().write(target, content, **options)
    return result


def is_lattice_file(path: str | os.PathLike[str]) -> bool:
    """Whether a file is in a format that holds nothing but lattices, by its suffix.

    Examples
    --------
    >>> is_lattice_file("wing.lattice.json"), is_lattice_file("wing.su2")
    (True, False)
    """
    name = os.fspath(path).lower()
    fitting = _by_suffix(Path(name))
    return name.endswith(".json") or bool(fitting and fitting[0].module != "su2")


def _by_suffix(path: Path) -> list[LatticeFormat]:
    name = path.name.lower()
    return [row for row in FORMATS if name.endswith(row.suffixes)]


def _recognised(path: Path, data: bytes) -> LatticeFormat:
    """By suffix; a bare ``.json`` or an unknown suffix is told by content."""
    fitting = _by_suffix(path)
    if fitting:
        return fitting[0]
    for row in FORMATS:
        if row.load().recognises(data):
            return row
    raise InputError(f"{path}: neither suffix nor content tells a lattice format ({_known()})")


def _named(path: Path) -> LatticeFormat:
    fitting = _by_suffix(path)
    if not fitting and path.name.lower().endswith(".json"):
        fitting = [FORMATS[0]]
    if not fitting:
        raise InputError(f"{path}: no lattice format is known by this suffix ({_known()})")
    return fitting[0]


def _known() -> str:
    return ", ".join(suffix for row in FORMATS for suffix in row.suffixes)
