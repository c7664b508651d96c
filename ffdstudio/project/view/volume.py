"""All nodes of a body and its inverted cells: work for a worker, done on release."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ffdstudio.aliases import Array
from ffdstudio.meshes import Coverage, Mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.topology import dimension
from ffdstudio.project.followers import Follower
from ffdstudio.project.model import Body, LatticeItem
from ffdstudio.project.running import Progress, no_progress
from ffdstudio.project.walls import after_walls

if TYPE_CHECKING:
    from ffdstudio.meshes.following import Follower as VolumeFollower


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
    by : Follower or None
        What the volume followed its walls by; None if the lattices carry all nodes.
    """

    points: Array
    moved: int
    inverted: int | None
    broken: tuple[str, ...] = ()
    coverage: Coverage = field(default_factory=Coverage)
    by: VolumeFollower | None = field(default=None, repr=False)


def countable(mesh: Mesh) -> bool:
    """Whether cells of the mesh can be inverted: a volume, or a plane mesh."""
    solid = any(dimension(kind) == mesh.dimension for kind in mesh.cells)
    return mesh.faces is not None or solid or bool(mesh.unread)


def work_out(
    body: Body,
    nodes: Follower,
    lattices: Sequence[LatticeItem],
    progress: Progress = no_progress,
    by: VolumeFollower | None = None,
) -> DeformedVolume:
    """Move all nodes of a body and look for inverted cells; `by` is what its volume followed by."""
    from ffdstudio.meshes import coverage, inverted

    mesh = body.mesh
    carried = nodes.embed([item for item in lattices if item.deformed], progress)
    points, by = after_walls(body, carried, by, progress)
    moved = int((points != mesh.points).any(axis=1).sum())
    progress(0.7, "looking for inverted cells")
    count, seen = None, Coverage()
    if countable(mesh):
        count = inverted(mesh, points).count if moved else 0
        seen = coverage(mesh)
    return DeformedVolume(
        points, moved, count, tuple(broken(mesh, points)) if moved else (), seen, by
    )
