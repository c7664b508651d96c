"""Shapes and tasks that several tests use."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import ffdstudio as ffd
from ffdstudio.optimize.build.build import Built, build
from ffdstudio.optimize.build.lattice import section_box
from ffdstudio.optimize.build.place import Place
from ffdstudio.optimize.geometry.sections import sampled
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.runs.study import Task
from ffdstudio.optimize.spec.codec import from_values
from ffdstudio.optimize.variables.metrics import Surface

Array = np.ndarray


def built(values: dict, beside: Path, folder: Path | None = None, resume: bool = False) -> Built:
    """Study of the values of a case file that lies in a folder."""
    return build(from_values(values), Place(beside, folder, resume))


def section(count: int = 161) -> Array:
    return sampled("naca0012", count)


def columns(count: int, spacing: str = "greville", rows: int = 2) -> ffd.Lattice:
    """Lattice around the section, with cosine-spaced knots on request."""
    if spacing != "cosine":
        return section_box(section(), (count, rows), spacing)
    inner = count - 3
    knots = -0.01 + 1.02 * 0.5 * (1 - np.cos(np.pi * np.arange(1, inner) / inner))
    return section_box(section(), (4, rows)).insert_knots(0, knots)


def task(objective: Objective, lattice: ffd.Lattice, points: Array, metric: str = "h1") -> Task:
    return Task(objective, ffd.embed(lattice, points), Surface.curve(points), metric=metric)


def bumped(lattice: ffd.Lattice, points: Array, size: float = 0.02) -> Array:
    """Points deformed by a known lattice."""
    rng = np.random.default_rng(5)
    moved = lattice.control_points.copy()
    moved[..., 1] += size * rng.uniform(-1, 1, lattice.shape)
    return ffd.embed(lattice, points).deform(lattice.moved(moved))
