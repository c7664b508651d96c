"""Where a study is built: what its names stand for, and where its results go."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.optimize.consent import Consent
from ffdstudio.optimize.geometry.contour import Contour
from ffdstudio.optimize.geometry.sections import is_naca, target_contour

if TYPE_CHECKING:
    from ffdstudio.meshes import Mesh


class Moved(NamedTuple):
    """A mesh whose nodes other lattices have moved before the study.

    Attributes
    ----------
    mesh : Mesh
    points : numpy.ndarray
        (n, 3) its nodes as the study finds them.
    """

    mesh: Mesh
    points: np.ndarray


class Pair(NamedTuple):
    """A lattice at rest and as it is when the study begins."""

    rest: Lattice
    current: Lattice


def given(name: str) -> str:
    """How a description speaks of an object that its builder has at hand.

    Examples
    --------
    >>> given("body1"), is_given("<body1>"), is_given("body1.su2")
    ('<body1>', True, False)
    """
    return f"<{name}>"


def is_given(source: str) -> bool:
    """Whether a source is an object at hand, not a file."""
    return source.startswith("<") and source.endswith(">")


@dataclass(frozen=True)
class Place:
    """Where a study is built.

    Attributes
    ----------
    beside : pathlib.Path
        Folder that relative paths start from.
    folder : pathlib.Path, optional
        Of the results: log, evaluations, runs of programs.
    resume : bool
        Go on where the log in that folder ends.
    objects : mapping
        What names in angle brackets stand for, by the name within: a `Moved` mesh, a `Mesh`,
        an array of points, a `Pair` of lattices.
    source : pathlib.Path, optional
        Project or record that the study came inside; None if the user names it.
    consent : Consent
        What may run of a study that did; nothing by default.
    """

    beside: Path = Path()
    folder: Path | None = None
    resume: bool = False
    objects: Mapping[str, Any] = field(default_factory=dict)
    source: Path | None = None
    consent: Consent = field(default_factory=Consent)

    def found(self, source: str) -> Any:
        """Object at hand, or the path of a file; names of sections stay as they are.

        Raises
        ------
        InputError
            If nothing of that name is at hand.
        """
        if is_given(source):
            if source[1:-1] not in self.objects:
                raise InputError(f"there is no {source[1:-1]} at hand")
            return self.objects[source[1:-1]]
        if is_naca(source) and "." not in source:
            return source
        return os.fspath(self.beside / source)

    def contour(self, source: str) -> Contour:
        """Normalised contour of a section: a file, a NACA name, an array at hand."""
        return target_contour(self.found(source))
