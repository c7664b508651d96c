"""What a lattice file holds, and whether going through it keeps everything."""

from __future__ import annotations

from dataclasses import dataclass, field

from ffdstudio.engine import Lattice
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
        Direction and side, 0 or 1, of the faces without frozen layers.
    """

    rest: Lattice
    current: Lattice
    frozen: int = 0
    units: str = ""
    exactness: Exactness = field(default_factory=Exactness)
    format: str = ""
    blocks: tuple[str, ...] = ()
    open_faces: tuple[tuple[int, ...], ...] = ()

    def __post_init__(self) -> None:
        if not self.rest.same_space(self.current):
            raise InputError("the lattice at rest and the deformed one differ in degrees or knots")
        if self.frozen < 0:
            raise InputError(f"a lattice cannot have {self.frozen} frozen layers")
        every = [(axis, side) for axis in range(self.rest.dimension) for side in (0, 1)]
        if not set(self.open_faces) <= set(every):
            raise InputError("an open face is a direction, from 0 on, and a side, 0 or 1")
