"""How far a skin can move before the first cell inverts: the cells themselves are asked.

The figure is the least over the control points that move the skin most (`estimate.leading`),
both ways along each direction of the lattice: whichever of them is dragged, the skin can go
that far. Limits are the exact ones of `meshes.safety.Guard`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.engine import Lattice, embed
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.topology import dimension
from ffdstudio.project.placing.estimate import influence, leading
from ffdstudio.project.running import Progress, no_progress

WORK = 2_000_000  # cells looked at in all; of more points than that allows, the ones on top
FEWEST = 4  # control points looked at even in the largest mesh
LITTLE = 0.5  # of what is wanted: less than that is called little


def skin_reach(
    lattice: Lattice,
    free: Mask,
    skin: Array,
    meshes: Sequence[tuple[Mesh, Array]],
    progress: Progress = no_progress,
) -> float:
    """How far a skin can move by one control point before a cell inverts.

    Parameters
    ----------
    lattice : Lattice
        Undeformed.
    free : numpy.ndarray
        Of the lattice's shape: which control points are not frozen.
    skin : numpy.ndarray
        (n, 3) what the lattice is to move.
    meshes : sequence of tuple
        Meshes and where their nodes are; those without cells that can invert set no limit.
    progress : callable, optional
        Called with a fraction and a text; may raise to cancel.

    Returns
    -------
    float
        In the unit of the mesh; infinity where no cell can invert, 0 where no free point
        moves the skin.

    Examples
    --------
    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    >>> mesh = Mesh(square, {"quad": [[0, 1, 2, 3]]}, dimension=2)
    >>> box = Lattice.box([0, 0], [1, 1], shape=(2, 2))
    >>> round(skin_reach(box, np.ones((2, 2), bool), square, [(mesh, square)]), 6)
    1.0
    """
    value = np.where(free, influence(lattice, skin), 0.0)
    points = np.flatnonzero(leading(value).ravel())
    if not len(points):
        return 0.0
    least = np.inf
    asked = [pair for pair in meshes if _has_volume(pair[0])]
    for number, (mesh, places) in enumerate(asked):
        embedding = embed(lattice, places)
        some = points[np.argsort(-value.ravel()[points])][: _affordable(mesh)]
        for done, point in enumerate(some.tolist()):
            progress((number + done / len(some)) / len(asked), "how far the skin can move")
            drag = embedding.drag(lattice, [point])
            limit = _limit(mesh, places, drag.influence, drag.rows, lattice.axes)
            least = min(least, limit * float(value.ravel()[point]))
    return float(least)


def _limit(mesh: Mesh, places: Array, influences: Array, rows: Indices, axes: Array) -> float:
    from ffdstudio.meshes.safety.guard import Guard

    guard = Guard(mesh, places, influences, rows)
    return min(guard.limit(sign * axis) for axis in axes for sign in (1.0, -1.0))


def _has_volume(mesh: Mesh) -> bool:
    return mesh.faces is not None or any(dimension(k) == mesh.dimension for k in mesh.cells)


def _affordable(mesh: Mesh) -> int:
    """How many control points there is time to ask the cells about."""
    return max(FEWEST, WORK // max(1, sum(mesh.counts.values())))


def is_little(reach: float, wanted: float) -> bool:
    """Whether a skin can move by less than half of what one should be able to.

    Examples
    --------
    >>> is_little(0.01, 0.08), is_little(0.07, 0.08), is_little(float("inf"), 0.08)
    (True, False, False)
    """
    return reach < LITTLE * wanted


def reach_sentence(reach: float, wanted: float) -> str:
    """What is said of a reach, for people; nothing where no cell can invert.

    Examples
    --------
    >>> reach_sentence(0.0918, 0.08)
    'The skin can move by about 0.092 before a cell inverts.'
    >>> reach_sentence(0.02, 0.08)
    'The skin can move by about 0.02 only before a cell inverts: a larger margin, or fewer \
control points, give more room.'
    """
    if not np.isfinite(reach):
        return ""
    if reach == 0:
        return "No free control point of this lattice moves the shape."
    little = is_little(reach, wanted)
    more = ": a larger margin, or fewer control points, give more room" if little else ""
    return (
        f"The skin can move by about {reach:.2g}{' only' if little else ''} before a cell "
        f"inverts{more}."
    )
