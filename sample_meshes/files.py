"""Writers for new meshes: SU2 for volumes, VTU for surfaces, with decimals that round-trip."""

import numpy as np

SU2_CODES = {"line": 3, "triangle": 5, "quad": 9, "tetra": 10}
VTK_CODES = {"triangle": 5, "quad": 9}


def decimals(points):
    """One line for each point: the shortest decimals that give the same doubles again."""
    return [" ".join(map(repr, row)) for row in points.tolist()]


def write_su2(path, points, cells, markers):
    """(n, d) points; cells and each marker's elements by type, (k, nodes) indices from 0."""
    lines = [f"NDIME= {points.shape[1]}", f"NELEM= {count(cells)}", *su2_rows(cells, numbered=True)]
    lines += [f"NPOIN= {len(points)}"]
    lines += [f"{row} {i}" for i, row in enumerate(decimals(points))]
    lines += [f"NMARK= {len(markers)}"]
    for name, elements in markers.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {count(elements)}", *su2_rows(elements)]
    path.write_text("\n".join([*lines, ""]))


def count(elements):
    """Elements of all types."""
    return sum(len(nodes) for nodes in elements.values())


def su2_rows(elements, numbered=False):
    """One line an element: type, nodes, and its number for cells."""
    rows = [
        " ".join(map(str, [SU2_CODES[kind], *nodes]))
        for kind, block in elements.items()
        for nodes in block.tolist()
    ]
    return [f"{row} {i}" for i, row in enumerate(rows)] if numbered else rows


def write_vtu(path, points, cells, name, values):
    """(n, 3) points; cells by type; one integer a cell under `name`, such as a part's number."""
    rows = [row for block in cells.values() for row in block.tolist()]
    codes = np.concatenate([np.full(len(block), VTK_CODES[kind]) for kind, block in cells.items()])
    text = VTU.format(
        points=len(points),
        cells=len(rows),
        coordinates="\n".join(decimals(points)),
        connectivity="\n".join(" ".join(map(str, row)) for row in rows),
        offsets=wrapped(np.cumsum([len(row) for row in rows])),
        types=wrapped(codes),
        name=name,
        values=wrapped(values),
    )
    path.write_text(text)


def wrapped(integers, width=20):
    """Integers in lines of a readable length."""
    rows = [integers[i : i + width] for i in range(0, len(integers), width)]
    return "\n".join(" ".join(map(str, row)) for row in rows)


VTU = """<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid>
<Piece NumberOfPoints="{points}" NumberOfCells="{cells}">
<Points>
<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii">
{coordinates}
</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">
{connectivity}
</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">
{offsets}
</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">
{types}
</DataArray>
</Cells>
<CellData>
<DataArray type="Int64" Name="{name}" format="ascii">
{values}
</DataArray>
</CellData>
</Piece>
</UnstructuredGrid>
</VTKFile>
"""
