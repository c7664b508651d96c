"""What each node of a mesh does when its volume follows its surface.

1. Moving nodes are told where to go, staying ones stay; all others follow. Of these some slide
   in a plane (symmetry, `empty`, wedge), and some are partners of others (periodic).
2. A flat boundary that touches a moving one slides as well: the wall of a wind tunnel that a
   wing is mounted on, the plane at the end of a piece of wing.
3. Outer nodes without a marker stay, too, except where a file has them twice: there blocks of
   cells meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.blocks import blocks_of
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.meshes.measures.layers import walls
from ffdstudio.meshes.mesh import Mesh, boundary_faces
from ffdstudio.meshes.pairs import Pair, pairs_of
from ffdstudio.meshes.planes import Plane, plane_through, planes_of
from ffdstudio.meshes.topology import corners, dimension

SLIDES = 1e-9  # of a displacement: how far out of its plane a flat boundary may be moved to slide


@dataclass(frozen=True, eq=False)
class Roles:
    """Roles of the nodes of a mesh.

    Attributes
    ----------
    moving, staying : numpy.ndarray
        Sorted node indices.
    planes : tuple of Plane
        In which nodes slide that neither move nor stay.
    pairs : tuple of Pair
        Nodes whose displacements correspond.
    elements : tuple of numpy.ndarray
        (k, corners) faces between moving and staying nodes, edges in a plane mesh.
    normal : numpy.ndarray or None
        (3,) of a plane problem: a 2D mesh, or one layer of cells between `empty` planes.
    """

    moving: Indices
    staying: Indices
    planes: tuple[Plane, ...]
    pairs: tuple[Pair, ...]
    elements: tuple[Indices, ...]
    normal: Array | None


def roles_of(mesh: Mesh, moving: Sequence[str] | ArrayLike | None = None) -> Roles:
    """Roles of the nodes when these markers (default: the walls) or nodes move.

    Raises
    ------
    InputError
        If the mesh has no volume, a marker is unknown, or nothing moves.
    """
    if not has_volume(mesh):
        raise InputError(f"{mesh.path or 'the mesh'} has no volume that could follow its surface")
    names, nodes = _moving(mesh, moving)
    if not len(nodes):
        raise InputError(f"{mesh.path or 'the mesh'} has no walls: say which boundaries move")
    planes = _sliding(mesh, names, nodes)
    pairs = tuple(p for p in pairs_of(mesh) if not set(p.names) & set(names))
    staying = _staying(mesh, names, nodes, planes, pairs)
    elements = _elements(mesh, names, nodes, staying, planes)
    return Roles(nodes, staying, planes, pairs, elements, _normal(mesh, planes))


def has_volume(mesh: Mesh) -> bool:
    """Whether there are cells around a surface: of a volume, or of a plane mesh."""
    blocks = blocks_of(mesh)
    return blocks.count > 0 and (blocks.dimension == 3 or blocks.flat)


def outer_nodes(mesh: Mesh) -> Indices:
    """Sorted nodes of outer faces and of boundaries, which may lie inside."""
    mask = _outer(mesh)
    for name in mesh.boundaries:
        mask[mesh.marker_nodes(name)] = True
    return np.flatnonzero(mask)


def moved_boundaries(mesh: Mesh, displacement: Array) -> tuple[str, ...]:
    """Names of the boundaries that a displacement (n, 3) of all nodes moves as walls.

    Those that slide are left out: planes and periodic ones, and flat ones beside others where
    nothing leaves the plane.
    """
    special = {plane.name for plane in planes_of(mesh)}
    special |= {name for pair in pairs_of(mesh) for name in pair.names}
    moved = (displacement != 0).any(axis=1)
    found = [name for name in mesh.boundaries if moved[mesh.marker_nodes(name)].any()]
    found = [name for name in found if name not in special]
    flat = {name: plane for name in found if (plane := plane_through(mesh, name)) is not None}
    slack = SLIDES * float(np.abs(displacement).max(initial=0.0))
    slides = [
        name
        for name, plane in flat.items()
        if np.abs(displacement[plane.nodes] @ plane.normal).max() <= slack
        and any(
            len(np.intersect1d(plane.nodes, mesh.marker_nodes(other))) > 0
            for other in found
            if other not in flat
        )
    ]
    return tuple(name for name in found if name not in slides)


def sliding_beside(mesh: Mesh, names: Sequence[str]) -> tuple[str, ...]:
    """Flat boundaries in which nodes slide, beside those that move, for no other reason."""
    planes = _sliding(mesh, tuple(names), mesh.marker_nodes(*names))
    known = {plane.name for plane in planes_of(mesh)}
    return tuple(plane.name for plane in planes if plane.name not in known)


def moved_nodes(mesh: Mesh, moving: Sequence[str] | ArrayLike) -> Indices:
    """Sorted nodes of markers, or of nodes told one by one."""
    return _moving(mesh, moving)[1]


def _moving(
    mesh: Mesh, moving: Sequence[str] | ArrayLike | None
) -> tuple[tuple[str, ...], Indices]:
    if moving is None:
        moving = tuple(name for name in walls(mesh) if name in mesh.boundaries)
    given = [moving] if isinstance(moving, str) else moving
    if not len(given):  # type: ignore[arg-type]
        return (), np.empty(0, dtype=np.int64)
    if all(isinstance(name, str) for name in given):  # type: ignore[union-attr]
        names = tuple(str(name) for name in given)  # type: ignore[union-attr]
        return names, mesh.marker_nodes(*names)
    nodes = np.unique(np.asarray(given))
    if nodes.dtype.kind not in "iu" or nodes[0] < 0 or nodes[-1] >= len(mesh.points):
        raise InputError("moving nodes must be indices of nodes of the mesh")
    return (), nodes.astype(np.int64)


def _sliding(mesh: Mesh, names: tuple[str, ...], moving: Indices) -> tuple[Plane, ...]:
    planes = [plane for plane in planes_of(mesh) if plane.name not in names]
    known = {plane.name for plane in planes} | set(names)
    known |= {name for pair in pairs_of(mesh) for name in pair.names}
    for name in mesh.boundaries:
        if name in known or not len(np.intersect1d(mesh.marker_nodes(name), moving)):
            continue
        plane = plane_through(mesh, name)
        if plane is not None:
            planes.append(plane)
    return tuple(planes)


def _staying(
    mesh: Mesh,
    names: tuple[str, ...],
    moving: Indices,
    planes: tuple[Plane, ...],
    pairs: tuple[Pair, ...],
) -> Indices:
    free = {*names, *(p.name for p in planes), *(name for pair in pairs for name in pair.names)}
    held = np.zeros(len(mesh.points), dtype=bool)
    for name in mesh.boundaries:
        if name not in free and _has_faces(mesh, name):
            held[mesh.marker_nodes(name)] = True
    held[_bare(mesh)] = True
    held &= _outer(mesh)
    held[moving] = False
    return np.flatnonzero(held)


def _bare(mesh: Mesh) -> Indices:
    """Nodes of outer faces that no marker covers, those left out that a file has twice."""
    masks = []
    for name in mesh.boundaries:
        mask = np.zeros(len(mesh.points), dtype=bool)
        mask[mesh.marker_nodes(name)] = True
        masks.append(mask)
    found = [np.empty(0, dtype=np.int64)]
    for nodes in boundary_faces(topology_of(mesh).faces).values():
        covered = np.zeros(len(nodes), dtype=bool)
        for mask in masks:
            covered |= mask[nodes].all(axis=1)
        found.append(nodes[~covered].ravel())
    bare = np.unique(np.concatenate(found))
    _, which, count = np.unique(mesh.points[bare], axis=0, return_inverse=True, return_counts=True)
    return np.asarray(bare[count[which.ravel()] == 1])


def _has_faces(mesh: Mesh, name: str) -> bool:
    bound = 2 if mesh.faces is not None else blocks_of(mesh).dimension - 1
    return any(dimension(kind) == bound for kind in mesh.markers[name])


def _outer(mesh: Mesh) -> np.ndarray:
    """Mask of the nodes of faces with one cell; nodes between corners count by their markers."""
    mask = np.zeros(len(mesh.points), dtype=bool)
    for nodes in boundary_faces(topology_of(mesh).faces).values():
        mask[nodes] = True
    for name in mesh.boundaries:
        for kind, nodes in mesh.markers[name].items():
            ends = corners(kind, nodes)
            mask[nodes[mask[ends].all(axis=1)]] = True
    return mask


def _elements(
    mesh: Mesh,
    names: tuple[str, ...],
    moving: Indices,
    staying: Indices,
    planes: tuple[Plane, ...],
) -> tuple[Indices, ...]:
    """Faces of moving markers, and the outer faces between other nodes that are told."""
    told = np.zeros(len(mesh.points), dtype=bool)
    told[moving] = told[staying] = True
    marked = np.zeros(len(mesh.points), dtype=bool)
    found: list[Indices] = []
    bound = blocks_of(mesh).dimension - 1
    for name in names:
        for kind, nodes in mesh.markers[name].items():
            if dimension(kind) == bound:
                found.append(corners(kind, nodes))
                marked[nodes] = True
    flat = [np.isin(np.arange(len(mesh.points)), plane.nodes) for plane in planes]
    for nodes in boundary_faces(topology_of(mesh).faces).values():
        keep = told[nodes].all(axis=1) & ~marked[nodes].all(axis=1)
        for plane in flat:
            keep &= ~plane[nodes].all(axis=1)
        found.append(nodes[keep])
    return tuple(nodes for nodes in found if len(nodes))


def _normal(mesh: Mesh, planes: tuple[Plane, ...]) -> Array | None:
    if blocks_of(mesh).flat:
        return np.array([0.0, 0.0, 1.0])
    empty = [plane for plane in planes if plane.kind == "empty"]
    if len(empty) != 2 or abs(empty[0].normal @ empty[1].normal) < 1 - 1e-9:
        return None
    between = len(np.union1d(empty[0].nodes, empty[1].nodes)) == len(mesh.points)
    return empty[0].normal if between else None
