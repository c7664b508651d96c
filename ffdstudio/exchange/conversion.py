"""Making a lattice fit a format that cannot say everything: exactly if possible.

1. Every format states in `Rules` what it can express; `obstacles` says what stands against it.
2. Some obstacles go without changing the shape: a periodic direction gets ends at its seam,
   knots are inserted until they are equally spaced, a lattice of two directions becomes a slab.
3. What is left can only be resampled: interpolated at the Greville points of a space that
   the format has, with the largest difference measured and stated. That changes the space of
   functions and nothing else: a wrong number of directions or wrong axes stay obstacles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.basis import basis
from ffdstudio.engine.knots import breaks, clamped_uniform, greville
from ffdstudio.engine.transfer import along
from ffdstudio.errors import InputError
from ffdstudio.exchange.latticefile import Exactness, LatticeFile

MAX_SPANS = 200  # of a direction made uniform: more means the knots have no common measure


def _any_degree(count: int, degree: int) -> int:
    return degree


@dataclass(frozen=True)
class ConversionRules:
    """What a format can express; `degree` gives the degree it uses for a count and a degree."""

    title: str
    dimensions: tuple[int, ...] = (3,)
    uniform: bool = False
    weights: bool = True
    degree: Callable[[int, int], int] = _any_degree
    one_net: bool = True


def adapted(
    content: LatticeFile, rules: ConversionRules, adapt: str
) -> tuple[LatticeFile, Exactness]:
    """Content that the format can express, and how exact that is.

    Raises
    ------
    InputError
        If `adapt` does not allow what would be needed.
    """
    rest, current = content.rest, content.current
    faults = obstacles(content, rules)
    changes: list[str] = []
    if faults and adapt != "refuse":
        rest, current, changes = _without_change(rest, current, rules)
        faults = obstacles(LatticeFile(rest, current), rules)
    error = None
    if faults and adapt == "resample" and not _frame_faults(rest, rules):
        old = current
        rest, current = (_resampled(lattice, rules) for lattice in (rest, current))
        error = _difference(old, current)
        faults = []
    if faults:
        remedy = _remedy(content, rules)
        raise InputError(f"{rules.title} cannot express this lattice: {faults[0]}; {remedy}")
    return LatticeFile(rest, current), _exactness(content, rules, changes, error)


def obstacles(content: LatticeFile, rules: ConversionRules) -> list[str]:
    """List what keeps a format from expressing the lattice; empty if nothing does."""
    lattice, found = content.rest, _frame_faults(content.rest, rules)
    weighted = any((net.weights != 1).any() for net in (content.rest, content.current))
    if weighted and not rules.weights:
        found.append("its weights are not all 1")
    if lattice.frame is not None:
        found.append("at rest it follows a cylinder, which a spline only comes near to")
    for k, name in enumerate("ijk"[: lattice.dimension]):
        p, n = lattice.degrees[k], lattice.shape[k]
        if rules.degree(n, p) != p:
            found.append(f"degree {p} in direction {name} should be {rules.degree(n, p)}")
        if lattice.periodic[k]:
            found.append(f"direction {name} is periodic: it closes without a seam")
        elif rules.uniform and not is_uniform(lattice, k):
            found.append(f"the knots in direction {name} are not equally spaced")
    return found


def _frame_faults(lattice: Lattice, rules: ConversionRules) -> list[str]:
    """Obstacles that another space of functions would not remove."""
    d, found = lattice.dimension, []
    if d not in rules.dimensions:
        allowed = " or ".join(map(str, rules.dimensions))
        found.append(f"it has {d} direction{'s' * (d > 1)}, not {allowed}")
    if d < 3 and not np.array_equal(lattice.axes, np.eye(3)[:d]):
        found.append("its directions are not the first coordinate axes")
    return found


def is_uniform(lattice: Lattice, axis: int) -> bool:
    """Whether all knot spans of a direction are simple and equally long."""
    u = lattice.knots[axis]
    ideal = clamped_uniform(lattice.shape[axis], lattice.degrees[axis], u[0], u[-1])
    return bool(np.allclose(u, ideal, rtol=0, atol=1e-12 * (u[-1] - u[0])))


def slab(lattice: Lattice) -> Lattice:
    """Lattice of two directions as one of three, from -0.5 to 0.5 along their normal."""
    normal = np.cross(*lattice.axes)
    layers = [lattice.control_points + side * normal for side in (-0.5, 0.5)]
    return Lattice(
        [*lattice.degrees, 1],
        [*lattice.knots, [-0.5, -0.5, 0.5, 0.5]],
        np.stack(layers, axis=2),
        np.stack([lattice.weights] * 2, axis=2),
        np.vstack([lattice.axes, normal]),
    )


def _without_change(
    rest: Lattice, current: Lattice, rules: ConversionRules
) -> tuple[Lattice, Lattice, list[str]]:
    changes = [
        f"direction {'ijk'[k]} got ends at its seam" for k, on in enumerate(rest.periodic) if on
    ]
    rest, current = rest.clamped(), current.clamped()
    if rest.frame is not None:
        return rest, current, changes
    if rest.dimension == 2 and rules.dimensions == (3,):
        rest, current = slab(rest), slab(current)
        changes.append("two directions became a slab of thickness 1")
    for k in range(rest.dimension):
        new = _missing_knots(rest, k) if rules.uniform and not is_uniform(rest, k) else None
        if new is not None:
            rest, current = (lattice.insert_knots(k, new) for lattice in (rest, current))
            changes.append(f"{len(new)} knots were inserted in direction {'ijk'[k]}")
    return rest, current, changes


def _missing_knots(lattice: Lattice, axis: int) -> Array | None:
    """Knots that make a direction uniform, None if no insertion does."""
    u = lattice.knots[axis]
    ends = (breaks(u) - u[0]) / (u[-1] - u[0])
    if len(u) != len(ends) + 2 * lattice.degrees[axis]:  # a multiple inner knot stays one
        return None
    for spans in range(len(ends), MAX_SPANS + 1):
        places = np.rint(ends * spans)
        if np.abs(ends * spans - places).max() <= 1e-12 * spans:
            others = np.setdiff1d(np.arange(spans), places)
            result: Array | None = u[0] + (u[-1] - u[0]) * others / spans
            return result
    return None


def _resampled(lattice: Lattice, rules: ConversionRules) -> Lattice:
    """Interpolate at the Greville points of the format's space with as many control points."""
    lattice = lattice.clamped()
    degrees = [rules.degree(n, p) for n, p in zip(lattice.shape, lattice.degrees, strict=True)]
    ends = lattice.domain.tolist()
    knots = [
        clamped_uniform(n, p, *end) if rules.uniform or p != old else u
        for n, p, old, u, end in zip(
            lattice.shape, degrees, lattice.degrees, lattice.knots, ends, strict=True
        )
    ]
    lines = [np.clip(greville(u, p), u[0], u[-1]) for u, p in zip(knots, degrees, strict=True)]
    points = lattice.evaluate(np.array(list(product(*lines)))).reshape(*lattice.shape, 3)
    for axis, (u, p, line) in enumerate(zip(knots, degrees, lines, strict=True)):
        points = along(_interpolation(u, p, line), points, axis)
    return Lattice(degrees, knots, points, axes=lattice.axes)


