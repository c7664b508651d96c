"""The registry of mesh formats: which suffixes and which contents belong to which file here.

A format is one module with ``read(path, data, progress) -> Mesh``, imported when a file needs it.
Where a new file can be made from any mesh, a module has ``write_new(mesh, path)``.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

Progress = Callable[[float], None]


class MeshFormat(NamedTuple):
    """One row of the registry.

    `name` is what `Mesh.format` holds; `module` the file in this folder; `suffixes` in lower
    case; `signature` tells by the first bytes whether a file is of this format, for suffixes
    that several formats share; `new` the file whose `write_new` makes such a file from any mesh.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    module: str
    signature: Callable[[bytes], bool] | None = None
    new: str = ""

    def load(self, module: str = "") -> ModuleType:
        """Import the module of this format, or another one of this folder."""
        return importlib.import_module(f"{__name__}.{module or self.module}")


def begins_with(*marks: bytes) -> Callable[[bytes], bool]:
    """Signature: the file begins with one of these, white space aside."""
    return lambda head: head.lstrip().startswith(marks)


def has_grid(head: bytes) -> bool:
    """Whether a text has words of a Nastran deck."""
    return re.search(rb"^ *(GRID|BEGIN BULK|INCLUDE|CEND|SOL )", head, re.M | re.I) is not None


def five_counts(head: bytes) -> bool:
    """Whether the first line that is no comment has five whole numbers, as in AVS-UCD."""
    lines = [line for line in head.split(b"\n", 100)[:100] if not line.startswith(b"#")]
    words = lines[0].split() if lines else []
    return len(words) == 5 and all(word.isdigit() for word in words)


def two_columns(head: bytes) -> bool:
    """Whether the second line of a text has two numbers, as in an airfoil file."""
    lines = [line for line in head.split(b"\n", 20)[:20] if line.strip()]
    words = lines[1].split() if len(lines) > 1 else []
    return len(words) == 2 and all(re.fullmatch(rb"[-+.\deE]+", word) for word in words)


def is_netcdf(head: bytes) -> bool:
    """Whether a file begins as those of netCDF do."""
    return head.startswith((b"CDF", b"\x89HDF"))


def titled(head: bytes) -> bool:
    """Whether a text begins as Tecplot files do."""
    return head.lstrip().upper().startswith((b"TITLE", b"VARIABLES", b"ZONE", b"FILETYPE"))


UGRIDS = tuple(
    f".{end}{kind}{size}{wide}.ugrid"
    for end in ("", "l")
    for kind in "br"
    for size in "84"
    for wide in ("", "l")
)
PLOT3DS = (".xyz", ".p3d", ".x", ".p3dfmt", ".fmt", ".xyzfmt", ".p2dfmt", ".p2d", ".grd", ".g")
EXODUS = (".exo", ".e", ".ex2", ".exii", ".g", ".gen")
FORMATS: tuple[MeshFormat, ...] = (
    MeshFormat("su2", "SU2", (".su2",), "su2", new="su2_new"),
    MeshFormat("stl", "STL", (".stl",), "stl", new="stl"),
    MeshFormat("obj", "Wavefront OBJ", (".obj",), "obj", new="obj"),
    MeshFormat("ply", "PLY", (".ply",), "ply", new="ply"),
    MeshFormat("vtk", "legacy VTK", (".vtk",), "vtk", new="vtk"),
    MeshFormat("vtu", "VTK XML", (".vtu",), "vtu", new="via_meshio"),
    MeshFormat("vtp", "VTK XML polygons", (".vtp",), "vtu"),  # rows of their own, since a file
    MeshFormat("vts", "VTK XML structured grid", (".vts",), "vtu"),  # of one is none of another
    MeshFormat("gmsh", "Gmsh", (".msh", ".msh2", ".msh4"), "gmsh", begins_with(b"$"), "via_meshio"),
    MeshFormat("openfoam", "OpenFOAM polyMesh", (".foam", ".openfoam"), "openfoam"),
    MeshFormat("fluent", "Fluent", (".msh", ".cas"), "fluent", begins_with(b"(")),
    MeshFormat("fluent_hdf", "Fluent HDF5", (".cas.h5", ".msh.h5"), "fluent_hdf"),
    MeshFormat("airfoil", "airfoil coordinates", (".dat", ".txt"), "dat", two_columns, "dat"),
    MeshFormat("nastran", "Nastran", (".bdf", ".nas", ".fem", ".dat", ".pch"), "nastran", has_grid),
    MeshFormat("avs", "AVS-UCD", (".inp", ".avs", ".ucd"), "avs", five_counts),
    MeshFormat("abaqus", "Abaqus or CalculiX", (".inp",), "abaqus", new="via_meshio"),
    MeshFormat("abaqus", "Abaqus or CalculiX mesh", (".msh",), "abaqus", begins_with(b"*")),
    MeshFormat(
        "exodus", "Exodus II", (".exo", ".e", ".ex2", ".exii", ".g", ".gen"), "exodus", is_netcdf
    ),
    MeshFormat("med", "MED", (".med",), "med"),
    MeshFormat("vtk_parts", "VTK blocks and pieces", (".vtm", ".pvtu", ".pvtp"), "vtk_parts"),
    MeshFormat("lsdyna", "LS-DYNA", (".k", ".key", ".dyn"), "lsdyna"),
    MeshFormat("medit", "Medit", (".mesh", ".meshb"), "medit"),
    MeshFormat("off", "OFF", (".off",), "off", new="off"),
    MeshFormat("unv", "universal file", (".unv",), "unv"),
    MeshFormat("plot3d", "PLOT3D", PLOT3DS, "plot3d"),
    MeshFormat("ugrid", "AFLR3 UGRID", (".ugrid", *UGRIDS), "ugrid"),
    MeshFormat("cgns", "CGNS", (".cgns", ".adf"), "cgns"),
    MeshFormat("tecplot", "Tecplot ASCII", (".dat", ".tec"), "via_meshio", titled),
    MeshFormat("meshio", "read through meshio", (), "via_meshio"),
)


def by_name(name: str) -> MeshFormat:
    """Row of the registry with that name."""
    return next(row for row in FORMATS if row.name == name)


def suffix_of(path: Path) -> str:
    """Longest registered suffix of a name, else its last one.

    Examples
    --------
    >>> suffix_of(Path("wing.b8.ugrid")), suffix_of(Path("wing.v2.SU2"))
    ('.b8.ugrid', '.su2')
    >>> suffix_of(Path("wing.stl.gz"))
    '.stl.gz'
    """
    name = path.name.lower()
    bare = name.removesuffix(".gz")
    known = [s for row in FORMATS for s in row.suffixes if bare.endswith(s)]
    if not known:
        return path.suffix.lower()
    return max(known, key=len) + name[len(bare) :]


def candidates(path: Path) -> list[MeshFormat]:
    """Rows whose suffix fits, the longest suffix first; that it is compressed does not count."""
    name = path.name.lower().removesuffix(".gz")
    fits = [(len(s), row) for row in FORMATS for s in row.suffixes if name.endswith(s)]
    return [row for _, row in sorted(fits, key=lambda fit: -fit[0])]


def recognise(path: Path, head: bytes) -> MeshFormat:
    """Format of a file by its suffix and, where that leaves a choice, by its first bytes."""
    if path.is_dir() or path.parent.name == "polyMesh":
        return by_name("openfoam")
    rows = candidates(path)
    for row in rows:
        if row.signature is None or row.signature(head):
            return row
    return rows[0] if rows else by_name("meshio")  # the first one's reader says what is wrong
