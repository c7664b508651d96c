"""All nodes of a body and its inverted cells: work for a worker, done on release."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ffdstudio.aliases import Array
from ffdstudio.meshes import Coverage, Mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.topology import dimension
from ffdstudio.project.followers import Follower
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.running import Progress, no_progress


@dataclass(frozen=True, eq=False)
class DeformedVolume:
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
    coverage : Coverage
        Which cells were looked at, and which were not.
    """

    points: Array
    moved: int
    inverted: int | None
    broken: tuple[str, ...] = ()
    coverage: Coverage = field(default_factory=Coverage)


def countable(mesh: Mesh) -> bool:
    """Whether cells of the mesh can be inverted: a volume, or a plane mesh."""
    solid = any(dimension(kind) == mesh.dimension for kind in mesh.cells)
    return mesh.faces is not None or solid or bool(mesh.unread)


def work_out(
    mesh: Mesh,
    nodes: Follower,
    lattices: Sequence[LatticeItem],
    progress: Progress = no_progress,
) -> DeformedVolume:
    """Move all nodes of a mesh and look for inverted cells."""
    from ffdstudio.meshes import coverage, inverted

    points = nodes.embed([item for item in lattices if item.deformed], progress)
    moved = int((points != mesh.points).any(axis=1).sum())
    progress(0.7, "looking for inverted cells")
    count, seen = None, Coverage()
    if countable(mesh):
        count = inverted(mesh, points).count if moved else 0
        seen = coverage(mesh)
    return DeformedVolume(points, moved, count, tuple(broken(mesh, points)) if moved else (), seen)
