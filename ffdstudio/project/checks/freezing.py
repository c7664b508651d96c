"""Which layers of control points to freeze, because mesh lies on both sides of a lattice's face.

Moving the outermost layer of control points moves the mesh up to the face but not what lies
beyond it: the cells there are sheared. With k frozen layers the displacement and its first k - 1
derivatives vanish at the face: continuity of order k - 1 (piecewise polynomials with clamped
knots).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.frozen import leaves_some
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.measures.blocks import blocks_of

Face = tuple[int, int]  # direction, and 0 for its beginning or 1 for its end
SLACK = 1e-9  # of the diagonal: what is nearer to a face than that lies on it
ENOUGH = 300_000  # cells looked at; of more, every so many
INSIDE = np.uint8(64)


def crossed_faces(lattice: Lattice, mesh: Mesh, points: Array | None = None) -> list[Face]:
    """Faces of a box lattice that run through the mesh.

    Parameters
    ----------
    lattice : Lattice
        Undeformed.
    mesh : Mesh
    points : numpy.ndarray, optional
        (n, 3) where the nodes are; by default as in the mesh.

    Returns
    -------
    list of tuple
        Direction and side, 0 or 1, of each face that cuts a cell which has a node in the
        lattice: some of that cell would move and some not.

    Examples
    --------
    >>> mesh = Mesh([[0, 0, 0], [2, 0, 0], [0, 2, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    >>> crossed_faces(Lattice.box([-1, -1], [1, 3], (3, 3), (2, 2)), mesh)
    [(0, 1)]
    """
    places = mesh.points if points is None else points
    codes = _codes(lattice, places)
    found = 0
    for nodes in _cells(mesh):
        step = 1 + len(nodes) // ENOUGH
        code = np.bitwise_or.reduce(codes[nodes[::step]], axis=1)
        found |= int(np.bitwise_or.reduce(code[(code & INSIDE) > 0], initial=np.uint8(0)))
    sides = range(2 * lattice.dimension)
    return [(bit // 2, bit % 2) for bit in sides if found & (1 << bit)]


def _codes(lattice: Lattice, points: Array) -> NDArray[np.uint8]:
    """One bit for each face that a point lies beyond, and one if it lies in the lattice."""
    slack = SLACK * lattice.diagonal
    local = points @ lattice.axes.T
    low, high = lattice.domain.T
    code = np.zeros(len(points), dtype=np.uint8)
    for axis in range(lattice.dimension):
        code |= (local[:, axis] < low[axis] - slack).astype(np.uint8) << np.uint8(2 * axis)
        code |= (local[:, axis] > high[axis] + slack).astype(np.uint8) << np.uint8(2 * axis + 1)
    return np.where(code == 0, INSIDE, code)


def _cells(mesh: Mesh) -> list[NDArray[np.int64]]:
    """Blocks (k, nodes); without the means that stand for polyhedra: their nodes are enough."""
    count = len(mesh.points)
    blocks = [block.nodes for block in blocks_of(mesh).blocks]
    return [nodes[:, (nodes < count).all(axis=0)] for nodes in blocks if len(nodes)]


def suggested(
    lattice: Lattice, meshes: Sequence[tuple[Mesh, Array]], open_faces: Iterable[Face] = ()
) -> tuple[int, list[Face]]:
    """Layers to freeze by default, and the faces that are the reason.

    Parameters
    ----------
    lattice : Lattice
        Undeformed.
    meshes : sequence of tuple
        Meshes, and where their nodes are.
    open_faces : iterable of tuple
        Faces where the mesh ends at a plane: nothing is to be frozen there.
    """
    faces = sorted(
        {face for mesh, points in meshes for face in crossed_faces(lattice, mesh, points)}
    )
    room = leaves_some(lattice.shape, 1, open_faces)
    return (1 if faces and room else 0), faces


def is_box(lattice: Lattice) -> bool:
    """Whether the faces of a lattice at rest are those of the box of its parameters."""
    net = lattice.control_points @ lattice.axes.T
    low, high = lattice.domain.T
    slack = 1e-6 * lattice.diagonal
    for axis in range(lattice.dimension):
        layers = np.moveaxis(net[..., axis], axis, 0)
        ends = np.abs(layers[0] - low[axis]).max(), np.abs(layers[-1] - high[axis]).max()
        if max(ends) > slack:
            return False
    return True


def face_name(face: tuple[int, ...]) -> str:
    """Name of a face for people.

    Examples
    --------
    >>> face_name((1, 0))
    'j min'
    """
    return f"{'ijk'[face[0]]} {('min', 'max')[face[1]]}"


def face_names(faces: Sequence[Face]) -> str:
    """Names of faces for people.

    Examples
    --------
    >>> face_names([(0, 0), (0, 1), (1, 1)])
    'i min, i max and j max'
    """
    names = [face_name(face) for face in faces]
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def continuity(layers: int) -> str:
    """Continuity across a face with frozen layers, for people.

    Examples
    --------
    >>> continuity(0), continuity(2)
    ('not continuous', 'C1')
    """
    return f"C{layers - 1}" if layers else "not continuous"


def advice(
    shape: tuple[int, ...], faces: Sequence[Face], layers: int, open_faces: Iterable[Face] = ()
) -> str:
    """Why layers are frozen, or what happens if they are not; nothing without mesh beyond.

    Examples
    --------
    >>> advice((4, 4), [(0, 1)], 1)
    'Mesh lies on both sides of i max: the outermost layer stays frozen, so that the shape is C0 \
there. Layers are frozen on all faces alike.'
    >>> advice((4, 4), [], 1)
    ''
    """
    if not faces:
        return ""
    where = f"Mesh lies on both sides of {face_names(faces)}"
    if not layers:
        return f"{where}: moving the outermost points would shear the cells there. Freeze a layer."
    room = layers < 3 and leaves_some(shape, layers + 1, open_faces)
    more = f"; {layers + 1} layers give {continuity(layers + 1)}" if room else ""
    frozen = "the outermost layer stays" if layers == 1 else f"{layers} layers stay"
    kept, alike = continuity(layers), _alike(shape, faces, open_faces)
    return f"{where}: {frozen} frozen, so that the shape is {kept} there{more}.{alike}"


def _alike(shape: tuple[int, ...], faces: Sequence[Face], open_faces: Iterable[Face]) -> str:
    """Which other faces have frozen layers, too."""
    free = sorted(open_faces)
    if len(faces) == 2 * len(shape) - len(free):
        return ""
    but = f"but {face_names(free)}" if free else "alike"
    return f" Layers are frozen on all faces {but}."


def torn_faces(rest: Lattice, current: Lattice, mesh: Mesh) -> list[Face]:
    """Faces with mesh on both sides whose outermost control points have moved or changed weight.

    Smoothness ends there. Nothing is said of nets that are no boxes.
    """
    changed = (rest.control_points != current.control_points).any(axis=-1)
    changed |= rest.weights != current.weights
    outer = [
        (axis, side)
        for axis in range(rest.dimension)
        for side in (0, 1)
        if np.take(changed, -side, axis=axis).any()
    ]
    if not outer or not is_box(rest):
        return []
    crossed = crossed_faces(rest, mesh)
    return [face for face in outer if face in crossed]
