"""Gmsh as the filler of areas and volumes, with nothing left to chance."""

import contextlib

import gmsh
import numpy as np
from scipy.spatial import cKDTree

FRONTAL, DELAUNAY_3D = 6, 1
TYPES = {"line": (1, 1, 2), "triangle": (2, 2, 3), "quad": (2, 3, 4), "tetra": (3, 4, 4)}


@contextlib.contextmanager
def session():
    """An empty Gmsh: one thread, a fixed seed, sizes from `set_sizes` alone."""
    gmsh.initialize(interruptible=False)
    for name, value in {
        "General.Verbosity": 2,
        "General.NumThreads": 1,
        "Mesh.RandomSeed": 1,
        "Mesh.Algorithm": FRONTAL,
        "Mesh.Algorithm3D": DELAUNAY_3D,
        "Mesh.Smoothing": 5,
        "Mesh.OptimizeNetgen": 1,
        "Mesh.MeshSizeExtendFromBoundary": 0,
        "Mesh.MeshSizeFromPoints": 0,
    }.items():
        gmsh.option.setNumber(name, value)
    yield
    gmsh.finalize()


def set_sizes(size, *walls):
    """Sizes by a function of the distances to each of the given sets of points, (n, 2 or 3)."""
    trees = [cKDTree(points) for points in walls]

    def at(_dimension, _tag, x, y, z, _given):
        return size(*(tree.query((x, y, z)[: tree.m])[0] for tree in trees))

    gmsh.model.mesh.setSizeCallback(at)


def polygon(corners):
    """Tag of a closed loop in the plane; each of its sides will be one edge of the mesh."""
    geo = gmsh.model.geo
    points = [geo.addPoint(x, y, 0) for x, y in corners]
    sides = [geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    for side in sides:
        geo.mesh.setTransfiniteCurve(side, 2)
    return geo.addCurveLoop(sides)


def nodes():
    """(n, 3) coordinates in the order of Gmsh's tags; geometric points come first."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    return coordinates.reshape(-1, 3)[np.argsort(tags)]


def elements(kind, *entities):
    """(k, nodes) indices into `nodes()` of a type's elements, on the entities named or on all.

    Sorted, as Gmsh's own order may depend on addresses in memory.
    """
    dimension, code, size = TYPES[kind]
    order = np.sort(gmsh.model.mesh.getNodes()[0])
    found = [
        gmsh.model.mesh.getElementsByType(code, entity)[1].reshape(-1, size)
        for entity in entities or [tag for _, tag in gmsh.model.getEntities(dimension)]
    ]
    rows = np.searchsorted(order, np.concatenate(found).astype(np.int64))
    return rows[np.lexsort(rows.T[::-1])]


def without_unused(points, cells, *boundaries):
    """Drop the points that no cell uses, and renumber the rest."""
    used = np.unique(np.concatenate([block.ravel() for block in cells.values()]))
    new = np.full(len(points), -1)
    new[used] = np.arange(len(used))
    cells = {kind: new[block] for kind, block in cells.items()}
    return points[used], cells, *[new[boundary] for boundary in boundaries]
