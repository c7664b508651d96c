"""What the airfoil view shows of a section: outlines, errors, curvature, pressure.

Everything is told in chords and computed from values, so that a worker can do it while a
control point is being dragged.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.panel import PanelFlow
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.geometry.sections import is_naca, target_contour

SHOWN_POINTS, FLOW_POINTS = 241, 121
COMB = 0.25  # of the chord: the longest tooth


@dataclass(frozen=True, eq=False)
class Pressure:
    """Pressure coefficients at panel middles, and the lift coefficient."""

    x: Array
    cp: Array
    lift: float


@dataclass(frozen=True, eq=False)
class SectionView:
    """Curves to draw, in chords.

    Attributes
    ----------
    source, current : numpy.ndarray
        (n, 2) and (m, 2) outlines.
    target : numpy.ndarray or None
    error : numpy.ndarray or None
        (m,) signed distances of the current points to the target.
    upper : numpy.ndarray
        (m,) bool.
    comb : numpy.ndarray
        (m, 2) ends of the teeth of the curvature comb.
    pressure, aim : Pressure or None
        Of the current section, and of the target; None where there is no solution.
    """

    source: Array
    current: Array
    target: Array | None
    error: Array | None
    upper: NDArray[np.bool_]
    comb: Array
    pressure: Pressure | None
    aim: Pressure | None

    @property
    def rms(self) -> float:
        """Of the errors; NaN without a target."""
        return float("nan") if self.error is None else float(np.sqrt(np.mean(self.error**2)))


def section_view(start: Array, now: Array, target: str, angle: float) -> SectionView:
    """Look at a section.

    Parameters
    ----------
    start, now : numpy.ndarray
        (n, 3) points of the contour, undeformed and as they are, in Selig's order.
    target : str
        File or name of a section; empty for none.
    angle : float
        Of attack, in degrees.

    Raises
    ------
    InputError
        If the target cannot be read.

    Examples
    --------
    >>> from ffdstudio.meshes.airfoil import naca4
    >>> xyz = np.column_stack([naca4("0012"), np.zeros(201)])
    >>> view = section_view(xyz, xyz, "naca0012", 0.0)
    >>> bool(np.abs(view.error).max() < 1e-6), abs(round(view.pressure.lift, 6))
    (True, 0.0)
    """
    chord = Chord.of(start)
    here = Contour.through(chord.local(now))
    points = here.sample(SHOWN_POINTS)
    upper, error, outline, aim = upper_side(points), None, None, None
    if target:
        contour = known_target(target)
        error = contour.nearest(points, upper).distance
        outline = contour.sample(SHOWN_POINTS)[:, :2]
        aim = _pressure(contour, angle)
    return SectionView(
        chord.local(start)[:, :2], points[:, :2], outline, error, upper, _comb(here),
        _pressure(here, angle), aim,
    )  # fmt: skip


def known_target(target: str) -> Contour:
    """Contour of a file or section; read again only when the file has changed."""
    try:
        stamp = 0.0 if is_naca(target) else Path(target).stat().st_mtime
    except OSError as error:
        raise InputError(f"cannot read {target}: {(error.strerror or '').lower()}") from None
    return _remembered(target, stamp)


@lru_cache(maxsize=8)
def _remembered(target: str, stamp: float) -> Contour:
    return target_contour(target)


def _pressure(contour: Contour, angle: float) -> Pressure | None:
    try:
        flow = PanelFlow(contour.sample(FLOW_POINTS), [angle])
    except (InputError, ValueError):  # a contour that crosses itself has no flow about it
        return None
    return Pressure(flow.middles.real, flow.pressure[0], float(flow.lift()[0]))


def _comb(contour: Contour) -> Array:
    """Teeth along the outward normal, as long as the root of the curvature is large.

    The root keeps the nose, whose curvature is a hundred times that of the rest, on the page.
    """
    s = _parameters(contour)
    first, second = contour.spline(s, 1), contour.spline(s, 2)
    turn = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    speed = np.linalg.norm(first, axis=1)
    curvature = turn / speed**3
    normal = np.column_stack([first[:, 1], -first[:, 0]]) / speed[:, None]
    tooth = np.sign(curvature) * np.sqrt(np.abs(curvature))
    scale = COMB / max(float(np.abs(tooth).max()), 1e-300)
    result: Array = contour.spline(s) + scale * tooth[:, None] * normal
    return result


def _parameters(contour: Contour) -> Array:
    """Parameters of the shown points, the nose in the middle."""
    half = SHOWN_POINTS // 2
    close = 0.5 * (1 - np.cos(np.linspace(0, np.pi, half + 1)))
    back = contour.nose + (contour.length - contour.nose) * close
    return np.concatenate([contour.nose * close, back[1:]])
