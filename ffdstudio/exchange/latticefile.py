"""What a lattice file holds, and whether going through it keeps everything."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.engine.frozen import frozen_mask
from ffdstudio.errors import InputError


@dataclass(frozen=True)
class Exactness:
    """Whether an import or export is exact, else why not and what would be.

    Attributes
    ----------
    exact : bool
        Whether the map R(u, v, w) is the same on both sides, but for its parameters' range.
    reason : str
        What differs, or what was done to make it exact; may be empty.
    remedy : str
        The nearest exact thing; may be empty.

    Examples
    --------
    >>> print(Exactness(False, "weights are lost", "use .lattice.json"))
    not exact: weights are lost (use .lattice.json)
    """

    exact: bool = True
    reason: str = ""
    remedy: str = ""

    def __str__(self) -> str:
        text = "exact" if self.exact else "not exact"
        text += f": {self.reason}" if self.reason else ""
        return text + (f" ({self.remedy})" if self.remedy else "")


@dataclass(frozen=True)
class LatticeFile:
    """Content of a lattice file.

    Attributes
    ----------
    rest, current : Lattice
        At rest and deformed; the same object where the file holds one net only.
    frozen : int
        Outermost layers of control points that do not move, on every face but the open ones.
    units : str
        Unit of length as the file names it; may be empty.
    exactness : Exactness
        Of the import.
    format : str
        Name of the file's format.
    blocks : tuple of str
        Names of all lattices in the file, of which this is one.
    open_faces : tuple of tuple of int
        Direction and side, 0 or 1, of the faces without frozen layers; the two of a periodic
        direction, which has no faces, are always among them.
    notes : tuple of str
        What the file says besides and is not taken over, and how this lattice belongs to others
        that do not follow it: to be told before anything moves.

    Examples
    --------
    >>> box = Lattice.box([0, 0], [1, 1], shape=(4, 4))
    >>> LatticeFile(box, box, frozen=1, units="m").frozen
    1
    >>> LatticeFile(box, box, frozen=2)
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: 2 frozen layers on each face leave nothing of 4x4 points
    """

    rest: Lattice
    current: Lattice
    frozen: int = 0
    units: str = ""
    exactness: Exactness = field(default_factory=Exactness)
    format: str = ""
    blocks: tuple[str, ...] = ()
    open_faces: tuple[tuple[int, ...], ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for lattice in (self.rest, self.current):
            if not hasattr(lattice, "same_space"):
                raise InputError(f"a lattice is needed, got {lattice!r}")
        if not self.rest.same_space(self.current):
            raise InputError("the lattice at rest and the deformed one differ in degrees or knots")
        if not isinstance(self.units, str):
            raise InputError(f"the units of a lattice must be a text, got {self.units!r}")
        object.__setattr__(self, "frozen", _layers(self.frozen))
        faces = tuple(dict.fromkeys((*map(tuple, self.open_faces), *self.rest.seams)))
        object.__setattr__(self, "open_faces", faces)
        frozen_mask(self.rest.shape, self.frozen, self.open_faces)  # it says what is wrong


def _layers(frozen: object) -> int:
    if isinstance(frozen, bool | np.bool_) or not isinstance(frozen, int | np.integer):
        raise InputError(f"the number of frozen layers must be a whole number, got {frozen!r}")
    layers = int(frozen)
    if layers < 0:
        raise InputError(f"a lattice cannot have {layers} frozen layers")
    return layers
