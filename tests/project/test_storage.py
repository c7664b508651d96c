"""Project files: what they keep, what they report, what they refuse."""

import io
import json
import os
import shutil
import tracemalloc
import zipfile

import numpy as np
import pytest

from ffdstudio import InputError, Lattice, Project
from ffdstudio.containers import archive
from ffdstudio.project.document import Document
from ffdstudio.project.files import references
from ffdstudio.project.files.opening import read_record
from ffdstudio.project.files.records import BodyRecord, LatticeRecord, ProjectFile
from ffdstudio.project.files.references import on_disk
from ffdstudio.project.files.storage import read_project, write_project

MESH = b"NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 0\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "a.su2").write_bytes(MESH)
    return tmp_path


def content(folder):
    rest = Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 3, 2))
    rng = np.random.default_rng(3)
    current = rest.moved(rng.random(rest.control_points.shape), 0.5 + rng.random(rest.shape))
    return ProjectFile(
        [
            BodyRecord(
                "wing", folder / "meshes" / "a.su2", False, "#aabbcc", settings={"opacity": 0.1}
            )
        ],
        [LatticeRecord("box", rest, current, 1, False, {"note": "x"})],
        {
            "shapes": {"first": {"lattice": current, "points": rng.random((5, 3))}},
            "journal": [{"command": "move", "step": [0.1, -0.0, 5e-324]}],
            "of a later version": {"flags": np.array([True, False]), "nothing": None},
        },
    )


def same(a, b):
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.tobytes() == b.tobytes()
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and a == b


def test_everything_comes_back_with_its_bits(folder):
    old = content(folder)
    write_project(folder / "p.ffdproj", old)
    new = read_project(folder / "p.ffdproj")
    assert new.problems == []
    assert new.bodies == old.bodies
    assert new.lattices == old.lattices
    assert same(new.sections, old.sections)


def test_the_same_project_gives_the_same_bytes(folder):
    for name in "ab":
        write_project(folder / f"{name}.ffdproj", content(folder))
    assert (folder / "a.ffdproj").read_bytes() == (folder / "b.ffdproj").read_bytes()


def test_a_project_opens_anywhere_with_its_meshes_beside_it(folder, tmp_path_factory):
    write_project(folder / "p.ffdproj", content(folder))
    other = tmp_path_factory.mktemp("other") / "deep" / "down"
    shutil.copytree(folder, other)
    shutil.rmtree(folder)
    found = read_project(other / "p.ffdproj")
    assert found.problems == []
    assert found.bodies[0].path == other / "meshes" / "a.su2"


def test_paths_are_relative_with_slashes(folder):
    write_project(folder / "p.ffdproj", content(folder))
    assert manifest(folder / "p.ffdproj")["bodies"][0]["path"] == "meshes/a.su2"


def test_missing_and_changed_meshes_are_reported_and_the_rest_opens(folder):
    write_project(folder / "p.ffdproj", content(folder))
    (folder / "meshes" / "a.su2").write_bytes(MESH.replace(b"0 1\n", b"0 2\n"))
    project = Project.open(folder / "p.ffdproj")
    assert "has changed" in project.problems[0]
    (folder / "meshes" / "a.su2").unlink()
    project = Project.open(folder / "p.ffdproj")
    assert "is missing" in project.problems[0]
    assert project.lattices[0].rest.shape == (4, 3, 2)
    project.save(folder / "p.ffdproj")  # keeps the hash it knew
    (folder / "meshes" / "a.su2").write_bytes(MESH)
    assert Project.open(folder / "p.ffdproj").problems == []


def test_packed_meshes_need_nothing_else(folder, tmp_path_factory):
    write_project(folder / "p.ffdproj", content(folder), pack_meshes=True)
    alone = tmp_path_factory.mktemp("alone") / "p.ffdproj"
    shutil.move(folder / "p.ffdproj", alone)
    shutil.rmtree(folder / "meshes")
    project = Project.open(alone)
    assert project.problems == []
    assert len(project.mesh("wing").points) == 3
    project.save(alone)
    assert len(Project.open(alone).mesh("wing").points) == 3


def test_a_mesh_that_is_gone_cannot_be_packed(folder):
    old = content(folder)
    (folder / "meshes" / "a.su2").unlink()
    with pytest.raises(InputError, match=r"a\.su2"):
        write_project(folder / "p.ffdproj", old, pack_meshes=True)
    assert not (folder / "p.ffdproj").exists()


def test_the_script_face_adds_opens_and_saves(folder):
    project = Project()
    project.add_mesh(folder / "meshes" / "a.su2")
    project.add_lattice("box", Lattice.box([0, 0], [1, 1], shape=(3, 3)))
    with pytest.raises(InputError, match='already has a "box"'):
        project.add_lattice("box", Lattice.box([0, 0], [1, 1], shape=(3, 3)))
    with pytest.raises(InputError, match='no body "b"'):
        project.mesh("b")
    project.save(folder / "p.ffdproj")
    assert Project.open(folder / "p.ffdproj").bodies[0].name == "a"


