"""Aerodynamic costs by the built-in panel method: inviscid, incompressible, two-dimensional."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Self

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.panel import PanelFlow, flow_about, is_solved
from ffdstudio.optimize.flow.pressure_table import panels, read_pressures
from ffdstudio.optimize.flow.response import pressure_response
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request, Response
from ffdstudio.optimize.spec.fields import Angle, Text, Weight, says
from ffdstudio.optimize.spec.goals import ObjectiveSpec, moved_file

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.shapes import Shape

Each = Annotated[tuple[float, ...], Meta(min_length=1)]
Weights = Annotated[tuple[Weight, ...], Meta(min_length=1)]


class FlowTarget(Objective):
    """Squared differences of pressure, lift and moment to targets, summed over angles.

    The cost is ``1/2 mean w (Cp - Cp*)^2 + 1/2 sum w (CL - CL*)^2 + 1/2 sum w (CM - CM*)^2`` of
    those targets that are given, with a weight w for each angle, 1 by default. The flow is
    inviscid: no drag, no separation, no compressibility.

    Parameters
    ----------
    angles : sequence of float
        Angles of attack in degrees.
    pressure : array_like, optional
        (angles, panels) target pressure coefficients at the panel middles.
    lift, moment : array_like, optional
        (angles,) target coefficients, chord 1, moment about the quarter chord.
    weights : mapping, optional
        (angles,) weights by "pressure", "lift" and "moment".

    Examples
    --------
    >>> angle = np.linspace(0, 2 * np.pi, 41)
    >>> circle = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    >>> round(FlowTarget([0.0], lift=[2.0]).evaluate(circle).value, 6)
    2.0
    """

    def __init__(
        self,
        angles: Sequence[float],
        pressure: ArrayLike | None = None,
        lift: ArrayLike | None = None,
        moment: ArrayLike | None = None,
        weights: Mapping[str, ArrayLike | None] | None = None,
    ) -> None:
        self.angles = [float(a) for a in angles]
        self.abilities = Abilities(angles=tuple(self.angles), response=True)
        self.pressure = None if pressure is None else np.atleast_2d(np.asarray(pressure, float))
        self.lift = self._per_angle(lift, "lift")
        self.moment = self._per_angle(moment, "moment")
        if pressure is None and lift is None and moment is None:
            raise InputError("a flow cost needs a target pressure, lift or moment")
        given = {"pressure": self.pressure, "lift": self.lift, "moment": self.moment}
        self.weights = {name: self._weight(name, weights or {}) for name in given}
        if self.pressure is not None and len(self.pressure) != len(self.angles):
            raise InputError(f"{len(self.angles)} angles need as many targets of pressure")
        for name in weights or {}:
            if (weights or {})[name] is not None and given[name] is None:
                raise InputError(f"there is a weight of the {name}, but no target")

    @classmethod
    def like(cls, nodes: ArrayLike, angles: Sequence[float]) -> FlowTarget:
        """The pressures of another contour are the target, panel by panel."""
        return cls(angles, pressure=PanelFlow(nodes, angles).pressure)

    def _weight(self, name: str, weights: Mapping[str, ArrayLike | None]) -> Array:
        found = self._per_angle(weights.get(name), f"weights of the {name}")
        return np.ones(len(self.angles)) if found is None else found

    def _per_angle(self, values: ArrayLike | None, name: str) -> Array | None:
        if values is None:
            return None
        array = np.atleast_1d(np.asarray(values, dtype=np.float64))
        if array.shape != (len(self.angles),):
            raise InputError(f"{len(self.angles)} angles need as many values of {name}")
        return array

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        new = not is_solved(request.points)
        flow = flow_about(request.points, tuple(self.angles))
        lift, moment = flow.lift(), flow.moment()
        gaps = {
            "pressure": self._pressure_gap(flow),
            "lift": None if self.lift is None else lift - self.lift,
            "moment": None if self.moment is None else moment - self.moment,
        }
        known = {k: g for k, g in gaps.items() if g is not None}
        slopes = {k: self._slope(k, g) for k, g in known.items()}
        value = sum(0.5 * float((g * slopes[k]).sum()) for k, g in known.items())
        result = Evaluation(value, flow=int(new))
        for k, angle in enumerate(self.angles):
            result.measures |= {f"cl@{angle:g}": float(lift[k]), f"cm@{angle:g}": float(moment[k])}
        if request.gradient:
            xy = flow.gradient(slopes.get("pressure"), slopes.get("lift"), slopes.get("moment"))
            result.gradient, result.adjoint = np.column_stack([xy, np.zeros(len(xy))]), 1
        return result

    def _slope(self, name: str, gap: Array) -> Array:
        """Derivative of the cost by a coefficient: the weighted gap, of pressures their mean."""
        weight = self.weights[name]
        return weight[:, None] * gap / gap.size if name == "pressure" else weight * gap

    def _pressure_gap(self, flow: PanelFlow) -> Array | None:
        if self.pressure is None:
            return None
        if flow.pressure.shape != self.pressure.shape:
            raise InputError(
                f"the target pressures are {self.pressure.shape}, the flow's {flow.pressure.shape}"
            )
        result: Array | None = flow.pressure - self.pressure
        return result

    def response(self, points: Array) -> Response:
        """See `Objective`: root of the mean square of the pressures' changes."""
        return pressure_response(points, self.angles)

    def pressures(self, points: Array) -> Mapping[str, Mapping[str, tuple[Array, Array]]]:
        """See `Objective`: the curve of the shape, and the target if there is one."""
        found: dict[str, Mapping[str, tuple[Array, Array]]] = {}
        for k, angle in enumerate(self.angles):
            flow = PanelFlow(points, [angle])
            curves = {"shape": (flow.middles.real, flow.pressure[0])}
            if self.pressure is not None:
                curves["target"] = (flow.middles.real, self.pressure[k])
            found[f"{angle:g}"] = curves
        return found


