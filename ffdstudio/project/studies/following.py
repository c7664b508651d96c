"""The bodies of the document that follow a study: kept valid, each in its own way."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ffdstudio.meshes.measures.cell_coverage import coverage
from ffdstudio.meshes.ways import Way
from ffdstudio.optimize.followers.body import FollowingMesh
from ffdstudio.project.commands import AddLattice, CreateBox, Follow
from ffdstudio.project.commands.base import Command
from ffdstudio.project.model import LatticeItem, Model
from ffdstudio.project.studies.place import start_points
from ffdstudio.project.view.volume import countable


def following_bodies(model: Model, item: LatticeItem) -> Iterator[FollowingMesh]:
    """Bodies of the document whose cells a study on a lattice may invert."""
    for body in model.bodies:
        if countable(body.mesh) and coverage(body.mesh).checked:
            start = start_points(model, body, item)
            yield FollowingMesh.of(body.mesh, item.rest, start, body.name, Way(body.follows))


def walls_to_follow(made: Command, model: Model) -> list[Follow]:
    """Commands that let bodies follow their walls which reach out of a study's own lattice.

    That lattice is tight around the shape: carried by it, cells would invert.
    """
    if isinstance(made, CreateBox):
        ends = np.array([made.lower, made.upper])
    elif isinstance(made, AddLattice):
        points = made.rest.control_points.reshape(-1, 3)
        ends = np.array([points.min(axis=0), points.max(axis=0)])
    else:
        return []
    found = []
    for body in model.bodies:
        low, high = body.mesh.bounds
        out = (low < ends[0]).any() or (high > ends[1]).any()
        if out and countable(body.mesh) and body.follows != Way.WALLS:
            found.append(Follow(body.key, Way.WALLS))
    return found