@pytest.mark.parametrize("value", [object(), {"$array": 1}, {1: 2}, np.array(["x"]), {"a": 1j}])
def test_what_a_project_cannot_hold_is_a_fault_of_the_program(folder, value):
    with pytest.raises(TypeError, match="cannot hold"):
        write_project(folder / "p.ffdproj", ProjectFile(sections={"s": value}))


def test_numbers_that_json_has_no_word_for_survive(folder):
    values = [float("inf"), -float("inf"), np.float64(2.5), np.int32(3)]
    write_project(folder / "p.ffdproj", ProjectFile(sections={"s": values}))
    assert read_project(folder / "p.ffdproj").sections["s"] == [float("inf"), -float("inf"), 2.5, 3]


# ---- what is refused ----------------------------------------------------------------------


def manifest(path):
    with zipfile.ZipFile(path) as file:
        return json.loads(file.read("manifest.json"))


def rewritten(path, change=None, entries=None):
    """The project with another manifest or other entries."""
    with zipfile.ZipFile(path) as file:
        parts = {name: file.read(name) for name in file.namelist()}
    data = json.loads(parts["manifest.json"])
    if change:
        change(data)
    parts["manifest.json"] = json.dumps(data).encode()
    parts |= entries or {}
    with zipfile.ZipFile(path, "w") as file:
        for name, value in parts.items():
            file.writestr(name, value)


def put(*way, value):
    def change(data):
        for key in way[:-1]:
            data = data[key]
        data[way[-1]] = value

    return change


def drop(key):
    return lambda data: data.pop(key)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (put("schema", value=2), "newer FFD Studio"),
        (put("schema", value=0), "no schema 0"),
        (put("schema", value="1"), "whole number"),
        (put("format", value="zip"), "no project file of FFD Studio"),
        (drop("sections"), '"sections" is missing'),
        (put("bodies", value={}), "must be a list"),
        (put("bodies", value=[1]), "list of objects"),
        (put("bodies", 0, "colour", value="red; rm"), "no colour"),
        (put("bodies", 0, "packed", value=["meshes/0/x.su2"]), "is missing"),
        (put("bodies", 0, "packed", value=["manifest.json"]), "is missing"),
        (put("lattices", 0, "frozen", value=-1), "frozen"),
        (put("lattices", 0, "rest", value={}), "do not fit"),
        (put("lattices", 0, "rest", "$lattice", "degrees", value=[9, 2, 1]), "degree 9"),
        (put("lattices", 0, "rest", "$lattice", "degrees", value="abc"), "must be a list"),
        (put("lattices", 0, "rest", "$lattice", "weights", value=None), "weights"),
        (put("sections", value={"x": {"$array": "arrays/99.npy"}}), "is missing"),
        (put("sections", value={"x": {"$array": "../secret"}}), "is missing"),
        (put("sections", value={"x": {"$array": "manifest.json"}}), "is damaged"),
    ],
)
def test_a_wrong_manifest_is_refused_in_one_sentence(folder, change, words):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    rewritten(path, change)
    with pytest.raises(InputError, match=words) as error:
        read_project(path)
    assert str(error.value).startswith(str(path))


def npy(array, **header):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def huge_header():
    data = npy(np.zeros(3))
    return data.replace(b"(3,)", b"(%d,)" % 10**12)[:128]


@pytest.mark.parametrize(
    "entry",
    [
        npy(np.array([{"a": 1}], dtype=object)),
        npy(np.array(["text"])),
        npy(np.zeros(3))[:-1],
        npy(np.zeros(3)) + b"\0",
        huge_header(),
        b"",
        b"\x93NUMPY\x01\x00\xff\xff",
    ],
)
def test_an_array_that_is_none_is_refused(folder, entry):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    rewritten(path, entries={"arrays/0.npy": entry})
    with pytest.raises(InputError, match="damaged"):
        read_project(path)


OUTSIDE = ["../evil.txt", "/etc/evil", "a/../../evil", "c:evil", "a\\evil", "a\nb", "a/\x1b[1m"]
OUTSIDE += ["meshes/0//etc/evil", "a//b", "a/./b", "a/ /b", "a/.../b", "./a", "a/"]


@pytest.mark.parametrize("name", OUTSIDE[:-1])
def test_entries_that_leave_the_archive_are_refused(folder, name):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    rewritten(path, entries={name: b"x"})
    with pytest.raises(InputError, match="leaves its folder"):
        read_project(path)


def test_a_packed_mesh_is_never_laid_out_elsewhere(folder, tmp_path_factory):
    """The double slash of ``meshes/0//path`` would make the rest of it absolute."""
    victim = tmp_path_factory.mktemp("victim") / "victim.su2"
    victim.write_bytes(b"precious")
    for entry in (f"meshes/0/{victim}", f"meshes/0//{victim}", f"meshes/0/../..{victim}"):
        path = folder / "p.ffdproj"
        write_project(path, content(folder), pack_meshes=True)
        rewritten(path, lambda m, e=entry: m["bodies"][0].update(packed=[e]), {entry: MESH})
        with pytest.raises(InputError, match="leaves its folder"):
            read_project(path)
    record = BodyRecord("b", victim, packed={f"/{victim}": MESH, "../x/a.su2": MESH})
    with pytest.raises(InputError, match="leaves the folder"), on_disk(record):
        pass
    assert victim.read_bytes() == b"precious"


