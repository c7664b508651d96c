"""What a study may run: whose word it is, and where programs are looked for."""

import os
import stat
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError
from ffdstudio.cli.main import main
from ffdstudio.optimize.build.build import Built, build
from ffdstudio.optimize.build.place import Place
from ffdstudio.optimize.consent import Consent, NotTrusted, Order, located, require, source_of
from ffdstudio.optimize.objectives.function import PythonFunction
from ffdstudio.optimize.spec.codec import from_values


def program(path: Path, text: str = "#!/bin/sh\nexit 0\n") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


@pytest.fixture
def on_path(tmp_path, monkeypatch):
    folder = tmp_path / "bin"
    program(folder / "solve")
    monkeypatch.setenv("PATH", os.pathsep.join([".", "", "relative", str(folder)]))
    return folder


def test_a_program_beside_the_case_is_never_taken_for_one_on_the_path(tmp_path, on_path):
    beside = tmp_path / "case"
    program(beside / "solve")
    assert located(["solve"], beside) == [str(on_path / "solve")]
    assert located(["./solve"], beside) == [str(beside / "solve")]
    assert located([str(beside / "solve")], tmp_path) == [str(beside / "solve")]


def test_a_program_that_only_lies_beside_is_refused_with_the_way_to_name_it(
    tmp_path, on_path, monkeypatch
):
    beside = tmp_path / "case"
    program(beside / "python3")
    monkeypatch.chdir(beside)  # a relative entry of the PATH would find it
    hint = r"no program 'python3' on the PATH; that in .* is \./python3"
    with pytest.raises(InputError, match=hint):
        located(["python3", "solver.py"], beside)


@pytest.mark.parametrize("command", [["./absent"], ["nowhere-to-be-found"], ["./"], [], [""]])
def test_what_is_no_program_is_one_sentence(tmp_path, on_path, command):
    with pytest.raises(InputError):
        located(command, tmp_path)


def test_arguments_are_paths_only_where_a_slash_says_so(tmp_path, on_path):
    (tmp_path / "solver.py").write_text("")
    words = located(["solve", "solver.py", "./solver.py", "./absent", "-x"], tmp_path)
    assert words[1:] == ["solver.py", str(tmp_path / "solver.py"), "./absent", "-x"]


def test_the_users_own_word_needs_no_leave(tmp_path):
    require(Order("program", ("solve",)), Consent())
    assert source_of(tmp_path / "case.toml") is None
    assert source_of(tmp_path) == tmp_path
    assert source_of("a.FFDPROJ") == Path("a.FFDPROJ")


def test_what_came_inside_a_file_runs_only_with_leave():
    order = Order("function", ("module:cost",), Path("wing.ffdproj"))
    with pytest.raises(NotTrusted, match=r"wing\.ffdproj asks to import and call .*--trust"):
        require(order, Consent())
    require(order, Consent(everything=True))


def test_the_window_asks_once_for_each_order():
    asked = []
    consent = Consent(ask=lambda order: asked.append(order) or "yes" in order.words)
    yes, no = (Order("program", ("run", word), Path("a.ffdproj")) for word in ("yes", "no"))
    require(yes, consent)
    require(yes, consent)
    for _ in range(2):  # a no is no promise for ever
        with pytest.raises(NotTrusted):
            require(no, consent)
    assert asked == [yes, no, no]


CASE = {"shape": {"source": "naca0012", "points": 61}, "lattice": {"shape": [5, 2]}}


def with_function(name):
    return CASE | {"objective": {"kind": "function", "name": name}}


def with_program(*command):
    return CASE | {"objective": {"kind": "program", "command": list(command)}}


def test_a_module_of_a_project_is_not_imported_without_leave(tmp_path):
    (tmp_path / "of_a_stranger.py").write_text(
        "import pathlib\npathlib.Path(__file__).with_name('ran').touch()\n"
        "def cost(points):\n    return 0.0\n"
    )
    place = Place(tmp_path, tmp_path / "runs", source=Path("wing.ffdproj"))
    with pytest.raises(NotTrusted, match=r"wing\.ffdproj"):
        build(from_values(with_function("of_a_stranger:cost")), place)
    assert not (tmp_path / "ran").exists()
    trusted = replace(place, consent=Consent(everything=True))
    assert isinstance(build(from_values(with_function("of_a_stranger:cost")), trusted), Built)
    assert (tmp_path / "ran").exists()


def test_a_program_of_a_project_is_not_set_up_without_leave(tmp_path):
    place = Place(tmp_path, tmp_path / "runs", source=tmp_path)
    with pytest.raises(NotTrusted, match="asks to run the program 'sh -c true'"):
        build(from_values(with_program("sh", "-c", "true")), place)
    build(
        from_values(with_program("sh", "-c", "true")),
        replace(place, consent=Consent(everything=True)),
    )


def test_a_case_that_is_named_is_trusted(tmp_path):
    assert isinstance(
        build(from_values(with_program("sh", "-c", "true")), Place(tmp_path, tmp_path / "o")), Built
    )


MODULES = {
    "raises": "raise RuntimeError('boom')",
    "bad_syntax": "def (:",
    "recursion": "def f():\n    f()\nf()",
    "quits": "import sys\nsys.exit('no licence')",
    "zero": "1 / 0",
    "no_unicode": "x = '\\udcff'\nraise ValueError(x)",
    "latin": b"x = '\xff'",
    "null": b"x = 1\0",
    "lacks": "",
    "no_function": "cost = 3",
}


@pytest.mark.parametrize("name", MODULES)
def test_a_module_that_fails_is_one_sentence(tmp_path, monkeypatch, capsys, name):
    module = f"module_that_{name}"
    text = MODULES[name]
    (tmp_path / f"{module}.py").write_bytes(text if isinstance(text, bytes) else text.encode())
    case = tmp_path / "c.toml"
    case.write_text(
        '[shape]\nsource="naca0012"\npoints=61\n[lattice]\nshape=[5,2]\n'
        f'[objective]\nkind="function"\nname="{module}:cost"\n'
    )
    assert main(["optimize", str(case)]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert module in said
    assert "fault of ffdstudio" not in said


NO_NUMBERS = ["12", b"12", True, np.bool_(True), None, [1, 2], {}, 10**400]


@pytest.mark.parametrize("value", NO_NUMBERS)
def test_a_function_returns_a_number_and_nothing_else(value):
    points = np.zeros((3, 3))
    with pytest.raises(InputError, match="no number"):
        PythonFunction(lambda _: value).evaluate(points, gradient=False)
