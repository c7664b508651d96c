"""Where a mesh ends at a plane, the face of a lattice goes: onto the plane, without a margin.

The nodes on the plane then lie on the lattice's face and depend on the control points there
alone; those slide in the plane (`plane_constraints`), and so it stays plane.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine.boxes import Frame
from ffdstudio.meshes.planes import Plane
from ffdstudio.project.checks.freezing import Face, face_names

SLACK = 1e-9  # of the box's diagonal
STRAIGHT = 1e-9  # of a right angle between a direction of the lattice and a plane


def seated(
    frame: Frame, bounds: tuple[Array, Array], nodes: Array, planes: Sequence[Plane]
) -> tuple[Array, Array, dict[Face, str]]:
    """Bounds of a box with faces on the planes that its margin would reach over.

    Parameters
    ----------
    frame : Frame
    bounds : tuple of numpy.ndarray
        Lower and upper corner, (3,) each, in the frame, with the margin.
    nodes : numpy.ndarray
        (n, 3) what the box is for.
    planes : sequence of Plane
        Where the mesh ends.

    Returns
    -------
    tuple
        Lower and upper corner, and the marker of the plane by face.

    Examples
    --------
    >>> plane = Plane("SYM", "symmetry", np.arange(0), np.array([0.0, 1, 0]), 0.0)
    >>> nodes = np.array([[0, 0, 0], [1, 2, 1.0]])
    >>> frame = Frame.of(None, 3)
    >>> seated(frame, frame.bounds(nodes, 0.5), nodes, [plane])
    (array([-0.5,  0. , -0.5]), array([1.5, 3. , 1.5]), {(1, 0): 'SYM'})
    """
    lower, upper = bounds[0].copy(), bounds[1].copy()
    slack = SLACK * float(np.linalg.norm(upper - lower))
    found: dict[Face, str] = {}
    for axis, direction in enumerate(frame.axes):
        local = nodes @ direction
        low, high = float(local.min()), float(local.max())
        for plane in planes:
            along = float(direction @ plane.normal)
            if abs(along) < 1 - STRAIGHT:
                continue
            at = float(plane.offset * np.sign(along))
            if lower[axis] - slack <= at <= low + slack and high > at + slack:
                lower[axis], found[axis, 0] = at, plane.name
            if high - slack <= at <= upper[axis] + slack and low < at - slack:
                upper[axis], found[axis, 1] = at, plane.name
    return lower, upper, found


def seat_sentence(faces: dict[Face, str]) -> str:
    """What has been done, for people; nothing if nothing has.

    Examples
    --------
    >>> seat_sentence({(1, 0): "SYMMETRY"})
    'The face j min lies on SYMMETRY, without a margin: control points there slide in its plane.'
    """
    parts = []
    for name in dict.fromkeys(faces.values()):
        chosen = [face for face, marker in faces.items() if marker == name]
        many = len(chosen) > 1
        parts.append(
            f"The face{'s' * many} {face_names(chosen)} lie{'s' * (not many)} on {name}, without a "
            "margin: control points there slide in its plane."
        )
    return " ".join(parts)


def faces_on(frame: Frame, lower: Array, upper: Array, planes: Sequence[Plane]) -> dict[Face, str]:
    """Faces of a box that lie on planes, and the marker of each: for bounds that were typed.

    Examples
    --------
    >>> plane = Plane("SYM", "symmetry", np.arange(0), np.array([0.0, 1, 0]), 0.0)
    >>> faces_on(Frame.of(None, 3), np.zeros(3), np.ones(3), [plane])
    {(1, 0): 'SYM'}
    """
    slack = SLACK * float(np.linalg.norm(upper - lower))
    found: dict[Face, str] = {}
    for axis, direction in enumerate(frame.axes):
        for plane in planes:
            along = float(direction @ plane.normal)
            at = float(plane.offset * np.sign(along))
            for side, end in enumerate((lower[axis], upper[axis])):
                if abs(along) >= 1 - STRAIGHT and abs(end - at) <= slack:
                    found[axis, side] = plane.name
    return found
