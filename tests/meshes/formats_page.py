"""The page of mesh formats, made from the tests: ``python -m tests.meshes.formats_page``.

What it says of a format is what the table of test_formats.py checks, or a test file of its own;
the limits are the numbered notes of the format's module.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from ffdstudio.meshes.formats import FORMATS, MeshFormat, candidates, recognise
from tests.meshes.specimens import SPECIMENS
from tests.meshes.test_formats import TABLE, Row

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "formats.md"
READERS = {  # oracle -> who reads
    **dict.fromkeys(("with_meshio",), "meshio"),
    **dict.fromkeys(("with_vtk", "cgns_with_vtk", "plot3d_binary"), "VTK"),
    **dict.fromkeys(("with_gmsh",), "Gmsh"),
    **dict.fromkeys(("cgns_with_h5py", "med_nodes", "fluent_hdf"), "h5py"),
    **dict.fromkeys(("exodus_with_netcdf",), "netCDF4"),
}
OWN = {  # formats of folders, of several files or of other promises: their test files and reader
    "openfoam": (["test_openfoam.py", "test_checkmesh.py"], "foamlib, checkMesh"),
    "vtk_parts": (["test_exchange_formats.py"], "VTK"),
    "lsdyna": (["test_lsdyna.py"], "a parser of the tests"),
    "airfoil": (["test_airfoil.py"], "a parser of the tests"),
    "vtp": (["test_vtk_xml.py"], "VTK"),
    "vts": (["test_vtk_xml.py"], "VTK"),
}
READ_ONLY = ("tecplot", "meshio")
HEAD = """# Mesh formats

<!-- made by `python -m tests.meshes.formats_page` from the tests: do not edit -->

A mesh is written back as the file it came from, with other coordinates. For every format below
the tests check that

1. without a deformation the file has the same bytes, written through the patching path;
2. when one node moves, only that node's lines or bytes change (*own bytes*), or the compressed
   blocks that hold it (*repacked*);
3. after a morph of all nodes a reader that is not ours finds exactly the intended numbers, in the
   precision of the file.

Every format may be compressed as a whole (`.gz`): it is unpacked on opening and written packed.

| format | suffixes | written back | precision | checked by | files | new files |
|---|---|---|---|---|---|---|
"""


def page() -> str:
    """Text of the page."""
    rows = _by_format()
    names = list(dict.fromkeys(row.name for row in FORMATS))
    lines = [_line(name, rows.get(name, [])) for name in names]
    notes = [_notes(name) for name in names]
    return HEAD + "\n".join(lines) + "\n\n## Limits\n\n" + "\n".join(filter(None, notes))


def _by_format() -> dict[str, list[Row]]:
    """Rows of the table of tests by the format that opens their files."""
    found: dict[str, list[Row]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for row in TABLE:
            found.setdefault(_format_of(row.file, Path(folder)), []).append(row)
    return found


def _format_of(file: str, folder: Path) -> str:
    names = {row.name for row in candidates(Path(file))}
    if len(names) == 1:
        return names.pop()
    if file not in SPECIMENS:  # a real mesh, in a folder of its format's name
        own = Path(file).parent.name
        own = "avs" if "avs" in file else own
        return own if own in names else "gmsh"
    SPECIMENS[file](folder / file)
    return recognise(folder / file, (folder / file).read_bytes()[:65536]).name


def _rows_of(name: str) -> list[MeshFormat]:
    return [row for row in FORMATS if row.name == name]


def _line(name: str, rows: list[Row]) -> str:
    own = _rows_of(name)
    suffixes = ", ".join(f"`{s}`" for row in own for s in _short(row.suffixes)) or "any other"
    new = "yes" if any(row.new for row in own) else "no"
    if name in READ_ONLY:
        cells = ["no, read only", "double", "", ""]
    elif name in OWN:
        files, reader = OWN[name]
        cells = ["own bytes", "as in the file", reader, ", ".join(f"`{f}`" for f in files)]
    else:
        cells = [_patching(rows), _precision(rows), _readers(rows), _files(rows)]
    return " | ".join([f"| {own[0].title}", suffixes, *cells, f"{new} |"])


def _short(suffixes: tuple[str, ...]) -> list[str]:
    """Suffixes, those of UGRID's layouts in one."""
    layouts = [s for s in suffixes if re.fullmatch(r"\.l?[br][48]l?\.ugrid", s)]
    plain = [s for s in suffixes if s not in layouts]
    return plain + [".[l]{b,r}{4,8}[l].ugrid"] * bool(layouts)


def _patching(rows: list[Row]) -> str:
    kinds = {"repacked" if row.budget is None else "own bytes" for row in rows}
    return " or ".join(sorted(kinds))


def _precision(rows: list[Row]) -> str:
    kinds = {"single, rounding is said" if row.single else "double" for row in rows}
    kinds |= {f"{row.digits} digits" for row in rows if row.digits}
    return "; ".join(sorted(kinds))


def _readers(rows: list[Row]) -> str:
    names = (READERS.get(row.oracle.__name__, "a parser of the tests") for row in rows)
    return ", ".join(sorted(set(names), key=str.lower))


def _files(rows: list[Row]) -> str:
    made = sum(row.file in SPECIMENS for row in rows)
    return f"{made} made, {len(rows) - made} real" if made < len(rows) else f"{made} made"


def _notes(name: str) -> str:
    """Numbered notes of the format's module."""
    own = _rows_of(name)[0]
    text = own.load().__doc__ or ""
    first = text.find("\n1. ")
    if first < 0:
        return ""
    notes = text[first:].split("\n\n")[0].strip("\n")
    return f"### {own.title}\n\n{notes}\n"


if __name__ == "__main__":
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(page())
