"""What a deformation must not do to boundaries: leave their plane, part partners."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.pairs import Pair, pairs_of
from ffdstudio.meshes.planes import Plane, planes_of, size_of

INEXACT = 10.0  # times the misfit of partners at rest, of the mesh's size: error of their turn
NOISE = 1e-10  # of the mesh's size: a smaller motion is none


def broken(mesh: Mesh, points: Array) -> list[str]:
    """Tell which plane boundaries of a mesh are no longer plane, and which pairs no longer fit.

    Parameters
    ----------
    mesh : Mesh
        Undeformed.
    points : numpy.ndarray
        (n, 3) its nodes as deformed.

    Returns
    -------
    list of str
        A sentence without full stop for each, with the marker, the number of nodes and the
        largest deviation in the unit of the mesh.

    Examples
    --------
    >>> line = {"line": [[0, 1]]}
    >>> cells = {"triangle": [[0, 1, 2]]}
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], cells, {"SYM": line}, dimension=2)
    >>> broken(mesh, mesh.points + [[0, 0, 0], [0.5, 0.25, 0], [0, 0, 0]])
    ['SYM is no longer planar: 1 of 2 nodes leaves it, by up to 0.25']
    """
    slack = NOISE * size_of(mesh)
    found = [_bent(mesh, plane, points, slack) for plane in planes_of(mesh)]
    found += [_parted(mesh, pair, points - mesh.points) for pair in pairs_of(mesh)]
    return [sentence for sentence in found if sentence]


def _bent(mesh: Mesh, plane: Plane, points: Array, slack: float) -> str:
    step = points[plane.nodes] - mesh.points[plane.nodes]
    off = np.abs(step @ plane.normal)
    bad = int((off > slack).sum())
    if not bad:
        return ""
    leave = "leaves" if bad == 1 else "leave"
    return (
        f"{plane.name} is no longer planar: {bad} of {len(off)} nodes {leave} it, "
        f"by up to {off.max():.3g}"
    )


def _parted(mesh: Mesh, pair: Pair, step: Array) -> str:
    """Partners whose displacements do not correspond: distances at rest do not matter.

    They only tell how exactly the turn is known, which is less in a file of single precision.
    """
    size = size_of(mesh)
    inexact = INEXACT * float(pair.misses(mesh.points).max(initial=0.0)) / size if size else 0.0
    slack = NOISE * size + min(inexact, 1e-3) * np.linalg.norm(step[pair.first], axis=1)
    miss = np.linalg.norm(step[pair.second] - step[pair.first] @ pair.turn.T, axis=1)
    bad = int((miss > slack).sum())
    if not bad:
        return ""
    if pair.opposite:
        what = "front and back of " + " and ".join(pair.names) + " are no longer opposite"
    else:
        what = " and ".join(pair.names) + " no longer match"
    have = "has its partner" if bad == 1 else "have their partners"
    return f"{what}: {bad} of {len(miss)} nodes {have} elsewhere, by up to {miss.max():.3g}"
