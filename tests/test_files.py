"""Writing never damages what is there, whatever fails and whenever."""

import io
import os
import re
import resource
import signal
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, remove, together, write_bytes

OLD, NEW = b"old content\n", b"new content\n" * 1000


@pytest.fixture
def target(tmp_path):
    path = tmp_path / "mesh.su2"
    path.write_bytes(OLD)
    return path


def only_file_in(folder):
    (name,) = folder.iterdir()
    return name


def test_what_is_written_is_read_back(tmp_path):
    for data in (b"", b"\x00\r\n\xff", NEW):
        write_bytes(tmp_path / "a", data)
        assert read_bytes(tmp_path / "a") == data
    assert only_file_in(tmp_path) == tmp_path / "a"


class FailingStream(io.FileIO):
    """A file on a disk that is full after `room` bytes."""

    room = 5000

    def write(self, data):
        if self.tell() + len(data) > self.room:
            super().write(bytes(data)[: self.room - self.tell()])
            raise OSError(28, "No space left on device")
        return super().write(data)


def fail(*_args, **_kwargs):
    raise OSError(5, "Input/output error")


@pytest.mark.parametrize(
    ("owner", "call"),
    [(os, "fsync"), (Path, "open"), (Path, "chmod"), (Path, "replace"), (Path, "stat")],
)
def test_each_call_may_fail_and_the_old_file_stays(target, monkeypatch, owner, call):
    with monkeypatch.context() as patch:
        patch.setattr(owner, call, fail)
        with pytest.raises(InputError, match=r"cannot write '.*mesh\.su2': input/output error"):
            write_bytes(target, NEW)
    assert only_file_in(target.parent) == target
    assert target.read_bytes() == OLD


def test_a_disk_that_fills_up_while_writing_leaves_the_old_file(target, monkeypatch):
    def on_full_disk(path, mode):
        return io.BufferedWriter(FailingStream(path, mode.replace("b", "")))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", on_full_disk)
        with pytest.raises(InputError, match="no space left on device"):
            write_bytes(target, NEW)
    assert only_file_in(target.parent) == target
    assert target.read_bytes() == OLD


def test_an_interrupt_leaves_the_old_file_and_no_litter(target, monkeypatch):
    def interrupt(*_args):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", interrupt)
        with pytest.raises(KeyboardInterrupt):
            write_bytes(target, NEW)
    assert only_file_in(target.parent) == target
    assert target.read_bytes() == OLD


def test_litter_that_cannot_be_removed_does_not_hide_the_cause(target, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fail)
        patch.setattr(Path, "unlink", fail)
        with pytest.raises(InputError, match="input/output error"):
            write_bytes(target, NEW)
    assert target.read_bytes() == OLD


def test_a_folder_that_cannot_be_flushed_is_no_failure(target, monkeypatch):
    plain = os.open

    def open_no_folder(path, *args, **kwargs):
        return fail() if Path(path).is_dir() else plain(path, *args, **kwargs)

    monkeypatch.setattr(os, "open", open_no_folder)
    write_bytes(target, NEW)
    monkeypatch.undo()
    assert target.read_bytes() == NEW


@pytest.mark.parametrize("limit", [0, 4096])
def test_the_kernel_refusing_more_bytes_leaves_the_old_file(target, limit):
    def confine():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = run_writer(target, preexec_fn=confine)
    assert "file too large" in done.stdout
    assert only_file_in(target.parent) == target
    assert target.read_bytes() == OLD


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="mounting needs root")
def test_a_real_full_disk_leaves_the_old_file(target):
    disk = target.parent
    commands = (
        f"mount -t tmpfs -o size=8k tmpfs {disk} && printf 'old content\\n' > {target} && "
        f'{sys.executable} -c "$0" {target}; ls -A {disk}; cat {target}'
    )
    done = subprocess.run(
        ["unshare", "--mount", "sh", "-c", commands, WRITER], capture_output=True, text=True
    )
    if "mount" in done.stderr or "unshare" in done.stderr:
        pytest.skip("this system does not let root mount a file system")
    assert done.stdout.endswith("no space left on device\nmesh.su2\nold content\n")


def test_what_a_killed_process_left_goes_with_the_next_write_of_the_same_file(target):
    def leave(path):
        done = run_writer(
            path, script="import os, signal\nos.fsync = lambda _: os.kill(os.getpid(), 9)\n"
        )
        assert done.returncode == -signal.SIGKILL

    def hidden():
        return sorted(path.name for path in target.parent.iterdir() if path.name[0] == ".")

    leave(target), leave(target.with_name("other"))
    assert len(hidden()) == 2
    foreign = target.with_name(".mesh.su2.00000000.99999999.0123abcd")
    old = target.with_name(f".mesh.su2.00000000.{os.getpid()}.0123abcd")
    alive = next(name for name in hidden() if "other" in name).replace("other", "mesh.su2")
    alive = target.with_name(re.sub(r"\d+(?=\.\w+$)", str(os.getpid()), alive))
    for path in (foreign, old, alive):
        path.write_bytes(b"")
    os.utime(old, (0, 0))
    write_bytes(target, NEW)
    kept = [name for name in hidden() if "other" not in name]
    assert kept == sorted([foreign.name, alive.name])
    assert target.read_bytes() == NEW


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_may_never_end_is_not_read(tmp_path, kind):
    path = Path("/dev/zero")
    if kind == "pipe":
        path = tmp_path / "pipe.su2"
        os.mkfifo(path)
    with pytest.raises(InputError) as caught:
        read_bytes(path)
    assert str(caught.value) == f"cannot read {str(path)!r}: it is neither a file nor a folder"


