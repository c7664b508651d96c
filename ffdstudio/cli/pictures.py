"""Pictures of a plane mesh and its lattice, rendered off-screen.

VTK chooses a way to render without a display (EGL or OSMesa) by itself. pyvista is imported
inside the functions: nothing but `demo` needs it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.meshes import Mesh

if TYPE_CHECKING:
    import pyvista

SIZE = (1920, 1200)
MESH, WALL, NET, MOVED, TEXT = "#7f8e9c", "#14202b", "#e67e00", "#c8102e", "#14202b"
Window = tuple[float, float, float, float]


def draw(
    path: Path,
    mesh: Mesh,
    points: Array,
    window: Window,
    title: str,
    lattice: Lattice | None = None,
    rest: Lattice | None = None,
) -> None:
    """Draw a 2D mesh at `points`, cut to a window, with a lattice on top.

    Parameters
    ----------
    path : pathlib.Path
        The PNG file.
    mesh : Mesh
    points : numpy.ndarray
        (n, 3) its nodes.
    window : tuple
        Lowest and highest x, lowest and highest y that must be seen.
    title : str
        One line above the picture.
    lattice, rest : Lattice, optional
        Net to draw; control points that differ from `rest` get their way drawn.
    """
    import pyvista as pv
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)  # "no X server" is no news here
    plotter = pv.Plotter(off_screen=True, window_size=list(SIZE))
    plotter.set_background("white")  # type: ignore[arg-type]
    _draw_mesh(plotter, mesh, points)
    if lattice is not None:
        _draw_net(plotter, lattice, rest)
    text = plotter.add_text(title, position=(40, SIZE[1] - 75), font_size=20, color=TEXT)
    text.prop.background_color, text.prop.background_opacity = "white", 0.85
    _look_at(plotter, window)
    plotter.enable_anti_aliasing("ssaa")
    try:
        plotter.screenshot(str(path))
    finally:
        plotter.close()


def _draw_mesh(plotter: pyvista.Plotter, mesh: Mesh, points: Array) -> None:
    edges = _edges(mesh)
    plotter.add_mesh(_lines(points, edges), color=MESH, line_width=1.6)
    for name, cells in mesh.markers.items():
        if "line" in cells:
            wide = 5.0 if name.lower() != "farfield" else 2.5
            plotter.add_mesh(_lines(points, cells["line"]), color=WALL, line_width=wide)


def _edges(mesh: Mesh) -> np.ndarray:
    """(m, 2) edges of all plane cells, each once."""
    loops = [nodes for nodes in mesh.surface().values() if nodes.shape[1] > 2]
    pairs = [np.stack([loop, np.roll(loop, -1, axis=1)], axis=-1).reshape(-1, 2) for loop in loops]
    return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)


def _draw_net(plotter: pyvista.Plotter, lattice: Lattice, rest: Lattice | None) -> None:
    import pyvista as pv

    front = np.array([0.0, 0.0, 1e-3 * lattice.diagonal])  # above the mesh
    net = lattice.control_points.reshape(-1, 3) + front
    index = np.arange(len(net)).reshape(lattice.shape)
    pairs = [
        np.stack([np.delete(index, -1, k).ravel(), np.delete(index, 0, k).ravel()], axis=1)
        for k in range(lattice.dimension)
    ]
    plotter.add_mesh(_lines(net, np.concatenate(pairs)), color=NET, line_width=4)
    moved = np.zeros(len(net), dtype=bool)
    if rest is not None:
        home = rest.control_points.reshape(-1, 3) + front
        moved = (net != home).any(axis=1)
        _draw_ways(plotter, home[moved], net[moved])
    style: dict[str, Any] = {"render_points_as_spheres": True, "lighting": False}
    plotter.add_mesh(pv.PolyData(net[~moved] + front), color=NET, point_size=24, **style)
    if moved.any():
        plotter.add_mesh(pv.PolyData(net[moved] + front), color=MOVED, point_size=36, **style)


def _draw_ways(plotter: pyvista.Plotter, home: Array, away: Array) -> None:
    """Where moved control points come from."""
    import pyvista as pv

    if len(home) == 0:
        return
    n = len(home)
    pairs = np.stack([np.arange(n), np.arange(n) + n], axis=1)
    plotter.add_mesh(_lines(np.concatenate([home, away]), pairs), color=MOVED, line_width=5)
    style: dict[str, Any] = {"render_points_as_spheres": True, "lighting": False}
    plotter.add_mesh(pv.PolyData(home), color="#eeb0ba", point_size=24, **style)


def _lines(points: Array, pairs: np.ndarray) -> Any:
    import pyvista as pv

    used, local = np.unique(pairs, return_inverse=True)
    cells = np.column_stack([np.full(len(pairs), 2), local.reshape(-1, 2)])
    return pv.PolyData(points[used], lines=cells.ravel())


def _look_at(plotter: pyvista.Plotter, window: Window) -> None:
    x0, x1, y0, y1 = window
    middle = (0.5 * (x0 + x1), 0.5 * (y0 + y1))
    plotter.camera_position = [(*middle, 10 * (x1 - x0)), (*middle, 0.0), (0, 1, 0)]
    plotter.camera.parallel_projection = True
    aspect = SIZE[0] / SIZE[1]
    plotter.camera.parallel_scale = 0.5 * max(y1 - y0, (x1 - x0) / aspect)
    plotter.reset_camera_clipping_range()
