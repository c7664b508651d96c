"""Quality of a million hexahedra after moving one control point, against VTK's scaled Jacobian.

python benchmarks/bench_quality.py [cells along an edge, default 100]

One inner control point of a cubic lattice of 8x6x4 around the mesh moves. VTK measures its
scaled Jacobian on the same cells: those with moved nodes, and for comparison on all. We measure
everything (report with inverted cells against the undeformed mesh), for cells with moved nodes
and their neighbours. Repetitions take turns; the least time counts.
"""

from __future__ import annotations

import sys

import numpy as np
import pyvista as pv
import vtk
from bench_guard import cube, least

import ffdstudio as ffd
from ffdstudio.meshes import Mesh

HEXAHEDRON = 12


def scaled_jacobian(points: np.ndarray, cells: np.ndarray) -> vtk.vtkMeshQuality:
    """Filter that measures hexahedra."""
    measure = vtk.vtkMeshQuality()
    measure.SetInputData(pv.UnstructuredGrid({HEXAHEDRON: cells}, points))
    measure.SetHexQualityMeasureToScaledJacobian()
    return measure


def run_again(measure: vtk.vtkMeshQuality) -> None:
    measure.Modified()
    measure.Update()


def main() -> None:
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    points, cells = cube(n)
    mesh = Mesh(points, {"hexahedron": cells})
    lattice = ffd.Lattice.around(points, shape=(8, 6, 4))
    drag = ffd.embed(lattice, points).drag(
        lattice, [np.ravel_multi_index((3, 2, 1), lattice.shape)]
    )
    places = []
    for step in (0.01, 0.02):
        new = points.copy()
        drag.move(np.array([step, step, 0.0]), new)
        places.append(new)
    moved = np.zeros(len(points), dtype=bool)
    moved[drag.rows] = True
    touched = cells[moved[cells].any(axis=1)]
    same, whole = scaled_jacobian(places[0], touched), scaled_jacobian(places[0], cells)
    ffd.quality(mesh)
    turn = iter(range(1_000))
    best = least(
        {
            "VTK": lambda: run_again(same),
            "VTK, all cells": lambda: run_again(whole),
            "quality": lambda: ffd.quality(mesh, places[next(turn) % 2]),
        },
        6,
    )
    print(f"{len(cells)} hexahedra, {len(touched)} with moved nodes")
    for name, seconds in best.items():
        print(f"{name:<15} {1e3 * seconds:6.0f} ms")
    print(f"quality is {best['quality'] / best['VTK']:.2f} x VTK on the same cells (at most 3)")
    print(f"           {best['quality'] / best['VTK, all cells']:.2f} x VTK on all cells")


if __name__ == "__main__":
    main()
