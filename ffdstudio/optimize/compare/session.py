"""A comparison over many targets: in processes, and resumed where it was killed.

1. Each target's result is one file, put in place whole; a run that is killed loses what was
   being computed. Results of other settings are made again.
2. Targets are taken in the order of the lottery until there are enough that could be read.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.optimize.compare.protocol import Case, Protocol, drawn
from ffdstudio.optimize.compare.rivals import Modes
from ffdstudio.optimize.compare.trial import result_of

Result = dict[str, Any]
SUFFIXES = (".dat", ".txt")
LIBRARY_POINTS = 201
TARGETS, SETTINGS = "targets", "settings.json"


def sections_in(folder: Path, without: Sequence[Path] = ()) -> list[Path]:
    """Airfoil files of a folder, without those whose name is in one of the others.

    Raises
    ------
    InputError
        If there are none.
    """
    if not folder.is_dir():
        raise InputError(f"{folder} is no folder of airfoil files")
    left_out = {path.stem.lower() for other in without for path in other.iterdir()}
    found = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    found = [path for path in found if path.stem.lower() not in left_out]
    if not found:
        raise InputError(f"there are no airfoil files in {folder}")
    return found


def modes_of(files: Sequence[Path]) -> Modes:
    """Modes of all sections of a library that can be read; unreadable ones are left out."""
    from ffdstudio.optimize.geometry.sections import opened, target_contour, trailing_gap

    rows = []
    for path in files:
        try:
            contour = target_contour(str(path))
            points = opened(contour.sample(LIBRARY_POINTS), -trailing_gap(contour))
        except InputError:
            continue
        rows.append(points[:, 1] - points[len(points) // 2, 1])
    if len(rows) < 2:
        raise InputError("a library of modes needs two readable sections")
    return Modes(np.array(rows))


def compare(
    files: Sequence[Path],
    protocol: Protocol,
    folder: Path,
    processes: int = 1,
    seconds: float | None = None,
    modes: Modes | None = None,
    listener: Callable[[Result], None] = lambda result: None,
) -> list[Result]:
    """Compare on targets until there are enough, or the time is over; results in their order.

    Parameters
    ----------
    files : sequence of path
        To draw targets from.
    folder : path
        Where results are kept, and found when it is called again.
    seconds : float, optional
        No further target is begun after so long.
    listener : callable, optional
        Told of each new result.
    """
    cases = drawn(files, protocol)
    (folder / TARGETS).mkdir(parents=True, exist_ok=True)
    settings = json.dumps({**protocol.to_json(), "digest": protocol.digest}, indent=1)
    write_bytes(folder / SETTINGS, settings.encode())
    until = np.inf if seconds is None else time.monotonic() + seconds
    known = {case: _known(folder, case, protocol) for case in cases}
    for case, result in _new(cases, known, protocol, processes, until, modes):
        text = json.dumps(result)
        write_bytes(_place(folder, case), text.encode())
        known[case] = json.loads(text)  # as it will be found again
        listener(result)
    return _enough(cases, known, protocol)


def _new(
    cases: list[Case], known: dict[Case, Result | None], protocol: Protocol, processes: int,
    until: float, modes: Modes | None,
) -> Iterator[tuple[Case, Result]]:  # fmt: skip
    """Results that are not there yet, as they come."""
    waiting = iter(case for case in cases if known[case] is None)
    running: dict[Future[Result], Case] = {}
    done = sum(_counts(result) for result in known.values())
    pool = ProcessPoolExecutor(processes, mp_context=get_context("spawn"))
    try:
        while True:
            while len(running) < processes and done + len(running) < protocol.count:
                case = next(waiting, None) if time.monotonic() < until else None
                if case is None:
                    break
                running[pool.submit(result_of, case, protocol, modes)] = case
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                case, result = running.pop(future), future.result()
                done += _counts(result)
                yield case, result
    finally:
        pool.shutdown(cancel_futures=True)


def _counts(result: Result | None) -> bool:
    return result is not None and "refused" not in result


def _enough(
    cases: list[Case], known: dict[Case, Result | None], protocol: Protocol
) -> list[Result]:
    """The first results of the lottery that make up the number of targets, with those refused."""
    found: list[Result] = []
    for case in cases:
        result = known[case]
        if sum(map(_counts, found)) == protocol.count:
            break
        if result is not None:
            found.append(result)
    return found


def _place(folder: Path, case: Case) -> Path:
    return folder / TARGETS / f"{case.path.name}.json"


def _known(folder: Path, case: Case, protocol: Protocol) -> Result | None:
    """A result that is there, whole, and of the same settings."""
    path = _place(folder, case)
    if not path.exists():
        return None
    try:
        result = json.loads(read_bytes(path))
    except ValueError:
        return None
    same = isinstance(result, dict) and result.get("digest") == protocol.digest
    return result if same else None
