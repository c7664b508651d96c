"""Indicators: what a candidate knot is worth, from the surface gradient of the cost.

All need the gradient s = dJ/dX at the surface points and no further solve:

gain
    The share of s that the new functions capture and the present space does not,
    ``(phi' s)^2 / (phi' K phi)`` with phi made K-orthogonal to the space; K is the L2 or H1
    metric, or the Gauss-Newton Hessian of a cost with residuals. For a quadratic cost with
    Hessian K the gain is twice the decrease that the knot brings.
interval
    Energy of the un-captured gradient within the knot span of the candidate (one reading of
    "a certain level of cost function gradient evaluated for each interval").
gradient
    Size of the derivative of the cost by the candidate's new control points (the other one).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.optimize.refine.candidates import Candidate, own_knots
from ffdstudio.optimize.refine.sensitivity import Sensitivity
from ffdstudio.optimize.variables.level import Level


class GainState:
    """Orthonormal frame of the present space, which grows with each chosen candidate."""

    def __init__(self, sensitivity: Sensitivity) -> None:
        self.sensitivity, self.frame = sensitivity, sensitivity.frame
        self.captured = sensitivity.along(sensitivity.framed)

    def gains(self, candidates: Sequence[Candidate]) -> Array:
        """Gain of each candidate."""
        functions = np.hstack([c.functions for c in candidates])
        tilde = self.sensitivity.measure(functions)
        shares = self.frame.T @ tilde
        tilde = tilde - self.frame @ shares
        force = self.sensitivity.along(functions) - self.captured @ shares
        ends = np.cumsum([0] + [c.functions.shape[1] for c in candidates])
        return np.array([_gain(tilde[:, a:b], force[a:b]) for a, b in pairwise(ends)])

    def accept(self, candidate: Candidate) -> None:
        """Take a candidate's functions into the frame."""
        tilde = self.sensitivity.measure(candidate.functions)
        shares = self.frame.T @ tilde
        u, sigma, vt = np.linalg.svd(tilde - self.frame @ shares, full_matrices=False)
        kept = sigma > 1e-8 * np.linalg.norm(tilde)
        force = self.sensitivity.along(candidate.functions) - self.captured @ shares
        self.frame = np.hstack([self.frame, u[:, kept]])
        self.captured = np.concatenate([self.captured, (force @ vt[kept].T) / sigma[kept]])


def _gain(tilde: Array, force: Array) -> float:
    sigma, vectors = np.linalg.eigh(tilde.T @ tilde)
    kept = sigma > 1e-12 * max(sigma.max(), 1e-300)
    return float(((force @ vectors[:, kept]) ** 2 / sigma[kept]).sum())


def gain(level: Level, sensitivity: Sensitivity, found: Sequence[Candidate]) -> Array:
    """Gain of each candidate."""
    return GainState(sensitivity).gains(found)


def interval(level: Level, sensitivity: Sensitivity, found: Sequence[Candidate]) -> Array:
    """Un-captured gradient energy in the knot span of each candidate."""
    mass = level.body.surface.mass
    root = np.repeat(np.sqrt(mass), len(level.coordinates))
    frame = np.linalg.qr(root[:, None] * level.shapes)[0]
    rest = sensitivity.surface / np.where(root > 0, root, 1.0)
    rest = rest - frame @ (frame.T @ rest)
    energy = (rest**2).reshape(len(mass), -1).sum(axis=1)
    return np.array([energy[_in_span(level, c)].sum() for c in found])


def literal(level: Level, sensitivity: Sensitivity, found: Sequence[Candidate]) -> Array:
    """Norm of the derivative by each candidate's new control points."""
    return np.array([np.linalg.norm(sensitivity.along(c.functions)) for c in found])


def _in_span(level: Level, candidate: Candidate) -> NDArray[np.bool_]:
    new = candidate.insertion
    ends = np.unique(own_knots(level.space, new.axis, new.line))
    k = int(np.searchsorted(ends, new.knot))
    u = level.parameters[:, new.axis]
    result: NDArray[np.bool_] = (u >= ends[k - 1]) & (u <= ends[k])
    return result


@dataclass(frozen=True)
class Indicator:
    """What says where a knot is worth most: a row of the catalog.

    Attributes
    ----------
    name, title, about : str
        In files, for people, and what it measures.
    scores : callable
        What candidates are worth on a level.
    greedy : bool
        Whether knots of one cycle are chosen one after the other, each beside those before it.
    middle : bool
        Whether an interval is halved, whichever of its places has the best score.
    """

    name: str
    title: str
    about: str
    scores: Callable[[Level, Sensitivity, Sequence[Candidate]], Array]
    greedy: bool = False
    middle: bool = False


GAIN = Indicator(
    "gain", "Gain", "What the new functions capture of the gradient and the present ones do not.",
    gain, greedy=True,
)  # fmt: skip
INTERVAL = Indicator(
    "interval", "Energy of the interval", "Energy of the gradient that is not captured, by "
    "knot interval.", interval, middle=True,
)  # fmt: skip
GRADIENT = Indicator(
    "gradient", "Gradient of new points", "Size of the derivative by the new control points.",
    literal,
)  # fmt: skip
