"""An external program as an objective.

For each evaluation the program is started in a new folder. It finds there

``points.csv``      x,y,z of each point, in the order of the mesh
``variables.json``  the design variables (null for a shape beyond them, which a refinement asks
                    for) and whether a gradient is wanted
``mesh.*``          the morphed mesh in its own format, if the study has one

and leaves ``result.json``: ``{"value": 1.5, "measures": {"cl": 0.4}}``, and, if it can,
``sensitivity.csv`` with d value / d x,y,z of each point. Its output is kept in ``output.txt``.
A program that fails, hangs or leaves nonsense ends the study with the reason; nothing is lost.
One that takes too long, or runs when the study is stopped, is ended with all that it has started.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Lock
from typing import TYPE_CHECKING, Annotated, Any, Self

import msgspec
import numpy as np
from msgspec import Meta

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.optimize.consent import Order, located, require
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request, Start
from ffdstudio.optimize.objectives.failures import EvaluationError
from ffdstudio.optimize.objectives.identity import program_files
from ffdstudio.optimize.objectives.process import run_program
from ffdstudio.optimize.spec.fields import Positive, Processes, Text, says
from ffdstudio.optimize.spec.goals import ObjectiveSpec, moved_file

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.shapes import Shape


class ExternalProgram(Objective):
    """Any executable.

    Parameters
    ----------
    command : sequence of str
        Program and arguments; started without a shell.
    folder : path
        Where the folders of the evaluations go.
    mesh : Mesh, optional
        Written morphed into each folder; its points are the study's.
    sensitivity : bool
        Whether the program writes ``sensitivity.csv``; else finite differences take its place.
    time_limit : float
        Seconds.
    processes : int
        Programs at the same time, for finite differences.
    """

    def __init__(
        self,
        command: Sequence[str],
        folder: str | Path,
        mesh: Any = None,
        sensitivity: bool = False,
        time_limit: float = 3600.0,
        processes: int = 1,
    ) -> None:
        if not command:
            raise InputError("the external program has no command")
        self.command, self.folder, self.mesh = list(command), Path(folder), mesh
        self.abilities = Abilities(gradient=sensitivity, batch=processes)
        self.time_limit = time_limit
        self._number, self._lock = 0, Lock()

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        wanted = request.gradient and self.abilities.gradient
        place = self._prepare(request, wanted)
        self._run(place, request.stopped)
        return self._result(place, len(request.points), wanted)

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """See `Objective`: programs run beside each other."""
        abandoned = Event()

        def begin(request: Request) -> Future[Evaluation]:
            stopped = request.stopped

            def over() -> bool:
                return stopped() or abandoned.is_set()

            return pool.submit(self.answer, request._replace(gradient=False, stopped=over))

        pool = ThreadPoolExecutor(self.abilities.batch)
        try:
            yield begin
        except BaseException:
            abandoned.set()
            raise
        finally:
            pool.shutdown(cancel_futures=True)

    def _prepare(self, request: Request, gradient: bool) -> Path:
        place = self._new_folder()
        lines = [",".join(map(repr, row)) for row in request.points.tolist()]
        write_bytes(place / "points.csv", ("\n".join(lines) + "\n").encode())
        said = {"variables": request.variables, "gradient": gradient}
        write_bytes(place / "variables.json", json.dumps(said).encode())
        if self.mesh is not None:
            from ffdstudio.meshes import write_mesh
            from ffdstudio.meshes.formats import suffix_of

            suffix = suffix_of(Path(self.mesh.path)) if self.mesh.path else ".vtu"
            write_mesh(self.mesh, place / f"mesh{suffix}", request.points)
        return place

    def _new_folder(self) -> Path:
        while True:
            with self._lock:
                self._number += 1
                place = self.folder / f"{self._number:06d}"
            try:
                place.mkdir(parents=True)
                return place
            except FileExistsError:
                continue  # of an earlier run of the study
            except OSError as error:
                raise InputError(f"cannot make the folder {place}: {error.strerror}") from error

    def _run(self, place: Path, stopped: Callable[[], bool]) -> None:
        name = self.command[0]
        try:
            status = run_program(self.command, place, self.time_limit, stopped)
        except TimeoutError as error:
            limit = f"{self.time_limit:g} s"
            raise EvaluationError(f"{name} took more than {limit} in {place}") from error
        except OSError as error:
            cause = (error.strerror or str(error)).lower()
            raise EvaluationError(f"cannot start {name}: {cause}") from error
        if status != 0:
            raise EvaluationError(
                f"{name} ended with status {status} in {place}: {_last_line(place / 'output.txt')}"
            )

    def _result(self, place: Path, count: int, gradient: bool) -> Evaluation:
        path = place / "result.json"
        try:
            value, measures = _values(read_bytes(path))
        except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
            raise EvaluationError(f"{path} does not hold a value: {error}") from error
        except RecursionError as error:
            raise EvaluationError(f"{path} does not hold a value: nested too deeply") from error
        for name, number in {"value": value, **measures}.items():
            if not math.isfinite(number):
                raise EvaluationError(f"{path} holds the {name} {number}, no finite number")
        rows = _sensitivity(place / "sensitivity.csv", count) if gradient else None
        return Evaluation(value, rows, flow=1, adjoint=int(gradient), measures=measures)


def _values(data: bytes) -> tuple[float, dict[str, float]]:
    """Value and measures of ``result.json``; NaN gets a message of its own."""
    result = json.loads(data)
    measures = result.get("measures", {})
    return _number(result["value"], "value"), {k: _number(v, k) for k, v in measures.items()}


def _number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{name} is {json.dumps(value)[:40]}, no number")
    return float(value)


def _sensitivity(path: Path, count: int) -> Array:
    try:
        rows = np.loadtxt(read_bytes(path).decode().splitlines(), delimiter=",", ndmin=2)
    except (ValueError, OverflowError) as error:
        raise EvaluationError(f"{path} is no table of numbers: {error}") from error
    if rows.shape != (count, 3) or not np.isfinite(rows).all():
        raise EvaluationError(f"{path} must hold {count} rows of three finite numbers")
    return rows


def _last_line(path: Path) -> str:
    lines = read_bytes(path).decode(errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "it printed nothing")


class ProgramSpec(ObjectiveSpec, frozen=True, kw_only=True, tag="program"):
    """Ask an external program, by finite differences if it writes no derivatives."""

    title = "Ask a program"
    whole = True
    runs_code = True

    command: Annotated[
        Annotated[tuple[Text, ...], Meta(min_length=1)],
        says("Command", "program and arguments; a word with a slash is looked for beside the case "
             "file, another one on the PATH"),
    ]  # fmt: skip
    sensitivity: Annotated[
        bool, says("Writes derivatives", "whether the program leaves sensitivity.csv")
    ] = False
    time_limit: Annotated[
        Positive, says("Time limit", "a run that takes longer ends the study", "s")
    ] = 3600.0
    processes: Annotated[
        Processes, says("Processes", "programs at the same time, for finite differences")
    ] = 1

    def moved(self, change: Callable[[str], str]) -> Self:
        """See `ObjectiveSpec`: words with a slash are files."""
        words = (moved_file(w, change) if "/" in w else w for w in self.command)
        return msgspec.structs.replace(self, command=tuple(words))

    def require(self, place: Place) -> None:
        """See `ObjectiveSpec`."""
        require(Order("program", self.command, place.source), place.consent)

    def build(self, shape: Shape, place: Place) -> Objective:
        """See `ObjectiveSpec`."""
        self.require(place)
        if place.folder is None:
            raise InputError("an external program needs a folder for its evaluations: -o DIR")
        command = located(self.command, place.beside)
        return ExternalProgram(
            command, place.folder / "runs", shape.mesh, self.sensitivity, self.time_limit,
            self.processes,
        )  # fmt: skip

    def files(self, shape: Shape, place: Place) -> list[Path]:
        """See `ObjectiveSpec`."""
        mesh = None if shape.mesh is None else shape.mesh.path
        return [
            *program_files(located(self.command, place.beside)),
            *([] if mesh is None else [Path(mesh)]),
        ]
