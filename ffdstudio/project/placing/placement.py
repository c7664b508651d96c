"""A box lattice that works at once: where it lies, what of it is frozen, what that allows.

Window and command line, and whatever else lays a lattice around a shape, come here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Mask
from ffdstudio.engine import Lattice
from ffdstudio.engine.boxes import Frame, in_world
from ffdstudio.engine.frozen import frozen_mask
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.planes import Plane, planes_of
from ffdstudio.meshes.quasi2d import is_plane, plane_axes
from ffdstudio.project.checks.freezing import Face, suggested
from ffdstudio.project.checks.plane_snapping import seated
from ffdstudio.project.placing.estimate import thinned
from ffdstudio.project.placing.reach import skin_reach
from ffdstudio.project.placing.room import extents, fitting_room, wanted_move, with_room
from ffdstudio.project.running import Progress, no_progress


@dataclass(frozen=True, eq=False)
class Site:
    """What a lattice is laid around, and in.

    Attributes
    ----------
    skin : numpy.ndarray
        (n, 3) points that are to be moved.
    meshes : tuple of tuple
        Meshes around it, and where their nodes are.
    planes : tuple of Plane
        Where they end.
    """

    skin: Array
    meshes: tuple[tuple[Mesh, Array], ...] = ()
    planes: tuple[Plane, ...] = ()

    @classmethod
    def of_mesh(cls, mesh: Mesh, markers: Sequence[str] = ()) -> Site:
        """Site of some markers of a mesh, by default of all of it."""
        skin = mesh.points[mesh.marker_nodes(*markers)] if markers else mesh.points
        return cls(skin, ((mesh, mesh.points),), planes_of(mesh))

    @property
    def is_plane(self) -> bool:
        """Whether all meshes are, or stand for, plane ones."""
        return bool(self.meshes) and all(is_plane(mesh) for mesh, _ in self.meshes)

    @property
    def axes(self) -> Array | None:
        """(2, 3) directions that a lattice of a plane site has; None for x and y, or in space."""
        found = [plane_axes(mesh) for mesh, _ in self.meshes] if self.is_plane else []
        if not found or any(not np.array_equal(axes, found[0]) for axes in found):
            return None
        return None if np.array_equal(found[0], np.eye(3)[:2]) else found[0]


@dataclass(frozen=True, eq=False)
class Placement:
    """A lattice and what is to be said of it.

    Attributes
    ----------
    lattice : Lattice
        Undeformed.
    planes : dict
        Face -> marker of the plane that it is seated on.
    frozen : int
        Outermost layers to freeze.
    crossed : list of tuple
        Faces with mesh on both sides.
    room : numpy.ndarray
        (d,) fractions of the largest extent between shape and faces.
    wanted : float
        By how much the skin should be able to move.
    """

    lattice: Lattice
    planes: dict[Face, str]
    frozen: int
    crossed: list[Face]
    room: Array
    wanted: float

    def reach(
        self, site: Site, frozen: int | None = None, progress: Progress = no_progress
    ) -> float:
        """How far the skin can move before a cell inverts (see `skin_reach`)."""
        free = free_points(self.lattice, self.frozen if frozen is None else frozen, self.planes)
        return skin_reach(self.lattice, free, site.skin, site.meshes, progress)


def placed(
    site: Site,
    shape: Sequence[int],
    degrees: Sequence[int] | None = None,
    axes: ArrayLike | None = None,
    spacing: str = "greville",
    margin: ArrayLike | None = None,
) -> Placement:
    """Lay a box lattice around a shape.

    Parameters
    ----------
    site : Site
    shape : sequence of int
        Control points in each of 1 to 3 directions.
    degrees : sequence of int, optional
        By default 3 where there are 4 points.
    axes : array_like, optional
        (d, 3) unit vectors; by default those of the plane of the site, or x, y, z.
    spacing : str
        Of control points: ``greville`` or ``uniform``.
    margin : array_like, optional
        Room as a fraction of the largest extent, one for all directions or one for each; by
        default as much as it takes to move the skin as `room.wanted_move` says.

    Raises
    ------
    InputError
        If shape, degrees, axes, spacing or margin are wrong.

    Examples
    --------
    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    >>> site = Site.of_mesh(Mesh(square, {"quad": [[0, 1, 2, 3]]}, dimension=2))
    >>> placed(site, (4, 4), margin=0.25).lattice.domain
    array([[-0.25,  1.25],
           [-0.25,  1.25]])
    """
    if axes is None and len(shape) == 2:
        axes = site.axes
    frame = Frame.of(axes, len(shape))
    counts = tuple(shape)
    ends = _ends(frame, site.skin)

    def box(room: ArrayLike) -> tuple[Array, Array, dict[Face, str]]:
        bounds = with_room(frame, ends, room)
        return _slab(site, frame, seated(frame, bounds, ends, site.planes))

    def lattice_with(room: ArrayLike) -> tuple[Lattice, dict[Face, str]]:
        lower, upper, planes = box(room)
        return Lattice.box(lower, upper, counts, degrees, axes, spacing), planes

    if margin is None:
        lattice, planes = lattice_with(0.05)
        layers, _ = suggested(lattice, site.meshes, planes)
        free = free_points(lattice, layers, planes)
        net = (counts, lattice.degrees)
        skin = thinned(site.skin, lattice.weights.size)
        wanted = wanted_move(extents(frame, ends))
        margin = fitting_room(frame, skin, net, lambda room: box(room)[:2], free, wanted)
    lattice, planes = lattice_with(margin)
    layers, crossed = suggested(lattice, site.meshes, planes)
    room = np.broadcast_to(np.asarray(margin, dtype=np.float64), len(counts)).copy()
    wanted = wanted_move(extents(frame, ends))
    return Placement(lattice, planes, layers, crossed, room, wanted)


def _ends(frame: Frame, nodes: Array) -> Array:
    """(2, 3) two points with the extents of all nodes: quicker to lay boxes around."""
    lower, upper = frame.bounds(nodes, 0.0)
    d = len(frame.axes)
    local = nodes @ frame.axes.T  # without the thickness that `bounds` gives to what has none
    lower[:d], upper[:d] = local.min(axis=0), local.max(axis=0)
    return in_world(np.array([lower[:d], upper[:d]]), frame.axes)


def free_points(lattice: Lattice, frozen: int, planes: dict[Face, str]) -> Mask:
    """Which control points move, of the lattice's shape."""
    return ~frozen_mask(lattice.shape, frozen, planes if frozen else ())


def _slab(
    site: Site, frame: Frame, bounds: tuple[Array, Array, dict[Face, str]]
) -> tuple[Array, Array, dict[Face, str]]:
    """Bounds of thickness 1 at right angles to a plane mesh that has none itself."""
    lower, upper, planes = bounds
    if site.meshes and all(mesh.dimension == 2 for mesh, _ in site.meshes):
        normal = np.flatnonzero(frame.axes[:, 2])
        lower[normal], upper[normal] = -0.5, 0.5
    return lower, upper, planes
