"""The parts of a frame while a point is dragged, in a real window.

    xvfb-run -a -s "-screen 0 1600x1200x24" python benchmarks/bench_frame.py

1. A surface of a million points: what a mouse move costs, the deformation, writing into the
   displayed arrays, the request of the repaint, and the picture itself (here by software).
   The full deformation, which a proxy stands in for, is shown beside it.
2. The same skin alone and with a volume of a million nodes under it, by turns: the ratio of
   their frames is 1 if nothing in a frame grows with the volume.
3. How many pictures 50 queued mouse moves cost.

Times are minima over interleaved frames; only ratios mean anything on a shared machine.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtWidgets import QApplication

from ffdstudio.gui.settings import Settings
from ffdstudio.gui.window import MainWindow
from ffdstudio.meshes import Mesh
from ffdstudio.project import commands as c

FRAMES = 30
POINT = (4, 3, 2)


def sphere(n: int) -> Mesh:
    """Triangulated unit sphere of 2 n^2 points."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 2 * n), np.linspace(0.01, np.pi - 0.01, n))
    points = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], -1)
    number = np.arange(2 * n * n).reshape(n, 2 * n)
    low, high = number[:-1], number[1:]
    corners = [block.ravel() for block in (low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1])]
    cells = np.concatenate(
        [np.stack([corners[k] for k in (0, *pair)], -1) for pair in ((1, 2), (2, 3))]
    )
    return Mesh(points.reshape(-1, 3), {"triangle": cells})


def block(n: int) -> Mesh:
    """Cube of n^3 nodes in hexahedra."""
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij"), -1)
    number = np.arange(n**3).reshape(n, n, n)
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    ends = slice(None, -1), slice(1, None)
    cells = [number[ends[i], ends[j], ends[k]].ravel() for k in (0, 1) for i, j in square]
    return Mesh(grid.reshape(-1, 3), {"hexahedron": np.stack(cells, -1)})


def skin(mesh: Mesh) -> Mesh:
    """The surface of a volume mesh as a mesh of its own."""
    faces = mesh.surface()["quad"]
    nodes, rows = np.unique(faces, return_inverse=True)
    return Mesh(mesh.points[nodes], {"quad": rows.reshape(faces.shape)})


class Bench:
    """A window with a mesh, a lattice and a drag under way."""

    def __init__(self, folder: Path, mesh: Mesh) -> None:
        self.window = MainWindow(Settings(folder / "settings.ini"), None, folder / "recovery")
        self.window.resize(1280, 800)
        self.window.show()
        document = self.document = self.window.document
        document.do(c.OpenMesh(str(folder / "mesh"), mesh=mesh))
        document.do(c.CreateBox("Box", (-1.1,) * 3, (1.1,) * 3, (8, 6, 4), (3, 3, 3)))
        self.settle(lambda: not self.window.jobs.running)
        self.edit = document.edit([POINT])
        self.step = 0
        self.times: dict[str, float] = {}
        for _ in range(3):
            self.frame()
        self.times.clear()

    def settle(self, condition: Callable[[], bool]) -> None:
        """Let the window work until something is so."""
        while not condition():
            QApplication.processEvents()
            time.sleep(0.002)

    def frame(self) -> float:
        """One frame by its parts; returns the time of all but the picture."""
        self.step += 1
        vector = [0.2 * np.sin(self.step), 0.0, 0.1]
        view, scene, before = self.window.viewport, self.window.scene, self.window.viewport.frames
        parts = {
            "mouse move": lambda: self.edit.translate(vector),
            "deform": self.document.refresh,
            "write displayed arrays": scene._follow,
            "request of the repaint": view.update,
        }
        spent = [self._time(name, part) for name, part in parts.items()]
        self._time("picture (software)", lambda: self.settle(lambda: view.frames > before))
        return sum(spent)

    def _time(self, name: str, part: Callable[[], object]) -> float:
        start = time.perf_counter()
        part()
        spent = time.perf_counter() - start
        self.times[name] = min(spent, self.times.get(name, np.inf))
        return spent

    def close(self) -> None:
        """Close the window without a question."""
        self.edit.abort()
        self.window.files.may_discard = lambda: True  # type: ignore[method-assign]
        self.window.close()


def million(folder: Path) -> bool:
    """Print the parts of a frame for a surface of a million points."""
    mesh = sphere(710)
    bench = Bench(folder, mesh)
    shown = bench.document.surface("body1")
    for _ in range(FRAMES):
        bench.frame()
    print(f"surface of {len(shown.nodes):,} points, proxy of {len(shown.proxy.rows):,}")  # type: ignore[union-attr]
    for name, spent in bench.times.items():
        print(f"  {name:24} {1e3 * spent:9.3f} ms")
    full = bench.document._displays["body1"].full
    hold, flat = full.hold("lattice2"), [100]
    assert hold is not None
    hold.pull(flat, [0.1, 0, 0])
    for _ in range(FRAMES):
        bench._time("(full drag, not done)", lambda: hold.pull(flat, [0.1, 0.2, 0]))
    print(f"  {'(all points instead)':24} {1e3 * bench.times['(full drag, not done)']:9.3f} ms")
    events = fifty(bench)
    print(f"  50 queued moves: {events} pictures")
    bench.close()
    return events <= 5


def fifty(bench: Bench) -> int:
    """Pictures that 50 moves cost between two turns of the event loop."""
    view = bench.window.viewport
    bench.settle(lambda: True)
    before = view.frames
    for k in range(50):
        bench.edit.translate([0.001 * k, 0, 0])
    bench.settle(lambda: view.frames > before)
    for _ in range(50):
        QApplication.processEvents()
    return view.frames - before


def with_and_without_volume(folder: Path) -> bool:
    """Print the frame of a skin alone and of the same skin with a million nodes inside."""
    volume = block(100)
    benches = {"skin alone": Bench(folder, skin(volume)), "with volume": Bench(folder, volume)}
    best = dict.fromkeys(benches, np.inf)
    for _ in range(FRAMES):
        for name, bench in benches.items():
            best[name] = min(best[name], bench.frame())
    ratio = best["with volume"] / best["skin alone"]
    print(f"skin of {len(skin(volume).points):,} points; volume of {len(volume.points):,} nodes")
    for name, spent in best.items():
        print(f"  {name:24} {1e3 * spent:9.3f} ms a frame without the picture")
    print(f"  ratio {ratio:.2f}")
    for bench in benches.values():
        bench.close()
    return ratio < 1.5


if __name__ == "__main__":
    app = QApplication(sys.argv[:1])
    with tempfile.TemporaryDirectory() as name:
        good = [million(Path(name)), with_and_without_volume(Path(name))]
    print("targets met" if all(good) else "a target was missed")
    sys.exit(0 if all(good) else 1)
