"""The n-th allocation fails, for many n: the work ends in an error or is done, files stay whole."""

import subprocess
import sys

import pytest

pytest.importorskip("_testcapi", reason="this Python is built without its test module")

SCRIPT = """
import sys
from pathlib import Path
from _testcapi import remove_mem_hooks, set_nomemory
from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes, write_together
from ffdstudio.exchange import read_lattice_file, write_lattice
from ffdstudio.engine import Lattice
from ffdstudio.project.files.journal import read_journal
from ffdstudio.project.files.storage import read_project, write_project
from tests.project.scenes import BOX, opened, write_cube

folder = Path(sys.argv[1])
write_cube(folder / "cube.su2")
document = opened(folder / "cube.su2", BOX)
document.save(folder / "a.ffdproj")
document.journal.save(folder / "a.jsonl")
box = Lattice.box([0, 0, 0], [1, 1, 1], (4, 3, 3))
moved = box.moved(box.control_points + 1)
write_lattice(folder / "a.lattice.json", box)
content = read_project(folder / "a.ffdproj")

ACTIONS = {
    "read project": lambda: read_project(folder / "a.ffdproj"),
    "save project": lambda: write_project(folder / "a.ffdproj", content),
    "read journal": lambda: list(read_journal(folder / "a.jsonl")),
    "read lattice": lambda: read_lattice_file(folder / "a.lattice.json"),
    "write lattice": lambda: write_lattice(folder / "a.lattice.json", box, moved),
    "write together": lambda: write_together([(folder / n, b"new" * 99) for n in "xy"]),
}
for name in "xy":
    write_bytes(folder / name, b"old")
for name, act in ACTIONS.items():
    act()  # what is loaded or made once is there
    whole = {p.name for p in folder.iterdir()}
    ended = {"done": 0, "error": 0}
    for n in range(1, 2500, int(sys.argv[2])):
        outcome = "done"
        set_nomemory(n, n + 1)
        try:
            act()
        except Exception:  # Python and NumPy lose the MemoryError itself now and then
            outcome = "error"
        finally:
            remove_mem_hooks()
        ended[outcome] += 1
        read_project(folder / "a.ffdproj")
        read_lattice_file(folder / "a.lattice.json")
        assert {(folder / n).read_bytes() for n in "xy"} <= {b"old", b"new" * 99}
    print(name, ended, sorted({p.name for p in folder.iterdir()} - whole))
    assert ended["error"] > 0, name
print("all done")
"""


def test_a_failed_allocation_is_no_crash_and_damages_nothing(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path), "13"],
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-3000:]}"
    assert done.stdout.endswith("all done\n")
