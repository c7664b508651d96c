"""NeuralFoil: viscous coefficients by a neural network; an optional extra."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request
from ffdstudio.optimize.spec.fields import Angle, Positive, Weight, says
from ffdstudio.optimize.spec.goals import ObjectiveSpec

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.shapes import Shape


class NeuralFoil(Objective):
    """Drag at a lift, by NeuralFoil (P. Sharpe, MIT, 2023); gradients by finite differences.

    The cost is ``cd + weight * (cl - lift)^2`` at one angle of attack and Reynolds number.

    Raises
    ------
    InputError
        If the package neuralfoil is not installed.
    """

    abilities = Abilities(gradient=False)

    def __init__(self, angle: float, reynolds: float, lift: float, weight: float = 1.0) -> None:
        try:
            import neuralfoil  # type: ignore[import-not-found,unused-ignore]
        except ImportError as error:
            raise InputError(
                "this objective needs the package neuralfoil: pip install 'ffdstudio[neuralfoil]'"
            ) from error
        self.solver: Any = neuralfoil
        self.angle, self.reynolds, self.lift, self.weight = angle, reynolds, lift, weight

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        found = self.solver.get_aero_from_coordinates(
            coordinates=request.points[:, :2], alpha=self.angle, Re=self.reynolds
        )
        cl, cd = (float(np.ravel(found[name])[0]) for name in ("CL", "CD"))
        return Evaluation(
            cd + self.weight * (cl - self.lift) ** 2, flow=1, measures={"cl": cl, "cd": cd}
        )


class NeuralFoilSpec(ObjectiveSpec, frozen=True, kw_only=True, tag="neuralfoil"):
    """Least drag at a lift, with boundary layers: drag + weight (lift - wanted)^2."""

    title = "Least drag at a lift (NeuralFoil)"
    needs = "section"

    angle: Annotated[Angle, says("Angle", "of attack", "°")]
    reynolds: Annotated[Positive, says("Reynolds number", "of the chord")]
    lift: Annotated[float, says("Lift", "coefficient that is wanted")]
    weight: Annotated[Weight, says("Weight", "of the squared difference of the lift")] = 1.0

    @property
    def attack(self) -> float | None:
        """See `ObjectiveSpec`."""
        return self.angle

    def build(self, shape: Shape, place: Place) -> Objective:
        """See `ObjectiveSpec`."""
        return NeuralFoil(self.angle, self.reynolds, self.lift, self.weight)

    def files(self, shape: Shape, place: Place) -> list[Path]:
        """See `ObjectiveSpec`: none, but evaluations are remembered."""
        return []
