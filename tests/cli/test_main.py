"""How commands are found, and how they end."""

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ffdstudio import __version__
from ffdstudio.__main__ import main as program
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
    allowed = ["__main__", "cli", "cli.main", "errors", "version"]
    assert out.stdout.splitlines()[1] == repr([f"ffdstudio.{name}" for name in allowed])


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


def run(*words, **options):
    return subprocess.run([*RUN, *words], capture_output=True, text=True, **options)


@pytest.mark.parametrize("name", ["a" * 300 + ".su2", "file/below.su2"])
def test_paths_that_cannot_be_looked_at_are_no_tracebacks(tmp_path, monkeypatch, name):
    (tmp_path / "file").touch()
    done = run(name, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])})
    assert done.returncode == 2
    assert one_line(done.stderr)
    assert name in done.stderr


@pytest.mark.parametrize("words", [["x.su2"], ["info", "x.su2"]])
def test_a_folder_that_may_not_be_searched_is_named(ffdstudio, monkeypatch, capsys, words):
    def refuse(path, **_):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(Path, "stat", refuse)
    monkeypatch.setattr(sys, "argv", ["ffdstudio", *words])
    assert program() == 2
    err = capsys.readouterr().err
    assert one_line(err)
    assert "x.su2" in err


def test_errors_of_the_system_name_the_file(ffdstudio, monkeypatch):
    def fail(args):
        raise PermissionError(errno.EACCES, "Permission denied", "lock/a.su2")

    monkeypatch.setattr(info, "run", fail)
    assert ffdstudio("info", "x") == 2
    assert ffdstudio.err == "ffdstudio: error: lock/a.su2: permission denied\n"


@pytest.mark.skipif(os.name != "posix", reason="closes a stream by the shell")
@pytest.mark.parametrize("words", [[], ["--json"]])
@pytest.mark.parametrize("stream", [1, 2])
def test_closed_streams_are_no_fault(square, words, stream):
    command = ["sh", "-c", f'exec "$@" {stream}>&-', "sh", *RUN]
    done = subprocess.run([*command, "info", square, *words], capture_output=True, text=True)
    assert done.returncode == 0
    assert done.stderr == ""
    done = subprocess.run([*command, "info", "nofile"], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stdout == ""


@pytest.mark.parametrize("words", [[], ["--json"]])
def test_a_name_that_the_encoding_cannot_say_is_escaped(square, tmp_path, words):
    out = tmp_path / "fl\N{LATIN SMALL LETTER U WITH DIAERESIS}gel.lattice.json"
    env = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = run("lattice", square, "--shape", "3", "3", "-o", out, *words, env=env)
    assert (done.returncode, done.stderr) == (0, "")
    assert out.exists()
    if words:
        assert json.loads(done.stdout)["lattice"] == str(out)
    else:
        assert r"fl\xfcgel" in done.stdout
