"""Boxes of pyGeo: PLOT3D, ASCII, the values being the control points.

``nBlocks``, then ``ni nj nk`` of every block, then for each block all x (i fastest), all y,
all z. Knots are implied: clamped uniform, of order min(4, n). There are no weights.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.engine.knots import clamped_uniform
from ffdstudio.errors import InputError
from ffdstudio.exchange.conversion import ConversionRules, adapted
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.text import chosen, integer, naming, tokens, vector
from ffdstudio.exchange.ties import untied
from ffdstudio.files import write_bytes
from ffdstudio.limits import check_control_points


def _degree(count: int, degree: int) -> int:
    return min(3, count - 1)


RULES = ConversionRules("PLOT3D", uniform=True, weights=False, degree=_degree)


def recognises(data: bytes) -> bool:
    """Whether it starts with a count of blocks and three numbers a block."""
    try:
        head = [int(token) for token in data[:200].split()[:4]]
    except ValueError:
        return False
    return len(head) == 4 and min(head) > 0


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read one block of a PLOT3D file."""
    words = tokens(data, name)
    sizes, start = _sizes(words, name)
    counts = [3 * ni * nj * nk for ni, nj, nk in sizes]
    if len(words) - start != sum(counts):
        raise InputError(
            f"{name}: {sum(counts)} coordinates are announced, {len(words) - start} follow"
        )
    names = tuple(str(k) for k in range(len(sizes)))
    index = chosen(names, block, name, "block")
    with naming(f"{name}: block {index}"):
        check_control_points(sizes[index])
    values, ends = vector(words[start:], name), np.cumsum([0, *counts])
    nets = [
        values[ends[k] : ends[k + 1]].reshape(3, *reversed(size)).T for k, size in enumerate(sizes)
    ]
    net = nets[index]
    with naming(f"{name}: block {index}"):
        lattice = _lattice(net)
    note = Exactness(True, "knots as pyGeo implies them: uniform, of degree min(3, n - 1)")
    told = untied(nets, names, index, "block")
    return LatticeFile(lattice, lattice, exactness=note, format="plot3d", blocks=names, notes=told)


def write(path: Path, content: LatticeFile, adapt: str = "refuse") -> Exactness:
    """Write one block."""
    fitting, exactness = adapted(content, RULES, adapt)
    net = fitting.current.control_points
    lines = ["1", " ".join(map(str, net.shape[:3]))]
    for axis in range(3):
        lines += [
            " ".join(map(repr, row)) for row in net[..., axis].T.reshape(-1, len(net)).tolist()
        ]
    write_bytes(path, ("\n".join(lines) + "\n").encode())
    return exactness


def _sizes(words: list[bytes], name: str) -> tuple[list[tuple[int, int, int]], int]:
    blocks = integer(words[0], name, "the number of blocks")
    if not 1 <= blocks <= len(words) // 3:
        raise InputError(f"{name}: cannot hold {blocks} blocks")
    numbers = [integer(word, name, "a block's size") for word in words[1 : 1 + 3 * blocks]]
    if len(numbers) < 3 * blocks or min(numbers) < 2:
        raise InputError(f"{name}: every block needs three sizes of at least 2")
    sizes = [(numbers[k], numbers[k + 1], numbers[k + 2]) for k in range(0, 3 * blocks, 3)]
    return sizes, 1 + 3 * blocks


def _lattice(net: np.ndarray) -> Lattice:
    degrees = [min(3, n - 1) for n in net.shape[:3]]
    knots = [clamped_uniform(n, p) for n, p in zip(net.shape[:3], degrees, strict=True)]
    return Lattice(degrees, knots, net)
