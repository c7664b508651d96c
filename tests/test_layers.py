"""The rooms stand on each other as the design says, and a light start stays light."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOMS = ("engine", "meshes", "exchange", "optimize", "project", "cli")
QT = ("PySide6", "shiboken6", "pyvistaqt", "pyqtgraph", "qtawesome", "qtpy")
HEAVY = ("PySide6", "vtk", "vtkmodules", "pyvista", "numba", "meshio", "matplotlib")


def run_python(code, root, blocked=()):
    environment = os.environ | {
        "PYTHONPATH": str(root / "tests" / "blocked"),
        "BLOCKED_MODULES": ",".join(blocked),
    }
    return subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )


def test_import_contracts_are_kept(root):
    command = shutil.which("lint-imports", path=Path(sys.executable).parent)
    done = subprocess.run([command, "--no-cache"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("room", ROOMS)
def test_each_room_below_the_window_imports_without_qt_and_vtk(root, room):
    done = run_python(
        f"import ffdstudio.{room}", root, blocked=(*QT, "vtk", "vtkmodules", "pyvista")
    )
    assert done.returncode == 0, done.stderr


def test_blocked_packages_are_really_absent(root):
    done = run_python("import PySide6.QtCore", root, blocked=QT)
    assert "ModuleNotFoundError: No module named 'PySide6'" in done.stderr


def loaded_by(code, root):
    done = run_python(f"import sys\n{code}\nprint(*sys.modules)", root)
    assert done.returncode == 0, done.stderr
    return {name.partition(".")[0] for name in done.stdout.split()}


def test_importing_the_package_loads_nothing_heavy(root):
    assert not loaded_by("import ffdstudio", root) & {*HEAVY, "scipy", "numpy"}


@pytest.mark.parametrize("room", ROOMS)
def test_importing_a_room_loads_nothing_heavy(root, room):
    assert not loaded_by(f"import ffdstudio.{room}", root) & set(HEAVY)


def test_every_public_name_is_there():
    import ffdstudio

    missing = [name for name in ffdstudio.__all__ if not hasattr(ffdstudio, name)]
    assert not missing
    assert set(ffdstudio.__all__) <= set(dir(ffdstudio))
