"""What a fit consists of: source, target, lattice at rest, and the figures that judge it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.embedding import Embedding
from ffdstudio.engine.jacobians import jacobian
from ffdstudio.engine.knots import clamped_uniform
from ffdstudio.errors import InputError
from ffdstudio.optimize.geometry.contour import Contour
from ffdstudio.optimize.geometry.sections import (
    Section,
    is_naca,
    kulfan_tolerance,
    points_for,
    target_contour,
    trailing_ends,
    trailing_gap,
)
from ffdstudio.optimize.objectives.distance import ContourDistance, SurfaceDistance
from ffdstudio.optimize.runs.study import Task
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.rules import AXES, Rules
from ffdstudio.optimize.variables.space import Insertion

MARGIN = 0.01  # of the chord: the lattice ends a little beyond nose and trailing edge


@dataclass
class FitTask:
    """A task with what plots and reports need.

    Attributes
    ----------
    task : Task
    rest : Lattice
        Before the first refinement.
    judged : Embedding
        The points that errors are measured at.
    axes : tuple of int
        Directions to refine.
    section, target : optional
        Of a 2D fit.
    """

    task: Task
    rest: Lattice
    judged: Embedding
    axes: tuple[int, ...]
    distance: Any
    section: Section | None = None
    target: Contour | None = None

    @property
    def spatial(self) -> bool:
        """Whether the fit is in 3D."""
        return self.section is None

    def rest_of(self, current: Lattice) -> Lattice:
        """The lattice at rest in the space of a refined one."""
        rest = self.rest
        for axis in range(rest.dimension):
            rest = rest.insert_knots(axis, _extra(rest.knots[axis], current.knots[axis]))
        return rest

    def deformed(self, current: Lattice) -> Array:
        """Judged points under a current lattice."""
        step = (current.control_points - self.rest_of(current).control_points).reshape(-1, 3)
        shares = jacobian(current, self.judged.parameters, self.judged.inside)
        result: Array = self.judged.points + shares @ step
        return result

    def errors(self, current: Lattice) -> Array:
        """Signed orthogonal errors at the judged points."""
        return np.asarray(self.distance.distances(self.deformed(current))[0])

    def figures(self, current: Lattice) -> dict[str, float]:
        """RMS, largest error and Kulfan's ratio."""
        points = self.deformed(current)
        error = np.abs(self.distance.distances(points)[0])
        found = {"rms": float(np.sqrt(np.mean(error**2))), "max_error": float(error.max())}
        if self.section is not None:
            found["kulfan_ratio"] = float((error / kulfan_tolerance(points[:, 0])).max())
        return found


def _extra(coarse: Array, fine: Array) -> Array:
    values, counts = np.unique(fine, return_counts=True)
    have = np.array([(coarse == value).sum() for value in values])
    return np.repeat(values, np.maximum(counts - have, 0))


def section_task(
    source: Any,
    target: Any,
    shape: tuple[int, int],
    metric: str,
    spacing: str,
    norm: str,
    movable: bool,
    variables: int = 0,
) -> FitTask:
    """Fit of a section: vertical displacements, cubic in x, rows of degree rows - 1 in y.

    With `movable` the inner knots count as inserted, so that a relocation may move them; of
    `variables` at the end there are so many that the points suffice for them.
    """
    contour = target_contour(target)
    gap = trailing_gap(contour) - (0.0 if is_naca(source) else _own_gap(source))
    ends = trailing_ends(contour) / (1.0 if is_naca(source) else _own_ends(source))
    section = Section.of(source, gap, points_for(variables), (ends[0], ends[1]))
    columns = 4 if movable else shape[0]
    rest = section_box(section.points, (columns, shape[1]), spacing)
    weight = kulfan_tolerance(section.points[:, 0]) if norm == "max" else None
    objective = ContourDistance(contour, section.upper, weight)
    slopes = Surface.curve(section.points).slopes
    count = len(section.points)
    surface = Surface(np.full(count, 1 / count), slopes)  # the mean is over points, not length
    knots = [Insertion(0, float(u)) for u in _inner(rest, shape[0])] if movable else []
    task = Task(objective, embed(rest, section.points), surface, metric=metric, knots=knots)
    judge = ContourDistance(contour, section.dense_upper)
    found = FitTask(task, rest, embed(rest, section.dense), (0,), judge, section, contour)
    task.monitor = found.figures
    return found


def _own_gap(source: Any) -> float:
    return trailing_gap(target_contour(source))


def _own_ends(source: Any) -> Array:
    return trailing_ends(target_contour(source))


def section_box(points: Array, shape: tuple[int, int], spacing: str = "greville") -> Lattice:
    """Lattice around a section, cubic in x and of the highest degree in y."""
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    reach = np.array([MARGIN * (high[0] - low[0]), 0.05 * (high[1] - low[1])])
    return Lattice.box(low - reach, high + reach, shape, (3, shape[1] - 1), spacing=spacing)


def _inner(rest: Lattice, columns: int) -> Array:
    low, high = rest.domain[0]
    return clamped_uniform(columns, 3, low, high)[4:-4]


def surface_task(
    source: Any, target: Any, shape: tuple[int, int, int], metric: str, directions: str
) -> FitTask:
    """Fit of a surface in 3D: displacements in the given directions, refined in all three."""
    points, triangles = surface_of(source)
    distance = SurfaceDistance(*surface_of(target))
    rest = Lattice.around(points, shape=shape, margin=MARGIN)
    embedding = embed(rest, points)
    rules = Rules(directions=tuple(AXES[letter] for letter in directions))
    surface = Surface.triangles(points, triangles)
    task = Task(distance, embedding, surface, rules, metric=metric)
    found = FitTask(task, rest, embedding, (0, 1, 2), distance)
    task.monitor = found.figures
    return found


def surface_of(source: Any) -> tuple[Array, NDArray[np.int64]]:
    """Points and triangles of the surface of a mesh or file; quads are split."""
    from ffdstudio.meshes.mesh import Mesh
    from ffdstudio.meshes.reading import read_mesh

    mesh = source if isinstance(source, Mesh) else read_mesh(source)
    parts = [mesh.cells["triangle"]] if "triangle" in mesh.cells else []
    if "quad" in mesh.cells:
        quads = mesh.cells["quad"]
        parts += [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    if not parts or any(name in mesh.cells for name in ("tetra", "hexahedron", "wedge")):
        raise InputError(f"{mesh.path or 'the mesh'} is no surface of triangles and quads")
    triangles = np.concatenate(parts)
    used, compact = np.unique(triangles, return_inverse=True)
    return np.asarray(mesh.points)[used], compact.reshape(triangles.shape)
