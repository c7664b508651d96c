"""Meshes made and written by Gmsh itself."""

from __future__ import annotations

import struct
from pathlib import Path


def gmsh_box(
    path: Path,
    version: float,
    binary: bool,
    parametric: bool = False,
    groups: int = 1,
    partitions: int = 1,
) -> None:
    """Cylinder with named boundaries; a second group shares one surface and the volume."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 1, 1 / 3)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2, [1, 2], name="wall")
        gmsh.model.addPhysicalGroup(3, [1], name="fluid")
        if groups == 2:
            gmsh.model.addPhysicalGroup(2, [2, 3], name="ends")
            gmsh.model.addPhysicalGroup(3, [1], name="air")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.option.setNumber("Mesh.SaveParametric", parametric)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        if partitions > 1:
            gmsh.model.mesh.partition(partitions)
            gmsh.model.mesh.renumberNodes()  # by entity again, as they are written
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def gmsh_periodic(path: Path, version: float, binary: bool, plane: bool = False) -> None:
    """Box whose sides x = 0 (master) and x = 1 correspond; a rectangle if it is plane."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ, model = gmsh.model.occ, gmsh.model
        occ.addRectangle(0, 0, 0, 1, 0.6) if plane else occ.addBox(0, 0, 0, 1, 0.6, 0.7)
        occ.synchronize()
        dim, low, high = (1, 4, 2) if plane else (2, 1, 2)
        model.addPhysicalGroup(dim, [low], name="left")
        model.addPhysicalGroup(dim, [high], name="right")
        model.addPhysicalGroup(dim + 1, [1], name="fluid")
        model.mesh.setPeriodic(dim, [high], [low], [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        model.mesh.generate(dim + 1)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def gmsh_40_binary(path: Path) -> None:
    """The text that Gmsh writes as MSH 4.0, put into the binary form that it only reads."""
    gmsh_box(path, 4.0, False)
    text = path.read_text()
    parts = {}
    for name in ("PhysicalNames", "Entities", "Nodes", "Elements"):
        parts[name] = text.split(f"${name}\n")[1].split(f"$End{name}")[0]
    body = b"$MeshFormat\n4.0 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n"
    body += f"$PhysicalNames\n{parts['PhysicalNames']}$EndPhysicalNames\n".encode()
    for name, pack in (("Entities", _entities), ("Nodes", _nodes), ("Elements", _elements)):
        rows = [line.split() for line in parts[name].splitlines() if line.strip()]
        body += f"${name}\n".encode() + pack(rows) + f"\n$End{name}\n".encode()
    path.write_bytes(body)


def _entities(rows: list[list[str]]) -> bytes:
    counts = list(map(int, rows[0]))
    out, at = struct.pack("<4Q", *counts), 1
    for dim, many in enumerate(counts):
        for words in rows[at : at + many]:
            out += struct.pack("<i6d", int(words[0]), *map(float, words[1:7]))
            left = words[7:]
            for _ in range(1 + (dim > 0)):
                size = int(left[0])
                out += struct.pack(f"<Q{size}i", size, *map(int, left[1 : 1 + size]))
                left = left[1 + size :]
        at += many
    return out


def _nodes(rows: list[list[str]]) -> bytes:
    out, at = struct.pack("<2Q", *map(int, rows[0])), 1
    while at < len(rows):
        *head, many = map(int, rows[at])
        out += struct.pack("<3iQ", *head, many)
        for words in rows[at + 1 : at + 1 + many]:
            out += struct.pack("<i3d", int(words[0]), *map(float, words[1:4]))
        at += 1 + many
    return out


def _elements(rows: list[list[str]]) -> bytes:
    out, at = struct.pack("<2Q", *map(int, rows[0])), 1
    while at < len(rows):
        *head, many = map(int, rows[at])
        out += struct.pack("<3iQ", *head, many)
        for words in rows[at + 1 : at + 1 + many]:
            out += struct.pack(f"<{len(words)}i", *map(int, words))
        at += 1 + many
    return out
