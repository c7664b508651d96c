"""Mutated files of every format: a clear error or a correct mesh, never anything else.

500 files in the suite, 20 000 in the campaign (``make campaign``), each a seeded mutation of a
specimen. Nothing but `InputError` may come out, within 10 s and with at most 20 times the
file's size plus 200 MB of memory.
"""

from __future__ import annotations

import shutil
import time
import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import Mesh
from tests.meshes.specimens import SPECIMENS
from tests.meshes.test_abaqus import DECK as ABAQUS
from tests.meshes.test_airfoil import LEDNICER, SELIG
from tests.meshes.test_nastran import DECK as NASTRAN
from tests.meshes.test_openfoam import CASES, add_zones, make
from tests.meshes.test_su2 import TRAPS, ZONES

TEXTS = {
    "traps.su2": TRAPS,
    "zones.su2": ZONES,
    "deck.bdf": NASTRAN.encode(),
    "deck.inp": ABAQUS.encode(),
    "selig.dat": SELIG.encode(),
    "lednicer.dat": LEDNICER.encode(),
}
NUMBERS = [
    b"-1",
    b"0",
    b"nan",
    b"inf",
    b"1e999",
    b"99999999999999999999",
    b"4294967296",
    b"7fffffff",
    b"x",
]


@pytest.fixture(scope="module")
def seeds(tmp_path_factory) -> list[tuple[Path, Path]]:
    """Files to mutate, each with the path to open (a case folder for OpenFOAM)."""
    folder = tmp_path_factory.mktemp("seeds")
    for name, write in SPECIMENS.items():
        write(folder / name)
    for name, data in TEXTS.items():
        (folder / name).write_bytes(data)
    found = [(path, path) for path in sorted(folder.iterdir())]
    for name in ("ascii", "binary 32/64", "binary.gz"):
        case = make(folder / name.replace("/", "-"), **CASES[name])
        if "gz" not in name:
            add_zones(case, CASES[name].get("arch"))
        found += [(path, case) for path in sorted((case / "constant" / "polyMesh").iterdir())]
    return found


def mutated(rng: np.random.Generator, data: bytes) -> bytes:
    """One to four mutations of a file."""
    for _ in range(rng.integers(1, 5)):
        data = _once(rng, data) or b""
    return data


def _once(rng: np.random.Generator, data: bytes) -> bytes:
    if not data:
        return bytes(rng.integers(0, 256, 20, dtype=np.uint8))
    a, b = sorted(rng.integers(0, len(data) + 1, 2).tolist())
    b = min(b, a + int(rng.integers(1, 200)))
    match rng.integers(0, 8):
        case 0:
            return data[:a]
        case 1:
            return data[:a] + data[b:]
        case 2:
            return data[:b] + data[a:b] * int(rng.integers(1, 4)) + data[b:]
        case 3:
            noise = bytes(rng.integers(0, 256, max(b - a, 1) % 9 + 1, dtype=np.uint8))
            return data[:a] + noise + data[a + len(noise) :]
        case 4:
            at = int(rng.integers(0, len(data)))
            return data[:at] + bytes([data[at] ^ (1 << int(rng.integers(0, 8)))]) + data[at + 1 :]
        case 5:
            return _other_number(rng, data, a)
        case 6:
            lines = data.split(b"\n")
            i, j = rng.integers(0, len(lines), 2)
            lines[i], lines[j] = lines[j], lines[i]
            return b"\n".join(lines)
        case _:
            size = min(int(rng.choice([1, 4, 8])), len(data) - a)
            return data[:a] + bytes([int(rng.choice([0, 255, 127]))]) * size + data[a + size :]


def _other_number(rng: np.random.Generator, data: bytes, at: int) -> bytes:
    """Replace the number at a place or behind it."""
    while at < len(data) and not data[at : at + 1].isdigit():
        at += 1
    end = at
    while end < len(data) and data[end : end + 1].isdigit():
        end += 1
    return data[:at] + NUMBERS[rng.integers(len(NUMBERS))] + data[end:]


def attempt(path: Path, opened: Path, size: int) -> bool:
    """Read a file and write it again; return whether it was a mesh. Anything odd raises."""
    tracemalloc.reset_peak()
    before = tracemalloc.get_traced_memory()[0]
    start = time.perf_counter()
    mesh: Mesh | None = None
    try:
        mesh = read_mesh(opened)
    except InputError as error:
        message = str(error)
        assert len(message) > 10
        assert "\n" not in message
    seconds = time.perf_counter() - start
    assert seconds < 10, f"{path.name}: {seconds:.1f} s"
    peak = tracemalloc.get_traced_memory()[1] - before
    assert peak < 20 * size + 200e6, f"{path.name}: {peak / 1e6:.0f} MB for {size} bytes"
    if mesh is None:
        return False
    check(mesh)
    if mesh.template is not None and path == opened:
        target = path.with_name(f"out-{path.name}")
        write_mesh(mesh, target)
        assert target.read_bytes() == path.read_bytes()
        target.unlink()
    return True


def check(mesh: Mesh) -> None:
    """A mesh that was read must be usable."""
    assert np.isfinite(mesh.points).all()
    for cells in (mesh.cells, mesh.surface(), *mesh.markers.values()):
        for nodes in cells.values():
            assert nodes.size == 0 or 0 <= nodes.min() <= nodes.max() < len(mesh.points)
    assert all(count >= 0 for count in mesh.counts.values())


def campaign(seeds: list[tuple[Path, Path]], folder: Path, count: int, seed: int) -> int:
    rng = np.random.default_rng(seed)
    good = 0
    tracemalloc.start()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for k in range(count):
                original, opened = seeds[rng.integers(len(seeds))]
                data = mutated(rng, original.read_bytes())
                if opened != original:
                    case = folder / "case"
                    shutil.rmtree(case, ignore_errors=True)
                    shutil.copytree(opened, case)
                    path, opened = case / "constant" / "polyMesh" / original.name, case
                else:
                    path = opened = folder / original.name
                path.write_bytes(data)
                try:
                    good += attempt(path, opened, len(data))
                except BaseException:
                    kept = folder / f"failed-{seed}-{k}-{original.name}"
                    kept.write_bytes(data)
                    print(f"kept {kept}")
                    raise
    finally:
        tracemalloc.stop()
    return good


def test_500_mutated_files_give_an_error_or_a_mesh(seeds, tmp_path):
    good = campaign(seeds, tmp_path, 500, seed=1)
    assert 10 < good < 490  # the mutations are neither harmless nor all fatal


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(2, 42))
def test_20_000_mutated_files_give_an_error_or_a_mesh(seeds, tmp_path, seed):
    campaign(seeds, tmp_path, 500, seed)