def test_a_symbolic_link_in_the_archive_is_refused(folder):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    link = zipfile.ZipInfo("meshes/0/a.su2")
    link.external_attr = 0o120777 << 16
    with zipfile.ZipFile(path, "a") as archived:
        archived.writestr(link, "/etc/passwd")
    with pytest.raises(InputError, match="symbolic link"):
        read_project(path)


@pytest.mark.parametrize("inner", ["[" * 300 + "]" * 300, '{"a":' * 70 + "1" + "}" * 70])
def test_nested_sections_are_refused(folder, inner):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    text = json.dumps(manifest(path) | {"sections": "HERE"}).replace('"HERE"', f'{{"a": {inner}}}')
    rewritten(path, entries={"manifest.json": text.encode()})
    with pytest.raises(InputError, match="nested too deeply"):
        read_project(path)


def test_a_manifest_of_empty_objects_is_refused_in_little_memory(folder):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    text = json.dumps(manifest(path) | {"sections": "HERE"}).encode()
    many = b'{"a": [' + b"{}," * 1_000_000 + b"{}]}"
    rewritten(path, entries={"manifest.json": text.replace(b'"HERE"', many)})
    tracemalloc.start()
    with pytest.raises(InputError, match="lists and objects"):
        read_project(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20 * len(many)


@pytest.mark.parametrize("path", ["/proc", "/", "/dev"])
def test_a_body_that_is_a_whole_disk_is_a_problem(folder, path, monkeypatch):
    monkeypatch.setattr(references, "MOST_FILES", 20_000)
    project = folder / "p.ffdproj"
    write_project(project, content(folder))
    rewritten(project, lambda m: m["bodies"][0].update(path=path))
    found = read_project(project)
    assert len(found.problems) == 1
    assert path in found.problems[0]


SETTINGS = [
    {"hidden_markers": 10**40},
    {"hidden_markers": "wall"},
    {"hidden_markers": [["wall"], {}, 3, None]},
    {"boxes": ["update"]},
    {"boxes": {"a": 1}},
    {"boxes": 1e300},
]


@pytest.mark.parametrize("settings", SETTINGS)
def test_settings_of_another_type_are_left_aside(folder, settings):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    rewritten(path, lambda m: m["bodies"][0].update(settings=settings))
    opened = read_record(read_project(path).bodies[0]).command
    assert opened.hidden_markers == ()
    assert opened.boxes == "update"


def test_a_bomb_is_refused_before_it_is_unpacked(folder, monkeypatch):
    monkeypatch.setattr(archive, "ALWAYS_FINE", 2**20)
    path = folder / "p.ffdproj"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as bomb:
        with bomb.open("arrays/0.npy", "w", force_zip64=True) as stream:
            stream.write(bytes(2**22))
        bomb.writestr("manifest.json", "{}")
    with pytest.raises(InputError, match="would unpack to"):
        read_project(path)


def test_a_flipped_bit_anywhere_is_refused_or_harmless(folder):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    whole, old = path.read_bytes(), read_project(path)
    for place in range(0, len(whole), 41):
        data = bytearray(whole)
        data[place] ^= 0x10
        path.write_bytes(data)
        try:
            new = read_project(path)
        except InputError:
            continue
        assert new.lattices == old.lattices


def test_every_truncation_is_refused(folder):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    whole = path.read_bytes()
    for length in range(0, len(whole), 101):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError):
            read_project(path)


def test_a_failed_save_leaves_the_old_file(folder, monkeypatch):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    before = path.read_bytes()

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="no space left"):
        write_project(path, ProjectFile())
    assert path.read_bytes() == before
    assert sorted(p.name for p in folder.iterdir()) == ["meshes", "p.ffdproj"]


@pytest.mark.parametrize("stored", [1e40, "text", {"a": 1}, [[1]], [["bent", 3]], None])
@pytest.mark.parametrize("key", ["shapes", "open_faces"])
def test_settings_of_a_lattice_of_another_type_are_left_aside(folder, key, stored):
    path = folder / "p.ffdproj"
    write_project(path, content(folder))
    rewritten(path, lambda m: m["lattices"][0]["settings"].update({key: stored}))
    rewritten(path, lambda m: m["lattices"][0].update(frozen=0))
    rewritten(path, lambda m: m["sections"].update(window=stored))
    document = Document()
    document.problem.connect(lambda *_: None)
    document.open(path)
    assert [item.name for item in document.model.lattices] == ["box"]
    assert not document.model.lattices[0].shapes
    document.save(folder / "again.ffdproj")
