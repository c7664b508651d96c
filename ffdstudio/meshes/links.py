"""Nodes that the file of a mesh itself states to be partners."""

from __future__ import annotations

from dataclasses import dataclass

from ffdstudio.aliases import Indices


@dataclass(frozen=True, eq=False)
class Link:
    """Nodes on one side of a periodic or abutting boundary with those on the other.

    Attributes
    ----------
    names : tuple of str
        Of the two sides as the file calls them; one name if both are parts of it.
    first, second : numpy.ndarray
        (k,) node indices; ``first[i]`` and ``second[i]`` are partners.
    """

    names: tuple[str, ...]
    first: Indices
    second: Indices
