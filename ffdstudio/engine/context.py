"""A lattice in its context: at rest, deformed, what of it is held, and what it is called."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Mask
from ffdstudio.engine.frozen import Face, frozen_mask
from ffdstudio.engine.lattice import Lattice
from ffdstudio.errors import InputError


@dataclass(frozen=True, eq=False)
class LatticeContext:
    """What belongs together wherever a lattice is edited, filed or read.

    Attributes
    ----------
    rest, current : Lattice
        At rest and deformed; the same object where nothing was deformed.
    frozen : int
        Outermost layers of control points that do not move, on every face but the open ones.
    open_faces : tuple of tuple of int
        Direction and side, 0 or 1, of faces without frozen layers, such as those where the mesh
        ends at a symmetry plane. The two of a periodic direction, which has no faces, are
        always among them.
    name : str
        What the user calls it; may be empty.

    Raises
    ------
    InputError
        If the two lattices have different directions, or the frozen layers leave nothing.

    Examples
    --------
    >>> box = Lattice.box([0, 0], [1, 1], shape=(3, 3))
    >>> LatticeContext(box, box, frozen=1).frozen_mask.astype(int)
    array([[1, 1, 1],
           [1, 0, 1],
           [1, 1, 1]])
    >>> LatticeContext(box, box, frozen=2)
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: 2 frozen layers on each face leave nothing of 3x3 points
    """

    rest: Lattice
    current: Lattice
    frozen: int = 0
    open_faces: tuple[Face, ...] = ()
    name: str = ""

    def __post_init__(self) -> None:
        for lattice in (self.rest, self.current):
            if not isinstance(lattice, Lattice):
                raise InputError(f"a lattice is needed, got {lattice!r}")
        if self.rest is not self.current and not self.rest.same_space(self.current):
            raise InputError("the lattice at rest and the deformed one differ in degrees or knots")
        object.__setattr__(self, "frozen", _layers(self.frozen))
        faces = (*(tuple(face) for face in self.open_faces), *self.rest.seams)
        object.__setattr__(self, "open_faces", tuple(dict.fromkeys(faces)))
        _ = self.frozen_mask  # it says what is wrong

    @property
    def deformed(self) -> bool:
        """Whether any control point or weight differs from the rest."""
        return self.current is not self.rest and self.current != self.rest

    @property
    def frozen_mask(self) -> Mask:
        """Bool array of the net's shape, true in the frozen layers."""
        return frozen_mask(self.rest.shape, self.frozen, self.open_faces)


def _layers(frozen: object) -> int:
    if isinstance(frozen, bool | np.bool_) or not isinstance(frozen, int | np.integer):
        raise InputError(f"the number of frozen layers must be a whole number, got {frozen!r}")
    layers = int(frozen)
    if layers < 0:
        raise InputError(f"a lattice cannot have {layers} frozen layers")
    return layers