WRITER = """
import sys
from ffdstudio import InputError
from ffdstudio.files import write_bytes
try:
    write_bytes(sys.argv[1], b"x" * 1_000_000)
except InputError as error:
    print(error)
"""


def run_writer(path, script="", **options):
    return subprocess.run(
        [sys.executable, "-c", script + WRITER, path], capture_output=True, text=True, **options
    )


def test_a_read_only_file_is_refused_although_its_folder_is_writable(target, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(InputError, match="permission denied"):
        write_bytes(target, NEW)
    assert only_file_in(target.parent).read_bytes() == OLD


def test_permissions_of_the_replaced_file_are_kept(target):
    target.chmod(0o640)
    write_bytes(target, NEW)
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_a_new_file_follows_the_umask(tmp_path, mask):
    before = os.umask(mask)
    try:
        write_bytes(tmp_path / "new", NEW)
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o666 & ~mask


def test_a_symbolic_link_stays_and_its_target_is_replaced(target, tmp_path):
    link = tmp_path / "folder" / "link.su2"
    link.parent.mkdir()
    link.symlink_to(target)
    write_bytes(link, NEW)
    assert link.is_symlink()
    assert target.read_bytes() == NEW
    assert only_file_in(link.parent) == link


def test_a_dangling_link_gets_its_target(tmp_path):
    (tmp_path / "link").symlink_to("target")
    write_bytes(tmp_path / "link", NEW)
    assert (tmp_path / "target").read_bytes() == NEW


def test_a_device_is_written_and_not_replaced():
    if not Path("/dev/full").is_char_device():
        pytest.skip("no /dev/full here")
    with pytest.raises(InputError, match="'/dev/full': no space left on device"):
        write_bytes("/dev/full", NEW)
    assert Path("/dev/full").is_char_device()
    write_bytes("/dev/null", NEW)
    assert Path("/dev/null").is_char_device()


def test_a_pipe_is_written(tmp_path):
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    write_bytes(pipe, NEW)
    reader.join(timeout=10)
    assert got == [NEW]


def test_a_name_as_long_as_the_system_allows_can_be_written(tmp_path):
    for name in ("n" * 255, "\N{GREEK SMALL LETTER ALPHA}" * 127):
        write_bytes(tmp_path / name, NEW)
        assert (tmp_path / name).read_bytes() == NEW


@pytest.mark.parametrize(
    ("path", "cause"),
    [
        ("no/such/folder/file", "no such file or directory"),
        (".", "is a directory"),
        ("", "is a directory"),
        ("nul\0byte", "embedded null"),
        ("n" * 300, "file name too long"),
        ("occupied/file", "not a directory"),
    ],
)
def test_impossible_paths_are_named_with_the_cause(tmp_path, monkeypatch, path, cause):
    monkeypatch.chdir(tmp_path)
    Path("occupied").write_bytes(OLD)
    for action in (read_bytes, lambda p: write_bytes(p, NEW)):
        with pytest.raises(InputError, match=cause) as caught:
            action(path)
        assert repr(path) in str(caught.value)
        assert "\n" not in str(caught.value)
    assert only_file_in(tmp_path).read_bytes() == OLD


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("failing", [1, 2, 3])
def test_what_is_written_together_is_put_in_place_together_or_not_at_all(
    tmp_path, monkeypatch, failing, links
):
    old, new, gone = (tmp_path / name for name in ("old", "new", "gone"))
    old.write_bytes(OLD), gone.write_bytes(OLD)
    calls, plain = [], Path.replace

    def replace(self, target):
        calls.append(target)
        return fail() if len(calls) == failing else plain(self, target)

    if not links:  # as on a FAT disk
        monkeypatch.setattr(os, "link", fail)

    def write():
        with together():
            remove(gone)
            write_bytes(old, NEW)
            write_bytes(new, NEW)
            assert old.read_bytes() == gone.read_bytes() == OLD
            assert not new.exists()

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", replace)
        if failing < 3:
            with pytest.raises(InputError, match="input/output error"):
                write()
            assert sorted(tmp_path.iterdir()) == [gone, old]
            assert old.read_bytes() == gone.read_bytes() == OLD
            return
        write()
    assert sorted(tmp_path.iterdir()) == [new, old]
    assert old.read_bytes() == new.read_bytes() == NEW


def test_one_that_fails_among_those_held_back_leaves_nothing_of_itself(tmp_path, target):
    with together():
        write_bytes(target, NEW)
        with pytest.raises(InputError):
            write_bytes(tmp_path / "no" / "file", NEW)
    assert only_file_in(tmp_path).read_bytes() == NEW


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664])
def test_what_takes_the_place_of_a_file_is_never_more_open_than_it(target, monkeypatch, mode):
    """From its first byte on, also while several files wait to be put in place."""
    target.chmod(mode)
    other = target.with_name("other.bin")
    seen = []

    def look(descriptor):
        seen.extend(p.stat().st_mode & 0o777 & ~mode for p in target.parent.iterdir())

    write = Path.touch

    def touched(path, *args, **kwargs):
        write(path, *args, **kwargs)
        look(None)

    monkeypatch.setattr(Path, "touch", touched)
    monkeypatch.setattr(os, "fsync", look)
    monkeypatch.setattr(os, "link", fail)  # a disk without second names: a copy is kept
    with together():
        write_bytes(target, NEW)
        remove(other)
        look(None)
    assert set(seen) == {0}
    assert target.stat().st_mode & 0o777 == mode
    assert target.read_bytes() == NEW
