"""Limits of a drag in the solver's terms."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """What a drag must keep; None is no limit.

    Attributes
    ----------
    non_orthogonality : float or None
        Degrees, as in checkMesh.
    face_skewness : float or None
        As in checkMesh.
    first_layer : float or None
        Largest change of the first layer's height, as a fraction of the undeformed one.
    """

    non_orthogonality: float | None = None
    face_skewness: float | None = None
    first_layer: float | None = None


INVERSION = Limits()
PRESETS = {
    "inversion": INVERSION,
    "OpenFOAM": Limits(non_orthogonality=70.0, face_skewness=4.0),
    "boundary layer": Limits(70.0, 4.0, first_layer=0.1),
}


@dataclass(frozen=True)
class Stop:
    """Where a drag has to end.

    Attributes
    ----------
    amplitude : float
        Multiple of the direction; infinity if nothing stands in the way.
    reason : str
        "inversion" or the name of the limit that is met; empty if there is none.
    cell : int
        The cell that stops the drag, -1 if there is none.
    """

    amplitude: float
    reason: str = ""
    cell: int = -1
