"""The script behind `make run` and `make test` says what it does and what it cannot do."""

import importlib.util
import os
import subprocess
import sys

import pytest


@pytest.fixture
def setup(root, monkeypatch):
    spec = importlib.util.spec_from_file_location("ffdstudio_setup", root / ".ci" / "setup.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "interactive", lambda: False)
    return module


@pytest.fixture
def calls(setup, monkeypatch):
    made = []
    monkeypatch.setattr(setup, "run", made.append)
    return made


def with_programs(monkeypatch, setup, *names):
    monkeypatch.setattr(setup.shutil, "which", lambda name: name if name in names else None)


def test_nothing_is_installed_where_everything_loads(setup, calls, monkeypatch):
    monkeypatch.setattr(setup, "can_load", lambda _: True)
    assert setup.missing_packages("gui") == []
    setup.install_system_packages([])
    assert calls == []


def test_what_does_not_load_is_named_and_installed(setup, calls, monkeypatch, capsys):
    monkeypatch.setattr(setup, "can_load", lambda name: name != "libGL.so.1")
    monkeypatch.setattr(setup.os, "geteuid", lambda: 0)
    with_programs(monkeypatch, setup, "apt-get")
    setup.install_system_packages(setup.missing_packages("gui"))
    assert "installed now: libgl1\n" in capsys.readouterr().out
    assert calls[-1][-1] == "libgl1"
    assert "DEBIAN_FRONTEND=noninteractive" in calls[-1]


def test_a_test_run_without_a_display_needs_a_virtual_one(setup, monkeypatch):
    monkeypatch.setattr(setup, "can_load", lambda _: True)
    monkeypatch.setattr(setup.os.path, "exists", lambda _: True)
    with_programs(monkeypatch, setup, "xdotool")
    monkeypatch.delenv("DISPLAY", raising=False)
    assert setup.missing_packages("dev") == ["xvfb", "xauth"]
    assert setup.missing_packages("gui") == []
    monkeypatch.setenv("DISPLAY", ":0")
    assert setup.missing_packages("dev") == []


def test_the_tests_need_a_program_that_moves_the_mouse(setup, monkeypatch):
    monkeypatch.setattr(setup, "can_load", lambda _: True)
    with_programs(monkeypatch, setup, "Xvfb", "xauth")
    assert "xdotool" in setup.missing_packages("dev")
    assert "xdotool" not in setup.missing_packages("gui")


def test_without_root_it_goes_through_sudo(setup, calls, monkeypatch):
    monkeypatch.setattr(setup.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(setup.subprocess, "call", lambda _: 0)
    with_programs(monkeypatch, setup, "apt-get", "sudo")
    setup.install_system_packages(["libgl1"])
    assert all(command[0] == "sudo" for command in calls)


@pytest.mark.parametrize("programs", [["apt-get"], ["apt-get", "sudo"]])
def test_with_neither_root_nor_sudo_it_says_what_to_run(setup, calls, monkeypatch, programs):
    monkeypatch.setattr(setup.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(setup.subprocess, "call", lambda _: 1)
    with_programs(monkeypatch, setup, *programs)
    with pytest.raises(SystemExit, match=r"administrator(.|\n)*apt-get install -y .* libgl1$"):
        setup.install_system_packages(["libgl1"])
    assert calls == []


def test_another_distribution_is_told_what_is_missing(setup, monkeypatch):
    with_programs(monkeypatch, setup)
    with pytest.raises(SystemExit, match="missing: libgl1"):
        setup.install_system_packages(["libgl1"])


def test_an_old_python_gets_a_sentence(setup, monkeypatch):
    monkeypatch.setattr(setup, "OLDEST", (3, 99))
    with_programs(monkeypatch, setup)
    with pytest.raises(SystemExit, match=r"needs Python 3\.99 or newer.*make PYTHON="):
        setup.check_python()


def test_a_second_call_is_quick_until_the_dependencies_change(setup, calls, monkeypatch, tmp_path):
    (tmp_path / "pyproject.toml").write_text("one")
    (tmp_path / ".venv").mkdir()
    monkeypatch.setattr(setup, "ROOT", str(tmp_path))
    monkeypatch.setattr(setup, "VENV", str(tmp_path / ".venv"))
    monkeypatch.setattr(setup, "missing_packages", lambda _: [])
    monkeypatch.chdir(tmp_path)
    setup.main("dev")
    assert calls[-1][-1] == ".[dev]"
    done = len(calls)
    setup.main("dev")
    setup.main("gui")
    assert len(calls) == done
    (tmp_path / "pyproject.toml").write_text("two")
    setup.main("gui")
    assert calls[-1][-1] == ".[gui]"


def test_wrong_use_is_one_line(root):
    done = subprocess.run(
        [sys.executable, root / ".ci" / "setup.py"], capture_output=True, text=True, env={}
    )
    assert done.returncode == 1
    assert done.stderr.count(os.linesep) == 1
