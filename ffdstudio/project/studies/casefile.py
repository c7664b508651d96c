"""Studies of a document as case files, and case files as studies of a document.

1. A case file stands for itself: bodies become paths of their meshes, lattices become files
   beside the case, also those that deform the body before; names of files are told from there.
2. Back in a document a mesh that is open is its body again; all other files become absolute.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import msgspec

from ffdstudio.aliases import PathLike
from ffdstudio.errors import InputError
from ffdstudio.exchange import write_lattice
from ffdstudio.files import write_bytes
from ffdstudio.optimize.build.place import given, is_given
from ffdstudio.optimize.build.shape import AIRFOILS
from ffdstudio.optimize.geometry.sections import is_naca
from ffdstudio.optimize.spec.codec import checked, read_study, to_toml
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.model import LatticeItem, Model
from ffdstudio.project.studies.place import before, body_of, lattice_of


def write_case(study: StudySpec, model: Model, path: PathLike) -> list[Path]:
    """Write a study of a model as a case file; returns it and the lattice files beside it.

    Raises
    ------
    InputError
        If the study is not complete, its mesh is no file, or a file cannot be written.
    """
    target = Path(path)
    study = checked(study)
    written = [target]

    def beside(item: LatticeItem) -> str:
        name = f"{target.stem}.{item.key}.lattice.json"
        current = item.current if item.deformed else item.rest
        write_lattice(target.parent / name, item.rest, current, frozen=item.frozen,
                      open_faces=item.open_faces)  # fmt: skip
        written.append(target.parent / name)
        return name

    case = _standing_alone(study, model, target.parent, beside)
    write_bytes(target, to_toml(case).encode())
    return written


def _standing_alone(
    study: StudySpec, model: Model, folder: Path, beside: Callable[[LatticeItem], str]
) -> StudySpec:
    body, item = body_of(study, model), lattice_of(study, model)
    shape, lattice, origin = study.shape, study.lattice, Path.cwd()
    if body is not None:
        if not body.path.exists():
            raise InputError(f"the mesh of {body.name} is no file: export it first")
        origin = body.path.parent
        earlier = tuple(beside(one) for one in before(model, item) if one.deformed)
        shape = msgspec.structs.replace(
            shape, source=_relative(body.path, folder), lattices=earlier
        )  # fmt: skip
    if item is not None:
        lattice = msgspec.structs.replace(lattice, file=beside(item))
        if body is not None:  # without a lattice yet, the study will have it follow its walls
            shape = msgspec.structs.replace(shape, follow=body.follows)
    objective = study.objective.moved(lambda name: _relative(origin / name, folder))
    return msgspec.structs.replace(study, shape=shape, lattice=lattice, objective=objective)


def _relative(path: Path, folder: Path) -> str:
    """Path from a folder, with a slash in it; absolute where there is no way."""
    try:
        found = os.path.relpath(path, folder)
    except ValueError:  # another drive
        return os.fspath(path)
    return found if os.sep in found else f".{os.sep}{found}"


def read_case_for(path: PathLike, model: Model) -> StudySpec:
    """Read a case file as a study of a model.

    A mesh that is a body of the model becomes that body; everything else stays a file.

    Raises
    ------
    InputError
        As `read_study`.
    """
    study, folder = read_study(path), Path(path).resolve().parent
    shape = study.shape
    if not is_naca(shape.source):
        shape = msgspec.structs.replace(shape, source=_body(study, model, folder))
        shape = msgspec.structs.replace(
            shape, lattices=tuple(os.fspath(folder / name) for name in shape.lattices)
        )
    lattice = study.lattice
    if lattice.file:
        lattice = msgspec.structs.replace(lattice, file=os.fspath(folder / lattice.file))
    objective = study.objective.moved(lambda name: os.path.normpath(folder / name))
    return msgspec.structs.replace(study, shape=shape, lattice=lattice, objective=objective)


def _body(study: StudySpec, model: Model, folder: Path) -> str:
    """The body that a source is, or the path of its file."""
    path = Path(os.path.normpath(folder / study.shape.source))
    alone = study.shape.normalise and path.suffix.lower() in AIRFOILS  # of chord 1, unlike a body
    for body in model.bodies:
        if (
            not alone
            and not study.shape.lattices
            and os.path.realpath(path) == os.path.realpath(body.path)
        ):
            return given(body.key)
    return os.fspath(path)


def mesh_to_open(study: StudySpec) -> Path | None:
    """Mesh that a study is about and the document does not have; None if there is none."""
    source = study.shape.source
    if is_given(source) or is_naca(source) or study.shape.lattices:
        return None
    path = Path(source)
    alone = study.shape.normalise and path.suffix.lower() in AIRFOILS
    return None if alone else path
