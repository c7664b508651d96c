"""How commands are found, and how they end."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ffdstudio import __version__
from ffdstudio.__main__ import wants_window
from ffdstudio.cli import info, main

RUN = [sys.executable, "-m", "ffdstudio"]


def one_line(err):
    return err.startswith("ffdstudio: error: ") and err.count("\n") == 1


def test_version_and_help(ffdstudio):
    assert ffdstudio("--version") == 0
    assert ffdstudio.out == f"ffdstudio {__version__}\n"
    assert ffdstudio("--help") == 0
    for command in main.COMMANDS:
        assert f"  {command} " in ffdstudio.out


def test_version_imports_no_command():
    code = "import sys; sys.argv = ['x', '--version']; import ffdstudio.__main__ as m\n"
    code += "try: m.main()\nexcept SystemExit: pass\n"
    code += (
        "print(sorted(n for n in sys.modules if n in ('numpy', 'scipy', 'numba', 'meshio', 'vtk')"
    )
    code += " or n.startswith('ffdstudio.')))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    allowed = ["ffdstudio.__main__", "ffdstudio.cli", "ffdstudio.cli.main", "ffdstudio.errors"]
    assert out.stdout.splitlines()[1] == repr(allowed)


@pytest.mark.parametrize(
    "words",
    [
        ["moprh"],
        ["info"],
        ["info", "a", "b"],
        ["info", "--jsn", "a"],
        ["lattice", "a.su2", "--shape", "x", "-o", "b"],
        ["lattice", "a.su2", "--margin", "nan", "-o", "b"],
        ["lattice", "a.su2", "--axes", "xx", "-o", "b"],
        ["morph", "a.su2", "b.lattice.json"],
        ["morph", "a.su2", "-o", "b"],
        ["convert", "a.xyz", "b.xyz", "--adapt", "maybe"],
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(ffdstudio, words):
    assert ffdstudio(*words) == 2
    assert ffdstudio.out == ""
    assert one_line(ffdstudio.err)


def test_interrupt_is_130(ffdstudio, monkeypatch):
    def interrupt(args):
        raise KeyboardInterrupt

    monkeypatch.setattr(info, "run", interrupt)
    assert ffdstudio("info", "x") == 130


@pytest.mark.parametrize(
    "fault", [RuntimeError("two\nlines"), MemoryError(), OSError(errno.ENOSPC, "No space left")]
)
def test_no_fault_reaches_the_user_as_a_traceback(ffdstudio, monkeypatch, fault):
    def fail(args):
        raise fault

    monkeypatch.setattr(info, "run", fail)
    monkeypatch.delenv("FFDSTUDIO_DEBUG", raising=False)
    assert ffdstudio("info", "x") == 2
    assert one_line(ffdstudio.err)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_under_stdout_is_an_error(square):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*RUN, "info", square], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == 2
    assert one_line(done.stderr)


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX pipes")
def test_a_reader_that_left_is_no_error(square):
    end, begin = os.pipe()
    os.close(end)
    done = subprocess.run([*RUN, "info", square], stdout=begin, stderr=subprocess.PIPE, text=True)
    os.close(begin)
    assert done.stderr == ""


def test_files_open_the_window_and_words_do_not(square, tmp_path):
    assert wants_window([])
    assert wants_window([str(square)])
    assert wants_window([str(tmp_path)])
    assert wants_window(["typo.su2"])
    assert not wants_window(["moprh"])
    assert not wants_window(["info", str(square)])
    assert not wants_window(["--version"])


def without(*names):
    return {k: v for k, v in os.environ.items() if k not in names}


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems have a display")
def test_without_a_display_the_window_says_so(square):
    env = without("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    for words in ([], [str(square)]):
        done = subprocess.run([*RUN, *words], capture_output=True, text=True, env=env)
        assert done.returncode == 2
        assert one_line(done.stderr)
        assert "display" in done.stderr or "gui extra" in done.stderr


def test_without_the_gui_extra_the_window_says_so(square, root):
    env = {**os.environ, "PYTHONPATH": str(root / "tests" / "blocked"), "DISPLAY": ":0"}
    env["BLOCKED_MODULES"] = "PySide6"
    done = subprocess.run([*RUN, str(square)], capture_output=True, text=True, env=env)
    assert done.returncode == 2
    assert one_line(done.stderr)
    assert "pip install 'ffdstudio[gui]'" in done.stderr
