"""How a study of a document speaks of its bodies and lattices.

By their keys in angle brackets, as in "<body1>", which survive renaming; in a project file, where
keys are given anew, by their names.
"""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from ffdstudio.optimize.build.place import given, is_given
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.model import Model


def key_of(source: str) -> str | None:
    """Key of the body or lattice that a source names; None of a file.

    Examples
    --------
    >>> key_of("<body1>"), key_of("wing.su2")
    ('body1', None)
    """
    return source[1:-1] if is_given(source) else None


def renamed(study: StudySpec, change: Callable[[str], str]) -> StudySpec:
    """The same study with other words for bodies and lattices of the document."""

    def new(source: str) -> str:
        key = key_of(source)
        return source if key is None else given(change(key))

    shape = msgspec.structs.replace(study.shape, source=new(study.shape.source))
    lattice = msgspec.structs.replace(study.lattice, file=new(study.lattice.file))
    return msgspec.structs.replace(study, shape=shape, lattice=lattice)


def with_names(study: StudySpec, model: Model) -> StudySpec:
    """A study that speaks of names, as a project file does."""
    names = {item.key: item.name for item in model.items}
    return renamed(study, lambda key: names.get(key, key))


def with_keys(study: StudySpec, model: Model) -> StudySpec:
    """A study that speaks of keys, as the document does."""
    keys = {item.name: item.key for item in model.items}
    return renamed(study, lambda name: keys.get(name, name))
