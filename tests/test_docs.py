"""What the guides tell a user to type works, block by block, and the site builds."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1]
GUIDES = sorted(path.name for path in (HERE / "docs" / "guides").glob("*.md"))


@pytest.fixture
def folder(root, tmp_path, monkeypatch):
    """Folder with nothing but what a checkout has at its top."""
    for name in ("sample_meshes", "resources"):
        (tmp_path / name).symlink_to(root / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("guide", GUIDES)
def test_the_blocks_of_a_guide_run_in_their_order(guide, root, folder):
    text = (root / "docs" / "guides" / guide).read_text()
    blocks = re.findall(r"^```(sh|python)\n(.*?)^```$", text, re.S | re.M)
    assert blocks
    for language, block in blocks:
        if language == "python":
            exec(compile(block, guide, "exec"), {})
            continue
        for command in block.splitlines():
            words = [sys.executable, "-m", *shlex.split(command)]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{command}: {done.stderr}"


def test_pages_lead_to_pages_that_are_there(root):
    for page in (root / "docs").rglob("*.md"):
        for target in re.findall(r"\]\((?!https?:|#)([^)#]+)", page.read_text()):
            made = target.removeprefix("../") in ("reference/commands.md", "reference/keys.md")
            assert made or (page.parent / target).exists(), f"{page.name}: {target}"
