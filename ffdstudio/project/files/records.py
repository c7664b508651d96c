"""What a project file holds, as plain values: no behaviour, no knowledge of zip or JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ffdstudio.engine import Lattice

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.record import Record


@dataclass
class BodyRecord:
    """A mesh that the project refers to, or carries with it.

    Attributes
    ----------
    name : str
        Name shown to the user, unique in the project.
    path : pathlib.Path
        Absolute path of the mesh; stored relative to the project file.
    visible : bool
    colour : str or None
        ``#rrggbb``, or None for the theme's choice.
    sha256 : str
        Hash of the mesh when the project was saved; empty before that.
    packed : dict of str to bytes, or None
        The mesh's files by name when it travels inside the project, else None.
    settings : dict
        Anything else that JSON and arrays can say; kept as it is.
    """

    name: str
    path: Path
    visible: bool = True
    colour: str | None = None
    sha256: str = ""
    packed: dict[str, bytes] | None = None
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass
class LatticeRecord:
    """A lattice at rest and as it is now.

    Attributes
    ----------
    name : str
        Name shown to the user, unique in the project.
    rest, current : Lattice
        Of the same degrees and knots.
    frozen : int
        Outermost layers of control points that stay where they are, on every face.
    active : bool
        Whether the lattice deforms the bodies.
    settings : dict
        Anything else that JSON and arrays can say; kept as it is.
    """

    name: str
    rest: Lattice
    current: Lattice
    frozen: int = 0
    active: bool = True
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass
class StudyFile:
    """A study with its records.

    Attributes
    ----------
    name : str
    values : dict
        Its description, as in a case file; bodies and lattices of the project by their names.
    records : list of Record
    """

    name: str
    values: dict[str, Any]
    records: list[Record] = field(default_factory=list)


@dataclass(eq=False)
class ProjectFile:
    """Everything in a project file.

    Attributes
    ----------
    bodies : list of BodyRecord
    lattices : list of LatticeRecord
    sections : dict
        Open-ended parts by name (``shapes``, ``studies``, ``journal``, ...): nested dicts and
        lists of strings, numbers, booleans and None, with NumPy arrays and lattices as
        leaves. A section that this version does not know survives a round trip.
    studies : list of StudyFile
    problems : list of str
        What was found wrong with the meshes when the file was opened (missing, changed);
        not stored.
    """

    bodies: list[BodyRecord] = field(default_factory=list)
    lattices: list[LatticeRecord] = field(default_factory=list)
    sections: dict[str, Any] = field(default_factory=dict)
    studies: list[StudyFile] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
