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

from ffdstudio.files import write_bytes
from ffdstudio.optimize.record import History, value_of

Array = NDArray[np.float64]
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
    studies: Mapping[str, History], figure_of: str = "cost", against: str = "evaluation"
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
    axes.set_ylabel(figure_of.replace("_", " "))
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(
        title="triangles: refinements" if any(h.refinements for h in studies.values()) else None
    )
    return fig


def outlines(curves: Mapping[str, Array], net: Array | None = None) -> Any:
    """Sections drawn to scale, with the control net (columns, rows, 3) if given."""
    fig, axes = figure(3.5)
    if net is not None:
        axes.plot(net[..., 0], net[..., 1], "-", color="0.75", linewidth=0.6)
        axes.plot(net[..., 0].T, net[..., 1].T, "o-", color="0.65", linewidth=0.6, markersize=2.5)
    for name, curve in curves.items():
        axes.plot(curve[:, 0], curve[:, 1], label=name, linewidth=1.2)
    axes.set_aspect("equal")
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    axes.legend(loc="upper right")
    return fig


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


def pressures(curves: Mapping[str, tuple[Array, Array]]) -> Any:
    """Pressure coefficients over x, suction upwards."""
    fig, axes = figure()
    for name, (x, cp) in curves.items():
        axes.plot(x, cp, label=name, linewidth=1.2)
    axes.invert_yaxis()
    axes.set_xlabel("x")
    axes.set_ylabel("Cp (inviscid)")
    axes.grid(True, alpha=0.3)
    axes.legend()
    return fig


def table(history: History) -> bytes:
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
