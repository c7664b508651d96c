"""Readers of last resort in a process of their own: limits, cancel, and no process left behind."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import meshio
import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.__main__ import READER
from ffdstudio.meshes.confined import asking, wire
from ffdstudio.meshes.formats import via_meshio

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
MESH = meshio.Mesh(POINTS, {"tetra": [[0, 1, 2, 3]], "triangle": [[0, 1, 2], [0, 1, 3]]})


def children() -> list[int]:
    """Numbers of this process's children that live."""
    found = []
    for task in Path("/proc/self/task").iterdir():
        found += [int(word) for word in (task / "children").read_text().split()]
    return found


@pytest.fixture
def nobody_left():
    before = set(children())
    yield
    assert set(children()) == before


def looping(folder: Path) -> Path:
    """A file whose reading by meshio 5 does not end: a section that is never closed."""
    path = folder / "a.tec"
    path.write_text(
        'TITLE = "x"\nVARIABLES = "X", "Y", "Z"\nZONE NODES=4, ELEMENTS=1,\n'
        "DATAPACKING=POINT ZONETYPE=FETETRAHEDRON\n0 0 0\n1 0 0\n"
    )
    return path


def test_a_mesh_comes_back_with_its_cells(tmp_path, nobody_left):
    path = tmp_path / "a.xdmf"
    MESH.write(path)
    mesh = read_mesh(path)
    assert np.array_equal(mesh.points, POINTS)
    assert mesh.counts == {"tetra": 1, "triangle": 2}


def test_sets_become_markers(tmp_path):
    made = meshio.Mesh(POINTS, MESH.cells, cell_sets={"wall": [np.array([], int), np.array([1])]})
    blocks, sets, arrays = [], {}, []
    from ffdstudio.meshes.confined.child import described

    said, arrays = wire.unpacked(described(made))
    blocks = [(kind, arrays[k]) for kind, k in said["blocks"]]
    sets = via_meshio._sets(said["sets"], blocks, arrays)
    assert {kind: rows.tolist() for kind, rows in sets["wall"].items()} == {"triangle": [[0, 1, 3]]}


def test_new_files_are_made(tmp_path, nobody_left):
    MESH.write(tmp_path / "a.xdmf")
    write_mesh(read_mesh(tmp_path / "a.xdmf"), tmp_path / "a.vtu")
    assert np.array_equal(meshio.read(tmp_path / "a.vtu").points, POINTS)


def sleeping(monkeypatch, what="import time; time.sleep(1000)"):
    """Let the process do something else than read."""
    code = f"import sys; sys.stdout.write('ready\\n'); sys.stdout.flush(); {what}"
    monkeypatch.setattr(asking, "command", lambda: [sys.executable, "-c", code])


@pytest.mark.parametrize("what", ["import time; time.sleep(1000)", "\nwhile True: pass"])
def test_one_that_hangs_is_ended(tmp_path, monkeypatch, nobody_left, what):
    sleeping(monkeypatch, what)
    monkeypatch.setattr(asking, "SECONDS", 0.1)
    (tmp_path / "a.wkt").write_text("TIN (((0 0 0, 1 0 0, 0 1 0, 0 0 0)))")
    with pytest.raises(InputError, match=r"a\.wkt: reading this file takes more than"):
        read_mesh(tmp_path / "a.wkt")


def test_a_loop_in_a_reader_ends_at_the_limit_of_processor_time(tmp_path, nobody_left):
    text = (
        "TIN (" + "(" * 3000 + "0 0 0" * 2000
    )  # the pattern of meshio's reader goes back and forth
    (tmp_path / "a.wkt").write_text(text)
    began = time.process_time()
    with pytest.raises(InputError) as error:
        read_mesh(tmp_path / "a.wkt")
    assert len(str(error.value).splitlines()) == 1
    assert (
        time.process_time() - began < 5.0
    )  # what was spent here; the process has a limit of its own


class Cancelled(Exception):
    pass


def test_reading_is_cancelled_by_progress(tmp_path, monkeypatch, nobody_left):
    sleeping(monkeypatch)
    (tmp_path / "a.wkt").write_text("TIN")
    calls = []

    def progress(fraction):
        calls.append(fraction)
        if len(calls) > 3:
            raise Cancelled

    with pytest.raises(Cancelled):
        read_mesh(tmp_path / "a.wkt", progress)


def test_it_works_in_a_worker_thread_and_leaves_standard_output_alone(tmp_path, nobody_left):
    MESH.write(tmp_path / "a.xdmf")
    found, streams = [], (sys.stdout, sys.stderr)
    thread = threading.Thread(target=lambda: found.append(read_mesh(tmp_path / "a.xdmf")))
    thread.start()
    while thread.is_alive():
        assert (sys.stdout, sys.stderr) == streams
        time.sleep(0.001)
    assert len(found[0].points) == 4


def test_memory_has_a_limit(tmp_path, nobody_left):
    """A file of a few bytes that announces 400 million numbers."""
    path = tmp_path / "a.tec"
    path.write_text(
        'VARIABLES = "X", "Y", "Z"\nZONE N=400000000, E=1, F=FEPOINT, ET=TETRAHEDRON\n0 0 0\n'
    )
    with pytest.raises(InputError, match=r"a\.tec: ") as error:
        read_mesh(path)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("victim", ["../../../../../../../../etc/passwd", "../secret.txt"])
