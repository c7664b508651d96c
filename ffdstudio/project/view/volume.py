"""All nodes of a body and its inverted cells: work for a worker, done on release."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ffdstudio.aliases import Array
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.topology import dimension
from ffdstudio.project.followers import Follower
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.running import Progress, no_progress


@dataclass(frozen=True, eq=False)
class Volume:
    """A body as deformed.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3) all nodes of the mesh.
    moved : int
        How many of them differ from the mesh.
    inverted : int or None
        Cells turned inside out against the undeformed mesh; None for surface meshes, where
        that means nothing.
    broken : tuple of str
        What is no longer planar or no longer a pair, a sentence each (see `promises`).
    """

    points: Array
    moved: int
    inverted: int | None
    broken: tuple[str, ...] = ()


def countable(mesh: Mesh) -> bool:
    """Whether cells of the mesh can be inverted: a volume, or a plane mesh."""
    return mesh.faces is not None or any(dimension(k) == mesh.dimension for k in mesh.cells)


def work_out(
    mesh: Mesh,
    nodes: Follower,
    lattices: Sequence[LatticeItem],
    progress: Progress = no_progress,
) -> Volume:
    """Move all nodes of a mesh and look for inverted cells."""
    from ffdstudio.meshes import inverted

    points = nodes.embed([item for item in lattices if item.deformed], progress)
    moved = int((points != mesh.points).any(axis=1).sum())
    progress(0.7, "looking for inverted cells")
    count = None
    if countable(mesh):
        count = inverted(mesh, points).count if moved else 0
    return Volume(points, moved, count, tuple(broken(mesh, points)) if moved else ())
