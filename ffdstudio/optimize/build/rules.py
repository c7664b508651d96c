"""What may move in a study, and how its lattice adapts itself."""

from __future__ import annotations

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.spec.parts import VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.variables.rules import AXES, Rules, Vector
from ffdstudio.optimize.variables.space import DesignSpace

LETTERS = "ijk"


def rules_of(spec: VariablesSpec, shape: Shape, lattice: Lattice) -> Rules:
    """Rules of a description for a lattice."""
    letters = spec.directions or (("y",) if shape.flat else ("x", "y", "z"))
    if shape.flat and "z" in letters:
        raise InputError("[variables] directions: a section moves in x and y")
    _check_axes("variables", "mirror", [spec.mirror] if spec.mirror else [], lattice)
    _check_axes("variables", "linked", spec.linked, lattice)
    rules = Rules(
        directions=tuple(AXES[letter] for letter in letters),
        frozen=spec.frozen,
        fixed=spec.fixed,
        mirror=_mirror(spec, lattice),
        linked=tuple(map(LETTERS.index, spec.linked)),
        weights=spec.weights,
    )
    if not (rules.movable(lattice.shape) & ~rules.held(lattice.shape)).any():
        raise InputError("[variables] fixed: no control point is left that may move")
    return rules


def _mirror(spec: VariablesSpec, lattice: Lattice) -> tuple[int, Vector] | None:
    if spec.mirror is None:
        return None
    axis = LETTERS.index(spec.mirror)
    x, y, z = spec.mirror_normal or lattice.axes[axis].tolist()
    return axis, (float(x), float(y), float(z))


def _check_axes(
    table: str, key: str, letters: tuple[str, ...] | list[str], lattice: Lattice
) -> None:
    """Refuse directions that the lattice does not have."""
    has = LETTERS[: lattice.dimension]
    for letter in letters:
        if letter not in has:
            raise InputError(
                f"[{table}] {key}: the lattice has {', '.join(has)}, no direction {letter}"
            )


def refinement_of(spec: RefinementSpec, rules: Rules, lattice: Lattice) -> Refinement:
    """Settings of a refinement that can be kept with the rules."""
    _check_axes("refinement", "directions", spec.directions, lattice)
    axes = tuple(map(LETTERS.index, spec.directions))
    for axis in axes:
        if not rules.refinable(axis):
            raise InputError(
                f"[refinement] directions: {LETTERS[axis]} is mirrored or linked, so that no "
                "knot goes in there"
            )
    if spec.row_wise and (rules.fixed or rules.mirror or rules.linked):
        raise InputError(
            "[refinement] row_wise: it knows frozen layers, no fixed, mirrored or linked ones"
        )
    return Refinement(
        spec.indicator, axes, spec.variables, spec.positions, spec.insertions, spec.row_wise,
        spec.iterations, spec.slope, spec.share, relocate=spec.relocate, coarsen=spec.coarsen,
        rounds=spec.rounds,
    )  # fmt: skip


def check_growth(refinement: Refinement, rules: Rules, lattice: Lattice) -> None:
    """Refuse a number of variables at the end that the first lattice exceeds."""
    first = DesignSpace.of(lattice, rules).size
    if refinement.variables < first:
        raise InputError(
            f"[refinement] variables: {refinement.variables} are fewer than the {first} of the "
            "first lattice"
        )
