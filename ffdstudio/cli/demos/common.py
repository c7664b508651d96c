"""What the cases of the demo share: the sample mesh, the project, pictures and a clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ffdstudio.cli.output import note
from ffdstudio.engine import Lattice
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.paths import exists
from ffdstudio.project import Project
from ffdstudio.samples import sample

MESH = "naca0012.su2"
FROZEN = 2  # layers: the mesh goes on outside the lattice, with a continuous tangent


def copied_mesh(folder: Path) -> Path:
    """Copy the sample mesh beside the results: the folder can then be moved as a whole."""
    source, data = folder / MESH, read_bytes(sample(MESH))
    if not exists(source) or read_bytes(source, to_update=True) != data:  # another case's copy
        write_bytes(source, data)
    return source


def save_project(path: Path, source: Path, rest: Lattice, current: Lattice) -> None:
    """Project of the sample mesh and the lattice in its vicinity."""
    project = Project()
    project.add_mesh(source, "NACA 0012")
    project.add_lattice("vicinity", rest, current, frozen=FROZEN)
    project.save(path)


def rendered(draw: Callable[[], list[str]]) -> list[str]:
    """Names of the pictures that a function has drawn; none where nothing can be rendered."""
    try:
        return draw()
    except Exception as error:  # graphics fail in as many ways as there are drivers
        note(f"no pictures, nothing can be rendered here ({type(error).__name__}: {error})")
        return []


class Clock:
    """Seconds of each step by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def __call__(self, name: str, step: Callable[[], Any]) -> Any:
        """Take a step and its time."""
        begin = time.perf_counter()
        value = step()
        self.seconds[name] = round(time.perf_counter() - begin, 6)
        return value