def _interpolation(knots: Array, degree: int, u: Array) -> Array:
    """Matrix from values at as many parameters as there are control points to these."""
    first, values = basis(knots, degree, u)
    matrix = np.zeros((len(u), len(knots) - degree - 1))
    for column in range(degree + 1):
        matrix[np.arange(len(u)), first + column] = values[:, column]
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def _difference(old: Lattice, new: Lattice) -> float:
    """Largest distance between two maps, on 24 points along each direction."""
    lines = [np.linspace(low, high, 24) for low, high in old.domain]
    u = np.array(list(product(*lines)))
    return float(np.linalg.norm(old.evaluate(u) - new.evaluate(u), axis=1).max())


def _remedy(content: LatticeFile, rules: ConversionRules) -> str:
    """What would help, found by trying it: neither way of adapting cures everything."""
    rest, current, _ = _without_change(content.rest, content.current, rules)
    ways = []
    if not obstacles(LatticeFile(rest, current), rules):
        ways.append('"exact"')
    if not _frame_faults(rest, rules):
        ways.append('"resample"')
    adapt = f", or adapt it with {' or '.join(ways)}" if ways else ""
    return f"write .lattice.json{adapt}"


def _exactness(
    content: LatticeFile, rules: ConversionRules, changes: list[str], error: float | None
) -> Exactness:
    if error is not None:
        reason = f"resampled, the shape differs by up to {error:.3g}"
        return Exactness(False, reason, "more control points bring it closer")
    if rules.one_net and content.rest != content.current:
        reason = f"{rules.title} holds one net: the deformed one is kept, the one at rest is not"
        return Exactness(False, reason, "write .lattice.json to keep both")
    return Exactness(True, "; ".join(changes))
