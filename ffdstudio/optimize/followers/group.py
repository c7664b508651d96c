"""The meshes that follow a study, together: whether they are valid, and how far a step may go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.optimize.followers.body import FollowingMesh


@dataclass(frozen=True)
class Followers:
    """Meshes that follow a study.

    Examples
    --------
    >>> import ffdstudio as ffd
    >>> mesh = ffd.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    >>> box = ffd.Lattice.box([0, 0, 0], [1, 1, 0], shape=(2, 2))
    >>> turned = box.moved(box.control_points * [1, -1, 1])
    >>> followers = Followers([FollowingMesh.of(mesh, box)])
    >>> followers.begin(box)
    >>> followers.valid(turned), round(followers.reach(box, turned), 3)
    (False, 0.475)
    """

    bodies: Sequence[FollowingMesh]

    def begin(self, current: Lattice) -> None:
        """Note where the study begins."""
        for body in self.bodies:
            body.begin(current)

    def valid(self, current: Lattice) -> bool:
        """Whether a lattice turns no cell inside out."""
        return all(body.valid(current) for body in self.bodies)

    def reach(self, here: Lattice, there: Lattice) -> float:
        """Share of the way from one lattice to another that turns no cell inside out, at most 1.

        Exact but for a margin where nodes go straight: with fixed weights, carried by the lattice.
        """
        shares = [body.reach(body.at(here), body.at(there)) for body in self.bodies]
        return min([1.0, *shares])

    def figures(self, current: Lattice) -> dict[str, float]:
        """Inverted cells, worst scaled Jacobian, least relative height of a first layer."""
        from ffdstudio.meshes import quality

        found: dict[str, list[float]] = {}
        for body in self.bodies:
            points = body.at(current)
            measures = quality(body.mesh, points).measures
            found.setdefault("inverted", []).append(body.broken(points))
            for name, key in (("scaled_jacobian", "worst_cell"), ("first_layer_ratio", "layer")):
                values = measures.get(name, np.empty(0))
                values = values[np.isfinite(values)]
                if len(values):
                    found.setdefault(key, []).append(float(values.min()))
        total = {"inverted": float(sum(found.pop("inverted", [])))} if found else {}
        return {**total, **{key: min(values) for key, values in found.items()}}
