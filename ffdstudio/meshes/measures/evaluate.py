"""``ffd.quality``: the report of a mesh, fast when the same mesh is asked again."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.cell_coverage import coverage
from ffdstudio.meshes.measures.incremental import QualityState
from ffdstudio.meshes.measures.inversion import deformed
from ffdstudio.meshes.measures.report import Report
from ffdstudio.meshes.mesh import Mesh

_states: WeakKeyDictionary[Mesh, QualityState] = WeakKeyDictionary()


def quality(mesh: Mesh, points: ArrayLike | None = None) -> Report:
    """Measures of the cells of a mesh, at other points against the undeformed ones.

    Parameters
    ----------
    mesh : Mesh
        The undeformed mesh. What can be known beforehand (faces, undeformed measures) is kept
        for the next call with the same mesh, which evaluates only cells with moved nodes.
    points : array_like, optional
        (n, 3) deformed coordinates; by default those of the mesh.

    Returns
    -------
    Report

    Raises
    ------
    InputError
        If the mesh has no cells of dimension 2 or 3, or the points do not fit.

    Examples
    --------
    >>> mesh = Mesh(
    ...     [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], {"quad": [[0, 1, 2, 3]]}, dimension=2
    ... )
    >>> report = quality(mesh, mesh.points * [1, 0.5, 1])
    >>> report.measures["volume_ratio"], int(report.inverted.sum())
    (array([0.5]), 0)
    """
    new = deformed(mesh, points)
    if not np.isfinite(new).all():
        raise InputError("a point is not a finite number")
    state = state_of(mesh)
    with state.lock:
        state.move(new)
        measures, inverted = state.measures(), state.inverted.copy()
    before = state.first
    with np.errstate(divide="ignore", invalid="ignore"):
        measures["volume_ratio"] = measures["volume"] / before["volume"]
        if state.walls is not None:
            measures["first_layer_ratio"] = state.walls.ratio(measures["volume_ratio"], new)
    return Report(measures, before, inverted, new, state, coverage(mesh))


def state_of(mesh: Mesh) -> QualityState:
    """Kept measures of a mesh.

    Raises
    ------
    InputError
        If it has no cells to speak of.
    """
    if mesh not in _states:
        _states[mesh] = QualityState(mesh)
    return _states[mesh]
