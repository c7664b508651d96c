"""What may move in a case, and its constraints."""

from __future__ import annotations

from typing import Any

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.optimize import constraints as limits
from ffdstudio.optimize.cases.schema import CONSTRAINTS, LIMITS, REFINEMENT, VARIABLES
from ffdstudio.optimize.cases.tables import Key, Table, word
from ffdstudio.optimize.constraints.placed import InChords, OnNodes
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.space import DesignSpace

LETTERS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
FLAT = ("lift", "moment", "thickness", "max-thickness", "area", "nose-radius")


def rules_of(values: Any, shape: Shape, lattice: Lattice) -> Rules:
    """Rules of ``[variables]`` for a lattice."""
    table = Table(values, "variables", VARIABLES)
    words = table["directions"] or (["y"] if shape.flat else ["x", "y", "z"])
    if shape.flat and "z" in words:
        raise table.refuse("directions", "a section moves in x and y")
    for key in ("mirror", "linked"):
        of_lattice(table, key, lattice)
    normal = np.array(table["mirror_normal"])
    if not normal.any():
        raise table.refuse("mirror_normal", "a normal has a length")
    mirror = table["mirror"]
    weights = table["weights"]
    rules = Rules(
        directions=tuple(LETTERS[word] for word in words),
        frozen=table["frozen"],
        fixed=tuple(map(tuple, table["fixed"])),
        mirror=("ijk".index(mirror), tuple(normal.tolist())) if mirror else None,
        linked=tuple("ijk".index(word) for word in table["linked"]),
        weights=None if weights is None else (weights[0], weights[1]),
    )
    if not (rules.movable(lattice.shape) & ~rules.held(lattice.shape)).any():
        raise table.refuse("fixed", "no control point is left that may move")
    return rules


def of_lattice(table: Table, key: str, lattice: Lattice) -> None:
    """Refuse directions that the lattice does not have."""
    has = "ijk"[: lattice.dimension]
    for letter in table[key] or []:
        if letter not in has:
            raise table.refuse(key, f"the lattice has {', '.join(has)}, no direction {letter}")


def refinement_of(values: Any, rules: Rules, lattice: Lattice) -> Refinement:
    """Settings of ``[refinement]`` that can be kept with the rules."""
    table = Table(values, "refinement", REFINEMENT)
    of_lattice(table, "directions", lattice)
    names = table["directions"]
    for name in names:
        if not rules.refinable("ijk".index(name)):
            raise table.refuse(
                "directions", f"{name} is mirrored or linked, so that no knot goes in there"
            )
    if table["row_wise"] and (rules.fixed or rules.mirror or rules.linked):
        raise table.refuse("row_wise", "it knows frozen layers, no fixed, mirrored or linked ones")
    first = DesignSpace.of(lattice, rules).size
    if table["variables"] < first:
        raise table.refuse(
            "variables", f"{table['variables']} are fewer than the {first} of the first lattice"
        )
    taken = {key: table[key] for key in REFINEMENT if key != "directions"}
    return Refinement(axes=tuple("ijk".index(name) for name in names), **taken)


# ---- constraints ---------------------------------------------------------------------------


def constraints_of(values: Any, shape: Shape) -> list[limits.Constraint]:
    """Constraints of ``[[constraints]]``, in chords where the shape is a section."""
    if not isinstance(values, list):
        raise InputError("[[constraints]] takes double brackets, once for each constraint")
    return [_constraint(one, shape) for one in values]


def _constraint(values: Any, shape: Shape) -> limits.Constraint:
    kind, keys = of_kind(values, "constraints", CONSTRAINTS)
    table = Table(values, "constraints", {**keys, **LIMITS})
    if (kind == "volume" and shape.triangles is None) or (kind in FLAT and not shape.flat):
        place = "a surface in 3D" if kind == "volume" else "a section"
        raise InputError(f"[constraints] {kind} needs {place}")
    lower, upper, equal = table["lower"], table["upper"], table["equal"]
    if equal is not None and (lower is not None or upper is not None):
        raise InputError(f"[constraints] {kind}: equal goes without lower and upper")
    if equal is not None:
        lower = upper = equal
    return limits.Constraint(_quantity(kind, table, shape), lower, upper, kind)


def _quantity(kind: str, table: Table, shape: Shape) -> limits.Quantity:
    quantity = _QUANTITIES[kind](table, shape)
    if shape.chord is not None and not shape.chord.unit:
        quantity = InChords(quantity, shape.chord)
    return quantity if shape.contour is None else OnNodes(quantity, shape.contour)


def of_kind(values: Any, name: str, kinds: dict[str, dict[str, Key]]) -> tuple[str, dict[str, Key]]:
    """Kind of a table, and the keys that such a table has."""
    rule = {"kind": word(tuple(kinds))}
    given = {"kind": values["kind"]} if isinstance(values, dict) and "kind" in values else {}
    kind = Table(given if isinstance(values, dict) else values, name, rule)["kind"]
    return kind, {**rule, **kinds[kind]}


def _thickness(table: Table, shape: Shape) -> limits.Quantity:
    thickness = limits.Thickness(table["at"])
    thickness(shape.local)  # refuses what the section does not reach
    return thickness


def _displacement(table: Table, shape: Shape) -> limits.Quantity:
    return limits.Displacement(shape.local, np.array(LETTERS[table["direction"]]))


_QUANTITIES: dict[str, Any] = {
    "lift": lambda table, shape: limits.Lift(table["angle"]),
    "moment": lambda table, shape: limits.Moment(table["angle"]),
    "thickness": _thickness,
    "max-thickness": lambda table, shape: limits.MaxThickness(),
    "area": lambda table, shape: limits.Area(),
    "volume": lambda table, shape: limits.Volume(shape.triangles),
    "nose-radius": lambda table, shape: limits.NoseRadius(),
    "displacement": _displacement,
}
