"""What a comparison does: everything that could be tuned, written down before it runs."""

from __future__ import annotations

import hashlib
import json
import os
import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes
from ffdstudio.optimize.compare.rivals import RIVALS
from ffdstudio.optimize.refine.choice import Refinement

VERSION = 1  # of the protocol's meaning: results of another one are not taken over
ADAPTIVE = "adaptive"


@dataclass(frozen=True)
class Protocol:
    """Settings of a comparison, the same for all targets.

    Attributes
    ----------
    source : str
        Where everybody begins; it gets the target's thickness at the trailing edge.
    variables : tuple of int
        Numbers of variables that are compared.
    rows : int
        Of the lattices.
    start : int
        Columns that the adaptive lattice begins with.
    panels, angles : tuple
        Least and largest; each target gets an odd number of nodes and an angle drawn between.
    count : int
        Targets to draw from the folder.
    seed : int
        Of what is drawn.
    evaluations : int
        For everybody.
    metric : str
        In which everybody is whitened.
    rivals : tuple of str
        Static parameterizations out of `RIVALS`.
    levels : tuple of float
        Fractions of the first cost at which solves are counted.
    """

    source: str = "naca0012"
    variables: tuple[int, ...] = (24, 40)
    rows: int = 2
    start: int = 5
    panels: tuple[int, int] = (121, 401)
    angles: tuple[float, float] = (-2.0, 6.0)
    count: int = 100
    seed: int = 2026
    evaluations: int = 400
    metric: str = "flow"
    rivals: tuple[str, ...] = ("greville", "cosine", "uniform", "mean", "squares", "cst")
    levels: tuple[float, ...] = (1e-3, 1e-4)

    def __post_init__(self) -> None:
        for name in self.rivals:
            if name not in RIVALS:
                raise InputError(f"there is no rival {name!r}, only {', '.join(RIVALS)}")
        if not self.rivals:
            raise InputError("a comparison needs a rival")
        if min(self.variables, default=0) < self.start * self.rows:
            raise InputError(f"an adaptive lattice begins with {self.start * self.rows} variables")
        if not 21 <= self.panels[0] <= self.panels[1]:
            raise InputError("panels are two numbers in order, from 21 on")
        if not -90 <= self.angles[0] <= self.angles[1] <= 90:
            raise InputError("angles are two numbers of degrees in order")
        if min(self.count, self.evaluations, self.start - 3, self.rows - 1) < 1:
            raise InputError("counts are 1 at least, columns at the start 4, rows 2")

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Self:
        """Protocol of a TOML file with a table [compare].

        Raises
        ------
        InputError
            If it is no such file; the message names what is wrong.
        """
        try:
            tables = tomllib.loads(read_bytes(path).decode())
            return cls.of(tables.pop("compare", {}), tables)
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise InputError(f"{os.fspath(path)} is no TOML file: {error}") from error
        except InputError as error:
            raise InputError(f"{os.fspath(path)}: {error}") from error

    @classmethod
    def of(cls, table: dict[str, Any], others: Sequence[str] | dict[str, Any] = ()) -> Self:
        """Protocol of a table of values.

        Examples
        --------
        >>> Protocol.of({"count": 3}).count
        3
        """
        defaults = asdict(cls())
        unknown = [*others, *(set(table) - set(defaults))]
        if unknown:
            raise InputError(
                f"a comparison knows no {unknown[0]!r}; [compare] knows {', '.join(defaults)}"
            )
        return cls(**{name: _like(name, value, defaults[name]) for name, value in table.items()})

    def refinement(self, variables: int) -> Refinement:
        """How the adaptive lattice is refined."""
        return Refinement.for_flows(variables)

    def to_json(self) -> dict[str, Any]:
        """Settings as written beside the results."""
        return {"version": VERSION, **asdict(self), "refinement": asdict(self.refinement(1))}

    @property
    def digest(self) -> str:
        """What tells results of other settings apart; the number of targets is none of it."""
        values = {k: v for k, v in self.to_json().items() if k != "count"}
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]


def _like(name: str, value: Any, default: Any) -> Any:
    """A value of the kind of the default, or a sentence."""
    many = isinstance(default, tuple)
    items = value if many and isinstance(value, list) else [value]
    kind = type(default[0] if many else default)
    kinds = (int, float) if kind is float else (kind,)
    right = all(isinstance(v, kinds) and not isinstance(v, bool) for v in items)
    if not right or many != isinstance(value, list) or (len(items) < 2 and name in TWO):
        raise InputError(f"{name} cannot be {value!r}; it is {default!r} by default")
    return tuple(items) if many else value


TWO = ("panels", "angles")


class Case(NamedTuple):
    """A target with what was drawn for it."""

    path: Path
    panels: int
    angle: float


def drawn(files: Sequence[Path], protocol: Protocol) -> list[Case]:
    """All targets in the order of a lottery that knows nothing but their names and the seed.

    Examples
    --------
    >>> [case.panels % 2 for case in drawn([Path("a.dat"), Path("b.dat")], Protocol())]
    [1, 1]
    """

    def ticket(path: Path) -> bytes:
        return hashlib.sha256(f"{protocol.seed}:{path.name}".encode()).digest()

    found = []
    for path in sorted(files, key=ticket):
        rng = np.random.default_rng(list(ticket(path)))
        low, high = (count // 2 for count in protocol.panels)
        panels = 2 * int(rng.integers(low, high + 1)) + 1
        found.append(Case(path, panels, round(float(rng.uniform(*protocol.angles)), 2)))
    return found
