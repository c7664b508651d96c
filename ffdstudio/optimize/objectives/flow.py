"""Aerodynamic costs by the built-in panel method: inviscid, incompressible, two-dimensional."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.errors import InputError
from ffdstudio.optimize.objectives.base import Array, Evaluation
from ffdstudio.optimize.panel import PanelFlow, flow_about


class FlowTarget:
    """Squared differences of pressure, lift and moment to targets, summed over angles.

    The cost is ``1/2 mean (Cp - Cp*)^2 + 1/2 sum (CL - CL*)^2 + 1/2 sum (CM - CM*)^2`` of those
    targets that are given. The flow is inviscid: no drag, no separation, no compressibility.

    Parameters
    ----------
    angles : sequence of float
        Angles of attack in degrees.
    pressure : array_like, optional
        (angles, panels) target pressure coefficients at the panel middles.
    lift, moment : array_like, optional
        (angles,) target coefficients, chord 1, moment about the quarter chord.

    Examples
    --------
    >>> angle = np.linspace(0, 2 * np.pi, 41)
    >>> circle = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    >>> round(FlowTarget([0.0], lift=[2.0]).evaluate(circle).value, 6)
    2.0
    """

    differentiable = True

    def __init__(
        self,
        angles: Sequence[float],
        pressure: ArrayLike | None = None,
        lift: ArrayLike | None = None,
        moment: ArrayLike | None = None,
    ) -> None:
        self.angles = [float(a) for a in angles]
        self.pressure = None if pressure is None else np.atleast_2d(np.asarray(pressure, float))
        self.lift = self._per_angle(lift, "lift")
        self.moment = self._per_angle(moment, "moment")
        if pressure is None and lift is None and moment is None:
            raise InputError("a flow cost needs a target pressure, lift or moment")

    @classmethod
    def like(cls, nodes: ArrayLike, angles: Sequence[float]) -> FlowTarget:
        """The pressures of another contour are the target, panel by panel."""
        return cls(angles, pressure=PanelFlow(nodes, angles).pressure)

    def _per_angle(self, values: ArrayLike | None, name: str) -> Array | None:
        if values is None:
            return None
        array = np.atleast_1d(np.asarray(values, dtype=np.float64))
        if array.shape != (len(self.angles),):
            raise InputError(f"{len(self.angles)} angles need as many targets of {name}")
        return array

    def evaluate(self, points: Array, gradient: bool = True) -> Evaluation:
        """See `Objective`."""
        flow = flow_about(points, tuple(self.angles))
        lift, moment = flow.lift(), flow.moment()
        gaps = {
            "pressure": self._pressure_gap(flow),
            "lift": None if self.lift is None else lift - self.lift,
            "moment": None if self.moment is None else moment - self.moment,
        }
        value = sum(
            0.5 * float((g**2).mean() if k == "pressure" else (g**2).sum())
            for k, g in gaps.items()
            if g is not None
        )
        result = Evaluation(value, flow=1)
        for k, angle in enumerate(self.angles):
            result.measures |= {f"cl@{angle:g}": float(lift[k]), f"cm@{angle:g}": float(moment[k])}
        if gradient:
            if gaps["pressure"] is not None:
                gaps["pressure"] = gaps["pressure"] / gaps["pressure"].size
            xy = flow.gradient(gaps["pressure"], gaps["lift"], gaps["moment"])
            result.gradient, result.adjoint = np.column_stack([xy, np.zeros(len(xy))]), 1
        return result

    def _pressure_gap(self, flow: PanelFlow) -> Array | None:
        if self.pressure is None:
            return None
        if flow.pressure.shape != self.pressure.shape:
            raise InputError(
                f"the target pressures are {self.pressure.shape}, the flow's {flow.pressure.shape}"
            )
        return flow.pressure - self.pressure
