"""Valid files that many readers trip over: marks, repeats, records, counts, blank lines."""

from __future__ import annotations

import codecs
from pathlib import Path

import numpy as np

POINTS = np.array(
    [[i + 0.1 * j, j / 3, k / 7] for k in range(2) for j in range(2) for i in range(3)]
)
CELLS = [[0, 1, 4, 3, 6, 7, 10, 9], [1, 2, 5, 4, 7, 8, 11, 10]]


def rows(points: np.ndarray = POINTS) -> str:
    return "\n".join(" ".join(map(repr, row)) for row in points.tolist())


def su2_with_mark(path: Path) -> None:
    cells = "\n".join("12 " + " ".join(map(str, cell)) for cell in CELLS)
    text = f"NDIME= 3\nNELEM= 2\n{cells}\nNPOIN= 12\n{rows()}\nNMARK= 0\n"
    path.write_bytes(codecs.BOM_UTF8 + text.encode())


def obj_with_mark(path: Path) -> None:
    """Materials, lines that go on, colours behind the coordinates."""
    vertices = "".join(f"v {row} 1.0 0.5 0.5\n" for row in rows().split("\n"))
    faces = "usemtl metal\nf 1 2 \\\n 5 4\ng window\nusemtl glass\nf 2//1 3//1 6//1\r\nl 1 2\n"
    path.write_bytes(codecs.BOM_UTF8 + (vertices + "vn 0 0 1\ng skin upper\n" + faces).encode())


def plot3d_repeats(path: Path) -> None:
    """Each coordinate in one line, runs of equal numbers as a count, a star and the number."""
    lines = ["1", "3 2 2"]
    for column in POINTS.T.tolist():
        words, k = [], 0
        while k < 12:
            many = next((n for n in range(1, 12 - k) if column[k + n] != column[k]), 12 - k)
            words.append(f"{many}*{column[k]!r}" if many > 1 else repr(column[k]))
            k += many
        lines.append(", ".join(words))
    path.write_text("\n".join(lines) + "\n")


def plot3d_plain(path: Path) -> None:
    columns = POINTS[:6, :2] if path.suffix == ".p2dfmt" else POINTS
    head = "1\n3 2\n" if path.suffix == ".p2dfmt" else "3 2 2\n"
    path.write_text(head + "\n".join(" ".join(map(repr, column)) for column in columns.T.tolist()))


def plot3d_records(path: Path) -> None:
    """Two blocks; Fortran records of their own for x, y and z."""
    shapes = np.array([[3, 2, 2], [3, 2, 2]], "<i4")
    parts = [np.array([2], "<i4").tobytes(), shapes.tobytes()]
    for block in (POINTS, POINTS + 10):
        parts += [column.astype("<f8").tobytes() for column in block.T]
    marks = [np.array([len(part)], "<i4").tobytes() for part in parts]
    path.write_bytes(b"".join(m + p + m for m, p in zip(marks, parts, strict=True)))


def ugrid_wide(path: Path) -> None:
    """Whole numbers of eight bytes, and the names of boundaries beside."""
    counts = [12, 0, 2, 0, 0, 0, 2]
    whole = [1, 4, 10, 7, 3, 9, 12, 6, 1, 2, *(n + 1 for cell in CELLS for n in cell)]
    order = "<" if ".l" in path.name else ">"
    path.write_bytes(
        np.array(counts, f"{order}i8").tobytes()
        + POINTS.astype(f"{order}f8").tobytes()
        + np.array(whole, f"{order}i8").tobytes()
    )
    stem = path.name.split(".")[0]
    path.with_name(f"{stem}.mapbc").write_bytes(
        "2\n1 4000 Fl\xfcgel\n2 5000 far field\n".encode("latin-1")
    )


def ply_scalar_first(path: Path) -> None:
    head = ["ply", "format ascii 1.0", "element vertex 12"]
    head += [f"property double {axis}" for axis in "xyz"] + ["element face 3"]
    head += ["property uchar red", "property int part", "property list uchar int vertex_indices"]
    head += ["property float quality", "end_header"]
    faces = "255 7 3 0 1 3 0.5\n0 8 4 1 2 5 4 .25\n1 9 3 6 7 9 1e-3\n"
    path.write_text("\n".join(head) + "\n" + rows() + "\n" + faces)


def vtk_blank_line(path: Path) -> None:
    cells = "\n".join("8 " + " ".join(map(str, cell)) for cell in CELLS)
    path.write_text(
        "# vtk DataFile Version 3.0\na title\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS 12 double\n{rows()}\nCELLS 2 18\n{cells}\nCELL_TYPES 2\n12\n12\n"
    )


def stl_of_a_stream(path: Path) -> None:
    """The count of facets is left at what was written before they were known."""
    record = np.zeros(2, [("normal", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    record["v"] = POINTS[[[0, 1, 3], [1, 4, 3]]]
    count = 0 if "zero" in path.name else 2**32 - 1
    path.write_bytes(
        b"binary".ljust(80, b"\0") + np.array([count], "<u4").tobytes() + record.tobytes()
    )
