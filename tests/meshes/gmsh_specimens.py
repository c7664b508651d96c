"""Meshes made and written by Gmsh itself."""

from __future__ import annotations

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
