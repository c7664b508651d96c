"""What the README tells a new user to type works, word for word."""

import re
import shlex
import subprocess
import sys

import pytest


@pytest.fixture
def blocks(root, tmp_path, monkeypatch):
    """Code blocks of the README by language, in a folder with nothing but the samples."""
    for folder in ("sample_meshes", "resources"):
        (tmp_path / folder).symlink_to(root / folder)
    monkeypatch.chdir(tmp_path)
    found = re.findall(r"^```(\w*)\n(.*?)^```$", (root / "README.md").read_text(), re.S | re.M)
    return {language: [text for kind, text in found if kind == language] for language, _ in found}


def test_the_commands_run(blocks, tmp_path):
    commands = [line for text in blocks[""] for line in text.splitlines()]
    commands = [line for line in commands if line.startswith("ffdstudio ")]
    assert len(commands) >= 7
    for command in commands:
        words = [sys.executable, "-m", *shlex.split(command)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}: {done.stderr}"
    assert (tmp_path / "morphed.su2").exists()
    assert len(list((tmp_path / "wing").iterdir())) == 3


def test_the_python_example_runs(blocks, tmp_path, capsys):
    for text in blocks["python"]:
        exec(compile(text, "README.md", "exec"), {})
    assert float(capsys.readouterr().out) < 1e-14
    assert (tmp_path / "morphed.su2").exists()
