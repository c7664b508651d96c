"""The disk cache of compiled functions is a help and never a hindrance."""

import os
import subprocess
import sys

import pytest

MODULE = """
from ffdstudio.compiling import compiled

@compiled
def half(x):
    return 0.5 * x

@compiled
def quarter(x):
    return half(half(x))
"""
CALL = "import kernels; print(kernels.quarter(6.0), sum(kernels.quarter.stats.cache_hits.values()))"


@pytest.fixture
def call(tmp_path, root):
    (tmp_path / "kernels.py").write_text(MODULE)
    cache = tmp_path / "cache"

    def run(before=(), folder=cache):
        env = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
        env["PYTHONPATH"] = os.pathsep.join([str(tmp_path), str(root)])
        command = [*before, sys.executable, "-B", "-c", CALL]
        done = subprocess.run(command, capture_output=True, text=True, env=env)
        assert done.stderr == ""
        return done.stdout.split()

    run.cache = cache
    return run


def test_a_second_process_finds_what_the_first_compiled(call):
    assert call() == ["1.5", "0"]
    assert call() == ["1.5", "1"]


def cut(data):
    return data[: len(data) // 2]


def empty(data):
    return b""


def hole(data):
    """A page in the middle that never reached the disk."""
    middle = len(data) // 2
    return data[: middle - 500] + bytes(1000) + data[middle + 500 :]


@pytest.mark.parametrize(
    ("suffix", "damage"), [(".nbi", cut), (".nbi", empty), (".nbc", cut), (".nbc", hole)]
)
def test_a_damaged_cache_is_made_anew(call, suffix, damage):
    call()
    files = list(call.cache.rglob(f"*{suffix}"))
    assert len(files) == 2
    for file in files:
        file.write_bytes(damage(file.read_bytes()))
    assert call() == ["1.5", "0"]
    assert call() == ["1.5", "1"]


def test_without_a_place_for_the_cache_it_compiles(call, tmp_path):
    (tmp_path / "file").touch()
    assert call(folder=tmp_path / "file" / "below")[0] == "1.5"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="mounting needs root")
def test_a_full_disk_under_the_cache_does_not_matter(call):
    call.cache.mkdir()
    mount = f"mount -t tmpfs -o size=4k tmpfs {call.cache} || exit 77; "
    fill = f"head -c 4096 /dev/zero > {call.cache}/full; "
    command = ["unshare", "--mount", "sh", "-c", f'{mount}{fill}exec "$@"', "sh"]
    if subprocess.run([*command, "true"], capture_output=True).returncode:
        pytest.skip("this system does not let root mount a file system")
    assert call(command) == ["1.5", "0"]
