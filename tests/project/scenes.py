"""Meshes, cameras and documents that the tests of this room work on."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.project.commands import CreateBox
from ffdstudio.project.document import Document
from ffdstudio.project.view.camera import Camera


def write_cube(path: Path, n: int = 3, low: str = "low") -> Path:
    """SU2 file of a unit cube of n^3 hexahedra with markers at x = 0 (`low`) and x = 1."""
    count = n + 1
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, count)] * 3, indexing="ij"), -1)
    number = np.arange(count**3).reshape(count, count, count)
    lines = ["NDIME= 3", f"NELEM= {n**3}"]
    for i, j, k in np.ndindex(n, n, n):
        base = number[i : i + 2, j : j + 2, k : k + 2]
        square = [(0, 0), (1, 0), (1, 1), (0, 1)]
        nodes = [base[a, b, c] for c in (0, 1) for a, b in square]
        lines.append("12 " + " ".join(map(str, nodes)))
    lines.append(f"NPOIN= {count**3}")
    lines += [" ".join(f"{x:.17g}" for x in point) for point in grid.reshape(-1, 3)]
    lines.append("NMARK= 2")
    for name, layer in ((low, number[0]), ("high", number[-1])):
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {n**2}"]
        for j, k in np.ndindex(n, n):
            quad = layer[j, k], layer[j + 1, k], layer[j + 1, k + 1], layer[j, k + 1]
            lines.append("9 " + " ".join(map(str, quad)))
    path.write_text("\n".join(lines) + "\n")
    return path


def write_square(path: Path, n: int = 4) -> Path:
    """SU2 file of a plane unit square of quadrilaterals with one marker."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1)] * 2, indexing="ij"), -1)
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    lines = ["NDIME= 2", f"NELEM= {n**2}"]
    for i, j in np.ndindex(n, n):
        quad = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
        lines.append("9 " + " ".join(map(str, quad)))
    lines.append(f"NPOIN= {(n + 1) ** 2}")
    lines += [" ".join(f"{x:.17g}" for x in point) for point in grid.reshape(-1, 2)]
    lines += ["NMARK= 1", "MARKER_TAG= edge", f"MARKER_ELEMS= {n}"]
    lines += [f"3 {number[0, j]} {number[0, j + 1]}" for j in range(n)]
    path.write_text("\n".join(lines) + "\n")
    return path


BOX = CreateBox("Box", (-0.1, -0.1, -0.1), (1.1, 1.1, 1.1), (4, 4, 4), (3, 3, 3))


def opened(path: Path, *boxes: CreateBox) -> Document:
    """Document with a mesh and box lattices, whose problems are errors."""
    document = Document()
    document.problem.connect(_raise)
    document.open_mesh(path)
    for box in boxes:
        document.do(box)
    return document


def _raise(title: str, cause: str) -> None:
    raise AssertionError(f"{title}: {cause}")


def look(
    eye: tuple[float, float, float] = (4.0, 3.0, 5.0),
    at: tuple[float, float, float] = (0.5, 0.5, 0.5),
    parallel: bool = False,
    size: tuple[float, float] = (800.0, 600.0),
) -> Camera:
    """Camera of 30 degrees, or a parallel one of about the same scale (OpenGL's matrices)."""
    back = np.subtract(eye, at)
    distance, aspect, tangent = np.linalg.norm(back), size[0] / size[1], np.tan(np.radians(15))
    back = back / distance
    up = np.array([0, 0, 1.0]) if abs(back[2]) < 0.99 else np.array([0, 1.0, 0])
    right = np.cross(up, back) / np.linalg.norm(np.cross(up, back))
    view = np.eye(4)
    view[:3, :3] = [right, np.cross(back, right), back]
    view[:3, 3] = -view[:3, :3] @ eye
    near, far = 0.05 * distance, 20 * distance
    if parallel:
        half = distance * tangent
        lens = np.diag([1 / (half * aspect), 1 / half, -2 / (far - near), 1])
        lens[2, 3] = -(far + near) / (far - near)
    else:
        lens = np.diag([1 / (tangent * aspect), 1 / tangent, -(far + near) / (far - near), 0])
        lens[2, 3], lens[3, 2] = -2 * far * near / (far - near), -1
    return Camera(lens @ view, *size)
