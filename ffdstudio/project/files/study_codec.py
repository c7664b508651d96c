"""Studies of a document in its project file: descriptions and records."""

from __future__ import annotations

from typing import Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.optimize.runs.record import parsed_log, written_log
from ffdstudio.optimize.spec.codec import from_values, to_values
from ffdstudio.project.commands import AddStudy, Command
from ffdstudio.project.files.records import ProjectFile, StudyFile
from ffdstudio.project.model import Model
from ffdstudio.project.study_names import with_keys, with_names
from ffdstudio.project.study_records import StudyRecords

SECTION = "studies"


def study_files(model: Model, records: StudyRecords) -> list[StudyFile]:
    """What a project file holds of the studies of a model."""
    return [
        StudyFile(item.name, to_values(with_names(item.spec, model)), records.of(item.key))
        for item in model.studies
    ]


def study_command(stored: StudyFile, model: Model) -> Command:
    """Command that adds a stored study.

    Raises
    ------
    InputError
        If its description says something that no study can say.
    """
    try:
        spec = with_keys(from_values(stored.values), model)
    except InputError as error:
        raise InputError(f"the study {stored.name}: {error}") from error
    return AddStudy(model.free_name(stored.name), spec)


# ---- the section of the file ---------------------------------------------------------------


def section_of(content: ProjectFile) -> list[dict[str, Any]]:
    """The studies as a section; logs are bytes in arrays. For a worker."""
    return [
        {
            "name": study.name,
            "study": study.values,
            "log": np.frombuffer(written_log(study.records), dtype=np.uint8),
        }
        for study in content.studies
    ]


def studies_of(section: Any) -> list[StudyFile]:
    """Inverse of `section_of`; what is no study is left out, a damaged line costs that line."""
    entries = section if isinstance(section, list) else []
    return [_study(one, number) for number, one in enumerate(entries, 1) if isinstance(one, dict)]


def _study(entry: dict[str, Any], number: int) -> StudyFile:
    name, values, log = (entry.get(key) for key in ("name", "study", "log"))
    known = isinstance(log, np.ndarray) and log.dtype == np.uint8
    return StudyFile(
        name if isinstance(name, str) and name.strip() else f"Study {number}",
        values if isinstance(values, dict) else {},
        parsed_log(log.tobytes()) if known else [],  # type: ignore[union-attr]
    )
