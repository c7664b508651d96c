"""What a lattice file holds, and whether going through it keeps everything."""

from __future__ import annotations

from dataclasses import dataclass, field

from ffdstudio.engine.context import LatticeContext
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


@dataclass(frozen=True, kw_only=True)
class LatticeFile(LatticeContext):
    """Content of a lattice file: a `LatticeContext`, and what the file says besides.

    Attributes
    ----------
    units : str
        Unit of length as the file names it; may be empty.
    exactness : Exactness
        Of the import.
    format : str
        Name of the file's format.
    blocks : tuple of str
        Names of all lattices in the file, of which this is one.
    notes : tuple of str
        What the file says besides and is not taken over, and how this lattice belongs to others
        that do not follow it: to be told before anything moves.

    Examples
    --------
    >>> from ffdstudio.engine import Lattice
    >>> box = Lattice.box([0, 0], [1, 1], shape=(4, 4))
    >>> LatticeFile(box, box, frozen=1, units="m").frozen
    1
    >>> LatticeFile(box, box, frozen=2)
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: 2 frozen layers on each face leave nothing of 4x4 points
    """

    units: str = ""
    exactness: Exactness = field(default_factory=Exactness)
    format: str = ""
    blocks: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.units, str):
            raise InputError(f"the units of a lattice must be a text, got {self.units!r}")
