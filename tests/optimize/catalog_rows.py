"""A study for every row of the catalog, with each field set to something of its own."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import msgspec
from msgspec import inspect

from ffdstudio.optimize.catalog.constraints import CONSTRAINTS
from ffdstudio.optimize.catalog.indicators import INDICATORS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.metrics import METRICS
from ffdstudio.optimize.catalog.objectives import OBJECTIVES
from ffdstudio.optimize.objectives.contour import ContourSpec
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.study import StudySpec

LEAVE = {"lower", "upper", "equal", "pressures", "deformed", "file", "room"}


def value_of(kind: inspect.Type, number: int) -> Any:
    """A value of a type that is no default of anything."""
    while isinstance(kind, inspect.Metadata):
        kind = kind.type
    if isinstance(kind, inspect.UnionType):
        return value_of(next(k for k in kind.types if not isinstance(k, inspect.NoneType)), number)
    if isinstance(kind, inspect.IntType):
        return min((kind.ge or 0) + number, kind.le or 10**6)
    if isinstance(kind, inspect.FloatType):
        low = kind.gt if kind.gt is not None else kind.ge if kind.ge is not None else 0.0
        high = kind.le if kind.le is not None else kind.lt if kind.lt is not None else low + 1.0
        return low + (high - low) * (number / 70 + 0.1)
    if isinstance(kind, inspect.BoolType):
        return number % 2 == 0
    if isinstance(kind, inspect.LiteralType):
        return kind.values[number % len(kind.values)]
    if isinstance(kind, inspect.VarTupleType):
        return (value_of(kind.item_type, number),)
    if isinstance(kind, inspect.TupleType):
        return tuple(value_of(k, number + n) for n, k in enumerate(kind.item_types))
    return f"file {number}.dat"


def filled(kind: Any, **fixed: Any) -> Any:
    """A table with every field set; those in `LEAVE` stay."""
    given = dict(fixed)
    for number, field in enumerate(msgspec.structs.fields(kind), start=1):
        if field.name not in given and (field.required or field.name not in LEAVE):
            given[field.name] = value_of(inspect.type_info(field.type), number)
    return kind(**given)


def study(**parts: Any) -> StudySpec:
    """A plain study with other parts."""
    plain = {
        "shape": ShapeSpec(source="foil.su2", marker="foil"),
        "lattice": LatticeSpec(shape=(5, 2)),
        "objective": ContourSpec(target="naca2412"),
    }
    return StudySpec(**plain | parts)


def _constraint(kind: Any) -> Any:
    return filled(kind, lower=0.1 + 0.2, upper=0.5)


def _every() -> dict[str, StudySpec]:
    metrics, indicators = cycle(METRICS), cycle(INDICATORS)
    found = {f"objective {k.kind()}": study(objective=filled(k)) for k in OBJECTIVES}
    for kind in CONSTRAINTS:
        two = (_constraint(kind), filled(kind, equal=1 / 3))
        found[f"constraint {kind.kind()}"] = study(constraints=two)
    for kind in METHODS:
        found[f"method {kind.kind()}"] = study(method=filled(kind, metric=next(metrics).name))
    for number in range(len(METRICS)):
        method = METHODS[0](metric=METRICS[number].name)
        found[f"metric {METRICS[number].name}"] = study(method=method)
    for one in INDICATORS:
        refinement = filled(RefinementSpec, indicator=next(indicators).name)
        found[f"indicator {one.name}"] = study(refinement=refinement)
    box = filled(LatticeSpec, shape=(6, 3), degrees=(3, 2), lower=(0.0, 0.1), upper=(1.0, 0.3),
                 margin=(0.1, 0.2))  # fmt: skip
    found["every part"] = study(
        shape=filled(ShapeSpec, mesh=("a.su2", "b.su2")), lattice=box,
        variables=filled(VariablesSpec), budget=filled(BudgetSpec),
    )  # fmt: skip
    return found


EVERY = _every()
