"""Plots of studies as files, PNG and SVG, and their figures as CSV; no display needed.

matplotlib comes with pyvista and is imported when a plot is drawn.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.files import write_bytes
from ffdstudio.optimize.runs.record import RunHistory, value_of

FIELDS = (
    "evaluation",
    "iteration",
    "level",
    "variables",
    "cost",
    "gradient",
    "flow",
    "adjoint",
    "seconds",
)
KINDS = ("png", "svg")
LABELS = {"rms": "RMS error", "max_error": "largest error"}
DOTS = 60  # of a target, open, so that what lies on it is seen through them


def figure(height: float = 4.5) -> tuple[Any, Any]:
    """Figure and axes that need no window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    fig = Figure(figsize=(8, height), layout="constrained")
    FigureCanvasAgg(fig)
    return fig, fig.add_subplot()


def save(fig: Any, folder: Path, name: str) -> list[str]:
    """Write a figure as PNG and SVG; returns the names of the files."""
    names = []
    for kind in KINDS:
        data = io.BytesIO()
        fig.savefig(data, format=kind, dpi=150, metadata={"Date": None} if kind == "svg" else None)
        write_bytes(folder / f"{name}.{kind}", data.getvalue())
        names.append(f"{name}.{kind}")
    return names


def convergence(
    studies: Mapping[str, RunHistory], figure_of: str = "cost", against: str = "evaluation"
) -> Any:
    """Convergence of studies on the same logarithmic axes; refinements are marked."""
    fig, axes = figure()
    for name, history in studies.items():
        x, y = history.column(against), history.column(figure_of)
        lines = axes.plot(x, np.where(y > 0, y, np.nan), drawstyle="steps-post", label=name)
        marks = [r for r in history.refinements if value_of(r, against) <= x[-1]]
        at = [value_of(r, against) for r in marks]
        if at:
            heights = np.interp(at, x, y)
            axes.plot(at, heights, "v", color=lines[0].get_color(), markersize=4)
    axes.set_yscale("log")
    axes.set_xlabel(f"{against}s" if against in ("evaluation", "iteration") else against)
    axes.set_ylabel(LABELS.get(figure_of, figure_of.replace("_", " ")))
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(
        title="triangles: refinements" if any(h.refinements for h in studies.values()) else None
    )
    return fig


def outlines(
    curves: Mapping[str, Array], net: Array | None = None, target: str | None = None
) -> Any:
    """Sections drawn to scale, with the control net (columns, rows, 3) if given.

    The curve of the name `target` is dotted. The view is that of the sections: control points
    that have run far away are counted instead of shown.
    """
    fig, axes = figure(2.6)
    if net is not None:
        axes.plot(net[..., 0], net[..., 1], "-", color="0.75", linewidth=0.6)
        axes.plot(net[..., 0].T, net[..., 1].T, "o-", color="0.65", linewidth=0.6, markersize=2.5)
    for name, curve in curves.items():
        _curve(axes, curve[:, 0], curve[:, 1], name, name == target)
    axes.set_aspect("equal")
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    _look_at(axes, np.concatenate([curve[:, :2] for curve in curves.values()]), net)
    fig.legend(loc="outside upper center", ncols=len(curves), frameon=False)
    return fig


def _look_at(axes: Any, points: Array, net: Array | None) -> None:
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.array([0.04 * (high - low)[0], 0.4 * (high - low)[1]])
    low, high = low - room, high + room
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    if net is None:
        return
    far = ((net[..., :2] < low) | (net[..., :2] > high)).any(axis=-1).sum()
    if far:
        axes.set_title(f"{far} control points lie outside the picture", fontsize=9)


def _curve(axes: Any, x: Array, y: Array, name: str, dotted: bool) -> None:
    """A line, or open dots that are equally far apart along the curve."""
    if not dotted:
        axes.plot(x, y, label=name, linewidth=1.2)
        return
    scale = [np.ptp(v) or 1.0 for v in (x, y)]
    length = np.hypot(np.diff(x) / scale[0], np.diff(y) / scale[1])
    s = np.concatenate([[0.0], np.cumsum(length)])
    at = np.searchsorted(s, np.linspace(0, s[-1], DOTS)).clip(0, len(x) - 1)
    style = {"markerfacecolor": "none", "markersize": 5, "zorder": 3}
    axes.plot(x[at], y[at], "o", color="0.15", label=name, **style)


def errors(x: Array, error: Array, upper: NDArray[np.bool_], tolerance: Array) -> Any:
    """Error along the chord with the band of a tolerance."""
    fig, axes = figure()
    order = np.argsort(x)
    axes.plot(x[order], tolerance[order], "k--", linewidth=0.8, label="Kulfan's tolerance")
    for side, name in ((upper, "upper surface"), (~upper, "lower surface")):
        axes.plot(x[side], np.maximum(np.abs(error[side]), 1e-12), label=name, linewidth=1)
    axes.set_yscale("log")
    axes.set_ylim(1e-9, None)
    axes.set_xlabel("x")
    axes.set_ylabel("distance to the target")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    return fig


def pressures(curves: Mapping[str, tuple[Array, Array]], target: str | None = None) -> Any:
    """Pressure coefficients over x, suction upwards; those of the name `target` are dotted."""
    fig, axes = figure()
    for name, (x, cp) in curves.items():
        _curve(axes, x, cp, name, name == target)
    axes.invert_yaxis()
    axes.set_xlabel("x")
    axes.set_ylabel("Cp (inviscid)")
    axes.grid(True, alpha=0.3)
    axes.legend()
    return fig


def table(history: RunHistory) -> bytes:
    """CSV of the iterates: the fields of the record, then its measures."""
    measures = sorted({name for r in history.iterates for name in r.measures})
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*FIELDS, *measures])
    for r in history.iterates:
        writer.writerow(
            [*(getattr(r, name) for name in FIELDS), *(r.measures.get(m, "") for m in measures)]
        )
    return out.getvalue().encode()