class FlowSpec(ObjectiveSpec, frozen=True, kw_only=True, tag="flow"):
    """Reach pressures, lift or moment: squared differences summed over angles, inviscid.

    Half of: the mean of the weighted (Cp - target)^2 over panels and angles, plus the sums of the
    weighted (CL - target)^2 and (CM - target)^2 over the angles; by the built-in panel method.
    """

    title = "Reach pressures, lift or moment"
    needs = "section"

    angles: Annotated[
        Annotated[tuple[Angle, ...], Meta(min_length=1)], says("Angles", "of attack", "°")
    ]
    target: Annotated[
        str,
        says("Target", "section whose pressures are to be met; a file, or a NACA name", file=True),
    ] = ""
    pressures: Annotated[
        Annotated[tuple[Text, ...], Meta(min_length=1)] | None,
        says("Pressure files", "instead of a target: tables x, Cp, one for each angle"),
    ] = None
    lift: Annotated[Each | None, says("Lift", "coefficient, one for each angle")] = None
    moment: Annotated[
        Each | None, says("Moment", "coefficient about the quarter chord, one for each angle")
    ] = None
    pressure_weights: Annotated[
        Weights | None, says("Weights of pressures", "one for each angle; without, 1")
    ] = None
    lift_weights: Annotated[
        Weights | None, says("Weights of lift", "one for each angle; without, 1")
    ] = None
    moment_weights: Annotated[
        Weights | None, says("Weights of moment", "one for each angle; without, 1")
    ] = None

    def __post_init__(self) -> None:
        if self.target and self.pressures is not None:
            raise ValueError("pressures: they go without a target section")
        if not self.target and (self.pressures, self.lift, self.moment) == (None,) * 3:
            raise ValueError("lacks something to reach: target, pressures, lift or moment")

    @property
    def aim(self) -> str:
        """See `ObjectiveSpec`."""
        return self.target

    @property
    def attack(self) -> float | None:
        """See `ObjectiveSpec`."""
        return self.angles[0] if self.angles else None

    def contour(self, place: Place) -> Contour | None:
        """See `ObjectiveSpec`."""
        return place.contour(self.target) if self.target else None

    def moved(self, change: Callable[[str], str]) -> Self:
        """See `ObjectiveSpec`."""
        tables = self.pressures and tuple(moved_file(name, change) for name in self.pressures)
        return msgspec.structs.replace(
            self, target=moved_file(self.target, change), pressures=tables
        )

    def build(self, shape: Shape, place: Place) -> Objective:
        """See `ObjectiveSpec`."""
        weights = {
            "pressure": self.pressure_weights,
            "lift": self.lift_weights,
            "moment": self.moment_weights,
        }
        pressure = self._wanted(shape, place)
        return FlowTarget(self.angles, pressure, self.lift, self.moment, weights)

    def _wanted(self, shape: Shape, place: Place) -> Array | None:
        """(angles, panels) pressures to be met."""
        contour, local = self.contour(place), shape.local
        if contour is not None:
            return PanelFlow(contour.at(local[:, 0], upper_side(local)), self.angles).pressure
        if self.pressures is None:
            return None
        tables = [read_pressures(place.beside / name) for name in self.pressures]
        return np.array([one.at(*panels(local)) for one in tables])