def test_a_file_that_refers_elsewhere_is_refused(tmp_path, victim):
    folder = tmp_path / "in"
    folder.mkdir()
    (tmp_path / "secret.txt").write_bytes(POINTS.tobytes())
    path = folder / "a.xdmf"
    MESH.write(path, data_format="Binary")
    text = path.read_text()
    name = next(p.name for p in folder.glob("*.bin"))
    path.write_text(text.replace(name, victim))
    with pytest.raises(InputError, match="outside its folder"):
        read_mesh(path)


@pytest.mark.parametrize("layout", ["external", "virtual", "link", "elsewhere"])
def test_hdf5_of_an_xdmf_stays_in_its_folder_and_its_file(tmp_path, layout):
    import h5py

    folder = tmp_path / "in"
    folder.mkdir()
    path = folder / "a.xdmf"
    MESH.write(path, data_format="HDF")
    assert len(read_mesh(path).points) == 4
    victim = tmp_path / "victim.bin"
    victim.write_bytes(bytes(1000))
    if layout == "elsewhere":
        (folder / "a.h5").rename(tmp_path / "a.h5")
        path.write_text(path.read_text().replace("a.h5:", "../a.h5:"))
    else:
        with h5py.File(folder / "a.h5", "r+") as file:
            shape = file["data0"].shape
            del file["data0"]
            if layout == "external":
                file.create_dataset("data0", shape, "f8", external=[(str(victim), 0, 96)])
            elif layout == "virtual":
                whole = h5py.VirtualLayout(shape, "f8")
                whole[...] = h5py.VirtualSource(str(victim), "x", shape)
                file.create_virtual_dataset("data0", whole)
            else:
                file["data0"] = h5py.ExternalLink(str(victim), "x")
    with pytest.raises(InputError, match=r"another file|outside its folder"):
        read_mesh(path)


PARENT = """
import sys, threading
from pathlib import Path
from ffdstudio.meshes.confined import asking
code = "import sys; sys.stdout.write('ready\\\\n'); sys.stdout.flush(); {loop}"
asking.command = lambda: [sys.executable, "-c", code]
from ffdstudio import read_mesh
def tell(fraction):
    print("waiting", flush=True)
{call}
"""


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGSEGV])
@pytest.mark.parametrize("thread", [False, True])
def test_it_ends_with_its_parent(tmp_path, end, thread):
    """Ours, that listens to its pipe; the child's own loop is `child.main` waiting for us."""
    path = tmp_path / "a.wkt"
    path.write_text("TIN")
    call = f"read_mesh({os.fspath(path)!r}, tell)"
    if thread:
        call = f"t = threading.Thread(target=lambda: {call})\nt.start()\nt.join()"
    marker = f"mark{os.getpid()}x{int(end)}x{int(thread)}"
    loop = (
        f"from ffdstudio.meshes.confined import child; {marker} = 1; "
        "child._end_with_parent_of_linux(); import time; time.sleep(1000)"
    )
    done = subprocess.Popen(
        [sys.executable, "-c", PARENT.format(loop=loop, call=call)],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    assert done.stdout.readline() == "waiting\n"
    deadline = time.monotonic() + 60
    while not living(marker, done.pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert living(marker, done.pid)
    time.sleep(0.5)
    done.send_signal(end)
    done.wait(30)
    while living(marker, done.pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not living(marker, done.pid)


def living(marker: str, but: int) -> list[int]:
    """Processes with a word in their command line, except the one that has it in its script."""
    found = []
    for place in Path("/proc").iterdir():
        if place.name.isdigit() and int(place.name) != but:
            try:
                words = (place / "cmdline").read_bytes()
            except OSError:
                continue
            if marker.encode() in words and b"read_mesh" not in words:
                found.append(int(place.name))
    return found


def test_the_pipe_alone_ends_it_where_the_kernel_does_not(tmp_path):
    """On systems without Linux's death signal: the real child, whose other end goes away."""
    process = subprocess.Popen(asking.command(), stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout.readline() == asking.READY
    process.stdin.close()
    assert process.wait(30) is not None


def test_no_module_beside_the_mesh_is_imported(tmp_path, monkeypatch):
    for name in ("numpy", "meshio", "h5py", "json"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit(3)")
    MESH.write(tmp_path / "a.xdmf")
    monkeypatch.chdir(tmp_path)
    assert len(read_mesh("a.xdmf").points) == 4


def test_a_frozen_program_starts_itself(tmp_path, monkeypatch, nobody_left):
    starter = tmp_path / "frozen"
    home = Path(asking.__file__).parents[3]
    starter.write_text(
        f"#!{sys.executable}\nimport sys\nsys.path.insert(0, {os.fspath(home)!r})\n"
        "from ffdstudio.__main__ import main\nsys.exit(main())\n"
    )
    starter.chmod(0o755)
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    monkeypatch.setattr(sys, "executable", os.fspath(starter))
    assert asking.command() == [os.fspath(starter), READER] == [os.fspath(starter), asking.WORD]
    MESH.write(tmp_path / "a.xdmf")
    found = []
    thread = threading.Thread(target=lambda: found.append(read_mesh(tmp_path / "a.xdmf")))
    thread.start()
    thread.join()
    assert len(found[0].points) == 4


@pytest.mark.parametrize(
    "answer",
    [
        b"",
        b"nonsense",
        wire.MARK,
        wire.packed({})[:-1],
        wire.packed({"blocks": 1}),
        wire.packed({}, [POINTS]),
    ],
)
def test_an_answer_that_is_none_is_one_sentence(tmp_path, monkeypatch, nobody_left, answer):
    sleeping(monkeypatch, f"sys.stdout.buffer.write({answer!r})")
    (tmp_path / "a.wkt").write_text("TIN")
    with pytest.raises(InputError, match=r"a\.wkt: "):
        read_mesh(tmp_path / "a.wkt")
