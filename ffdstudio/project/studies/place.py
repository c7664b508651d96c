"""What the names in a study of the document stand for.

A description speaks of a body or a lattice of the document by its key in angle brackets, as in
"<body1>", which survives renaming; in a project file it is the name.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.optimize.build.place import Moved, Pair, Place
from ffdstudio.optimize.consent import Consent
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.followers import deformed
from ffdstudio.project.model import Body, LatticeItem, Model
from ffdstudio.project.study_names import key_of


def body_of(study: StudySpec, model: Model) -> Body | None:
    """Body that a study is about; None if it is about a file."""
    key = key_of(study.shape.source)
    return None if key is None else model.body(key)


def lattice_of(study: StudySpec, model: Model) -> LatticeItem | None:
    """Lattice of the document that a study works on; None if it makes or reads its own."""
    key = key_of(study.lattice.file)
    return None if key is None else model.lattice(key)


def place_of(
    study: StudySpec,
    model: Model,
    folder: Path | None = None,
    nodes: Indices | None = None,
    source: Path | None = None,
    consent: Consent | None = None,
) -> Place:
    """Where a study of a model is built; deforms the body by earlier lattices.

    Parameters
    ----------
    folder : path, optional
        Where its results go.
    nodes : numpy.ndarray, optional
        Nodes of the body that are looked at; all by default.
    source, consent : optional
        Project that the study came inside, and what may run of it.
    """
    body, item = body_of(study, model), lattice_of(study, model)
    objects: dict[str, Any] = {}
    beside = Path()
    if body is not None:
        objects[body.key] = Moved(body.mesh, start_points(model, body, item, nodes))
        beside = body.path.parent
    if item is not None:
        objects[item.key] = Pair(item.rest, item.current if item.deformed else item.rest)
    return Place(beside, folder, False, objects, source, consent or Consent())


def start_points(
    model: Model, body: Body, item: LatticeItem | None, nodes: Indices | None = None
) -> Array:
    """(n, 3) nodes of a body as the lattices before one leave them; those asked for, at least."""
    steps = before(model, item)
    if nodes is None:
        return deformed(body.mesh.points, steps)
    points = np.array(body.mesh.points)
    points[nodes] = deformed(points[nodes], steps)
    return points


def before(model: Model, item: LatticeItem | None) -> tuple[LatticeItem, ...]:
    """Lattices that deform before one; all without one."""
    steps = model.steps
    if item is None:
        return steps
    keys = [other.key for other in steps]
    if item.key not in keys:
        raise InputError(f"{item.name} is switched off")
    return steps[: keys.index(item.key)]
