"""What a study of the document needs before it can begin, and the lattice that it makes."""

from __future__ import annotations

from pathlib import Path

import msgspec

from ffdstudio.errors import InputError
from ffdstudio.optimize.build.build import Built, build, check_method
from ffdstudio.optimize.build.lattice import box_of
from ffdstudio.optimize.build.place import given
from ffdstudio.optimize.build.shape import lattice_pair, profile_nodes, shape_of
from ffdstudio.optimize.consent import Consent
from ffdstudio.optimize.geometry.profiles import profiles
from ffdstudio.optimize.spec.codec import checked as checked_values
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.commands import AddLattice, CreateBox
from ffdstudio.project.commands.base import Command
from ffdstudio.project.model import Body, Model
from ffdstudio.project.studies.following import following_bodies
from ffdstudio.project.studies.place import body_of, lattice_of, place_of

NAME = "Study lattice"


def checked(study: StudySpec, model: Model) -> StudySpec:
    """Return the study if it can begin.

    Raises
    ------
    InputError
        If something is missing, or the lattice is not the last one that deforms the body.
    """
    study = checked_values(study)
    check_method(study)
    body, item = body_of(study, model), lattice_of(study, model)
    if body is not None and not is_flat(body, study.shape.marker):
        if study.objective.needs == "section":
            raise InputError(f"{_part(body, study.shape.marker)} is no airfoil section")
        if item is None and not study.lattice.file:
            raise InputError("build a lattice around the surface first")
    if item is not None:
        later = model.steps[model.steps.index(item) + 1 :] if item in model.steps else None
        if later is None:
            raise InputError(f"{item.name} is switched off")
        if any(other.deformed for other in later):
            raise InputError(f"{later[-1].name} deforms what {item.name} leaves; switch it off")
    return study


def is_flat(body: Body, marker: str) -> bool:
    """Whether a part of a body is an airfoil section."""
    return any(profile.marker == marker for profile in profiles(body.mesh))


def _part(body: Body, marker: str) -> str:
    return f"the marker {marker} of {body.name}" if marker else body.name


def new_lattice(study: StudySpec, model: Model) -> Command:
    """Command that makes the lattice of a study that has none in the document."""
    body = body_of(study, model)
    nodes = None if body is None else profile_nodes(body.mesh, study.shape.marker)
    place, frozen = place_of(study, model, nodes=nodes), study.variables.frozen
    if study.lattice.file:
        pair = lattice_pair(study.lattice.file, place)
        return AddLattice(NAME, pair.rest, pair.current, frozen)
    assert study.lattice.shape is not None
    rest = box_of(study.lattice, study.lattice.shape, shape_of(study, place))
    (*lower,), (*upper,) = rest.domain.T.tolist()
    zeros = (0.0,) * (3 - len(lower))
    return CreateBox(
        NAME, (*lower, *zeros), (*upper, *zeros), rest.shape, rest.degrees,
        spacing=study.lattice.spacing, frozen=frozen,
    )  # fmt: skip


def on_lattice(study: StudySpec, key: str) -> StudySpec:
    """The same study on a lattice of the document."""
    lattice = msgspec.structs.replace(study.lattice, file=given(key))
    return msgspec.structs.replace(study, lattice=lattice)


def prepare(
    study: StudySpec,
    model: Model,
    folder: Path | None = None,
    source: Path | None = None,
    consent: Consent | None = None,
) -> Built:
    """Build the run of a study of a model; takes a while and belongs into a worker.

    Parameters
    ----------
    folder : path, optional
        Of its log, evaluations and runs of programs.
    source, consent : optional
        Project that the study came inside, and what may run of it.

    Raises
    ------
    InputError
        If a target cannot be read, or the parts of the study do not fit.
    """
    built = build(study, place_of(study, model, folder, source=source, consent=consent))
    item = lattice_of(study, model)
    return built if item is None else built.keeping(list(following_bodies(model, item)))
