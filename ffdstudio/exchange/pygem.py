"""PyGeM's ``.prm``: a Bezier box at rest and displacements of its control points.

1. The box is ``origin + R diag(length) s`` with s in the unit cube and R = Rx Ry Rz.
2. "Parameters weights" are displacements as fractions of the box length of that axis in the
   box's own frame, no NURBS weights. Control points not listed stay.
3. The basis is Bernstein's, of degree n - 1, and the points are equally spaced.
"""

from __future__ import annotations

import configparser
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.knots import clamped_uniform
from ffdstudio.errors import InputError
from ffdstudio.exchange.conversion import ConversionRules, adapted
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.text import chosen, integer, naming, vector
from ffdstudio.files import write_bytes
from ffdstudio.limits import check_control_points


def _degree(count: int, degree: int) -> int:
    return count - 1


RULES = ConversionRules("PyGeM .prm", uniform=True, weights=False, degree=_degree, one_net=False)


def recognises(data: bytes) -> bool:
    """Whether it has PyGeM's sections."""
    return b"[Box info]" in data and b"[Parameters weights]" in data


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read box and displacements."""
    chosen(("0",), block, name, "lattice")
    ini = configparser.ConfigParser(interpolation=None)
    try:
        ini.read_string(data.decode("utf-8"))
        box, weights = ini["Box info"], ini["Parameters weights"]
        counts = [integer(box[f"n control points {a}"].encode(), name, "a count") for a in "xyz"]
        length, origin, angles = (
            vector([box[f"{key} {a}"].encode() for a in "xyz"], name)
            for key in ("box length", "box origin", "rotation angle")
        )
        texts = [weights[f"parameter {a}"] for a in "xyz"]
    except UnicodeDecodeError:
        raise InputError(f"{name}: not a text file") from None
    except KeyError as error:
        raise InputError(f"{name}: {error.args[0]!r} is missing") from None
    except configparser.Error as error:
        raise InputError(f"{name}: {_cause(error)}") from None
    if min(counts) < 2:
        raise InputError(f"{name}: {counts} control points: each direction needs at least 2")
    with naming(name):
        check_control_points(counts)
    if not (length > 0).all():
        raise InputError(f"{name}: the lengths of the box must be positive")
    net, span = _box(tuple(counts), length, origin, angles)
    knots = [clamped_uniform(n, n - 1) for n in counts]
    rest = Lattice([n - 1 for n in counts], knots, net)
    moves = np.stack([_moves(text, counts, name) for text in texts], axis=-1)
    return LatticeFile(rest, rest.moved(net + moves @ span), format="pygem", blocks=("0",))


def _cause(error: configparser.Error) -> str:
    if isinstance(error, configparser.DuplicateSectionError | configparser.DuplicateOptionError):
        return f"{getattr(error, 'option', error.section)!r} already exists, line {error.lineno}"
    if isinstance(error, configparser.MissingSectionHeaderError):
        return f"there is no section before line {error.lineno}"
    lines = getattr(error, "errors", [])  # of a ParsingError, but not of all kinds
    place = f"line {lines[0][0]} is" if lines else "these are"
    return f"{place} nothing that PyGeM's parameters have"


def write(path: Path, content: LatticeFile, adapt: str = "refuse") -> Exactness:
    """Write box and displacements."""
    fitting, exactness = adapted(content, RULES, adapt)
    rest = fitting.rest
    net = rest.control_points
    origin = net[0, 0, 0]
    edges = np.stack([net[-1, 0, 0], net[0, -1, 0], net[0, 0, -1]]) - origin
    length = np.linalg.norm(edges, axis=1)
    angles = _angles((edges / length[:, None]).T)
    ideal, span = _box(rest.shape, length, origin, angles)
    if np.abs(ideal - net).max() > 1e-12 * rest.diagonal:
        raise InputError(
            "PyGeM .prm cannot express this lattice: at rest it must be a right-angled box with "
            "equally spaced control points; write .lattice.json"
        )
    moves = (fitting.current.control_points - net) @ np.linalg.inv(span)
    write_bytes(path, _text(rest.shape, length, origin, angles, moves).encode())
    return exactness


def _box(
    shape: tuple[int, ...], length: Array, origin: Array, angles: Array
) -> tuple[Array, Array]:
    """Control points of the box at rest, and its three edges as rows."""
    span = (_rotation(angles) * length).T
    lines = [np.linspace(0, 1, n) for n in shape]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    return origin + grid @ span, span


def _rotation(angles: Array) -> Array:
    (a, b, c), (sa, sb, sc) = np.cos(np.radians(angles)), np.sin(np.radians(angles))
    rx = np.array([[1, 0, 0], [0, a, -sa], [0, sa, a]])
    ry = np.array([[b, 0, sb], [0, 1, 0], [-sb, 0, b]])
    rz = np.array([[c, -sc, 0], [sc, c, 0], [0, 0, 1]])
    return np.asarray(rx @ ry @ rz)


def _angles(rotation: Array) -> Array:
    """Angles of R = Rx Ry Rz in degrees."""
    x = np.arctan2(-rotation[1, 2], rotation[2, 2])
    y = np.arctan2(rotation[0, 2], np.hypot(rotation[0, 0], rotation[0, 1]))
    z = np.arctan2(-rotation[0, 1], rotation[0, 0])
    return np.degrees([x, y, z])


def _moves(text: str, counts: list[int], name: str) -> Array:
    moves = np.zeros(counts)
    for line in text.splitlines():
        words = line.split("#")[0].encode().split()
        if not words:
            continue
        index = tuple(integer(word, name, "an index") for word in words[:3])
        if len(words) != 4 or not all(0 <= i < n for i, n in zip(index, counts, strict=True)):
            raise InputError(f"{name}: no displacement of this box: {line.strip()[:60]!r}")
        moves[index] = vector(words[3:], name)[0]
    return moves


def _text(shape: tuple[int, ...], length: Array, origin: Array, angles: Array, moves: Array) -> str:
    lines = ["[Box info]"]
    for key, values in (
        ("n control points", list(shape)),
        ("box length", length.tolist()),
        ("box origin", origin.tolist()),
        ("rotation angle", angles.tolist()),
    ):
        lines += [f"{key} {a}: {value!r}" for a, value in zip("xyz", values, strict=True)]
    lines += ["", "[Parameters weights]"]
    for number, a in enumerate("xyz"):
        rows = [f"{i} {j} {k} {moves[i, j, k, number].item()!r}" for i, j, k in np.ndindex(shape)]
        lines.append(f"parameter {a}: " + "\n    ".join(rows))
    return "\n".join([*lines, ""])
