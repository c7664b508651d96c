"""OpenFOAM: the folder of a mesh in every encoding, cases, copies and damage."""

from __future__ import annotations

import gzip
import shutil
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from ffdstudio.project.files import references
from ffdstudio.project.files.opening import read_record
from ffdstudio.project.files.records import BodyRecord
from tests.meshes.specimens import grid_points, hexahedra, hexahedron_faces

pytestmark = pytest.mark.filterwarnings("ignore::ffdstudio.meshes.MeshWarning")

HEADER = """/* a comment with 7 ( in it */
FoamFile
{{
    version 2.0;
    format {form};
    {arch}
    class {kind};
    object {name};
}}
// * * 5 ( * //

"""
BOUNDARY = """3
(
    front {{ type symmetryPlane; nFaces {0}; startFace {1}; }} // a comment
    "left.*" {{ type cyclic; neighbourPatch rest; nFaces 0; startFace {1}; }}
    rest {{ type wall; inGroups 1(wall); nFaces {2}; startFace {3}; }}
)
"""
ARCHS = {(4, 8): "label=32;scalar=64", (8, 8): "label=64;scalar=64", (4, 4): "label=32;scalar=32"}


def block() -> tuple[np.ndarray, list, list, list]:
    """Points, faces, owners and neighbours of a block of hexahedra, inner faces first."""
    faces, owner, neighbour = hexahedron_faces()
    return grid_points(), faces, owner, [cell for cell in neighbour if cell >= 0]


def make(folder: Path, arch: tuple[int, int] | None = None, compress: bool = False) -> Path:
    """Case whose mesh is ASCII, or binary with labels and scalars of these widths."""
    mesh = folder / "constant" / "polyMesh"
    mesh.mkdir(parents=True)
    points, faces, owner, neighbour = block()
    inner = len(neighbour)
    outer = len(faces) - inner
    texts = {
        "boundary": BOUNDARY.format(4, inner, outer - 4, inner + 4).encode(),
    }
    if arch is None:
        rows = " \n".join(f"({x!r} {y!r}\t{z!r})" for x, y, z in points.tolist())
        texts["points"] = f"{len(points)}\n(\n{rows}\n)\n".encode()
        listed = "\n".join(f"4({' '.join(map(str, face))})" for face in faces)
        texts["faces"] = f"{len(faces)}\n(\n{listed}\n)\n".encode()
        for name, labels in (("owner", owner), ("neighbour", neighbour)):
            texts[name] = f"{len(labels)}({' '.join(map(str, labels))})".encode()
    else:
        label, scalar = f"<i{arch[0]}", f"<f{arch[1]}"

        def raw(values, dtype, many):
            return f"{many}\n(".encode() + np.asarray(values, dtype).tobytes() + b")"

        texts["points"] = raw(points, scalar, len(points)) + b"\n// end\n"
        offsets = 4 * np.arange(len(faces) + 1)
        texts["faces"] = raw(offsets, label, len(offsets)) + raw(faces, label, 4 * len(faces))
        texts["owner"], texts["neighbour"] = (
            raw(labels, label, len(labels)) for labels in (owner, neighbour)
        )
    for name, text in texts.items():
        form = "ascii" if arch is None or name == "boundary" else "binary"
        line = f'arch "LSB;{ARCHS[arch]}";' if arch else ""
        data = HEADER.format(form=form, arch=line, kind="list", name=name).encode() + text
        if compress and name != "boundary":
            (mesh / f"{name}.gz").write_bytes(gzip.compress(data, mtime=5))
        else:
            (mesh / name).write_bytes(data)
    return folder


CASES = {
    "ascii": {},
    "ascii.gz": {"compress": True},
    "binary 32/64": {"arch": (4, 8)},
    "binary 64/64": {"arch": (8, 8)},
    "binary 32/32": {"arch": (4, 4)},
    "binary.gz": {"arch": (4, 8), "compress": True},
}


@pytest.fixture(params=CASES)
def case(request, tmp_path) -> Path:
    return make(tmp_path / "case", **CASES[request.param])


def files(folder: Path) -> dict[str, bytes]:
    mesh = folder / "constant" / "polyMesh"
    return {path.name: path.read_bytes() for path in sorted(mesh.iterdir())}


def plain(data: bytes) -> bytes:
    return gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data


def test_a_case_is_read_with_patches_and_their_kinds(case):
    mesh = read_mesh(case)
    assert mesh.counts == {"hexahedron": 12}
    assert mesh.marker_counts == {"front": 4, "left.*": 0, "rest": 28}
    assert mesh.kinds == {"front": "symmetry", "left.*": "periodic", "rest": "wall"}
    assert np.abs(mesh.points - grid_points()).max() < 1e-6


def test_at_rest_all_files_keep_their_bytes(case, tmp_path):
    write_mesh(read_mesh(case), tmp_path / "out")
    assert files(tmp_path / "out") == files(case)


def test_moving_one_point_changes_its_numbers_in_points_and_nothing_else(case, tmp_path):
    mesh = read_mesh(case)
    moved = mesh.points.copy()
    moved[17] += [0.5, 0.25, -0.125]
    write_mesh(mesh, tmp_path / "out.v2", moved)
    old, new = files(case), files(tmp_path / "out.v2")
    different = [name for name in old if old[name] != new[name]]
    assert [name.removesuffix(".gz") for name in different] == ["points"]
    before, after = plain(old[different[0]]), plain(new[different[0]])
    if b"binary" in before[:200]:
        changed = np.flatnonzero(np.frombuffer(before, "u1") != np.frombuffer(after, "u1"))
        assert np.ptp(changed) < 24
    else:
        pairs = zip(before.split(b"\n"), after.split(b"\n"), strict=True)
        assert sum(a != b for a, b in pairs) == 1


def scalars(data: bytes, count: int) -> np.ndarray:
    """Binary points of single precision, which foamlib does not read."""
    begin = data.index(f"{count}\n(".encode()) + len(f"{count}\n(")
    return np.frombuffer(data, "<f4", 3 * count, begin).reshape(-1, 3)


def test_foamlib_finds_the_intended_coordinates(case, tmp_path):
    foamlib = pytest.importorskip("foamlib")
    mesh = read_mesh(case)
    points = mesh.points + np.random.default_rng(0).normal(0, 0.01, mesh.points.shape)
    single = mesh.template.dtype.itemsize == 4
    if single:
        with pytest.warns(MeshWarning, match="single precision"):
            write_mesh(mesh, tmp_path / "out", points)
        points = points.astype(np.float32).astype(np.float64)
    else:
        write_mesh(mesh, tmp_path / "out", points)
    found = plain(files(tmp_path / "out").get("points") or files(tmp_path / "out")["points.gz"])
    path = tmp_path / "points"
    path.write_bytes(found.replace(b"/* a comment with 7 ( in it */\n", b""))
    theirs = foamlib.FoamFile(path)[()] if not single else scalars(found, len(points))
    assert np.array_equal(np.asarray(theirs, dtype=np.float64), points)


def test_the_real_case_opens_by_folder_by_foam_file_and_by_its_mesh(shared, tmp_path):
    real = shared / "meshes" / "openfoam" / "airFoil2D"
    meshes = [read_mesh(real / name) for name in ("", "c.foam", "constant/polyMesh")]
    for mesh in meshes:
        assert mesh.counts == {"hexahedron": 10720}
        assert mesh.kinds["frontAndBack"] == "empty"
        assert len(mesh.marker_nodes("frontAndBack")) == 21812
    write_mesh(meshes[0], tmp_path / "out")
    write_mesh(meshes[1], tmp_path / "other" / "c.foam")
    assert files(tmp_path / "out") == files(real) == files(tmp_path / "other")


def test_written_over_itself_only_the_points_change_and_processors_are_named(case):
    (case / "processor0").mkdir()
    mesh, before = read_mesh(case), files(case)
    with pytest.warns(MeshWarning, match="decomposed"):
        write_mesh(mesh, case, mesh.points * 2)
    after = files(case)
    assert {name for name in before if before[name] != after[name]} <= {"points", "points.gz"}


def test_what_is_no_mesh_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no folder"):
        read_mesh(tmp_path)
    (tmp_path / "processor0").mkdir()
    with pytest.raises(InputError, match="decomposed; reconstruct"):
        read_mesh(tmp_path)


DAMAGE = {
    "points": [
        (b"0.0 0.0", b"nan 0.0", "line .*not finite|finite"),
        (b"36\n", b"37\n", "37 points are announced"),
        (b"FoamFile", b"FoamFila", "no FoamFile header"),
    ],
    "faces": [(b"\n4(", b"\n5(", "faces of the sizes"), (b"4(0 ", b"4(99 ", "not in 0 to 35")],
    "owner": [(b"52(", b"51(", "51 labels are announced"), (b"(0 ", b"(999 ", "cannot be there")],
    "boundary": [(b"nFaces 4", b"nFaces 400", "patch front ends behind")],
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_refused_with_file_and_cause(tmp_path, name):
    case = make(tmp_path / "case")
    path = case / "constant" / "polyMesh" / name
    good = path.read_bytes()
    for old, new, cause in DAMAGE[name]:
        assert old in good, old
        path.write_bytes(good.replace(old, new, 1))
        with pytest.raises(InputError, match=cause):
            read_mesh(case)


def test_damaged_compression_is_refused(tmp_path):
    case = make(tmp_path / "case", compress=True)
    path = case / "constant" / "polyMesh" / "points.gz"
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(InputError, match="damaged compression"):
        read_mesh(case)
    shutil.rmtree(case)


def add_zones(case, arch=None, cells=(0, 1, 5), faces=(0, 30)):
    def labels(values):
        if arch is None:
            return f"{len(values)}\n(\n{' '.join(map(str, values))}\n)".encode()
        return f"{len(values)}\n(".encode() + np.asarray(values, f"<i{arch[0]}").tobytes() + b")"

    form = "ascii" if arch is None else "binary"
    line = f'arch "LSB;{ARCHS[arch]}";' if arch else ""
    for what, values in (("cell", cells), ("face", faces)):
        head = HEADER.format(form=form, arch=line, kind="regIOobject", name=f"{what}Zones")
        text = f"2\n(\nrest\n{{\n  type {what}Zone;\n{what}Labels      List<label> \n".encode()
        flips = b"flipMap List<bool> 2(0 1);" if what == "face" else b""
        tail = f"none {{ type {what}Zone; {what}Labels List<label> 0(); }}\n)\n".encode()
        path = case / "constant" / "polyMesh" / f"{what}Zones"
        path.write_bytes(head.encode() + text + labels(values) + b";" + flips + b"}\n" + tail)


@pytest.mark.parametrize("arch", [None, (4, 8), (8, 8)])
def test_zones_of_cells_and_faces_become_markers(tmp_path, arch):
    case = make(tmp_path / "case", arch)
    add_zones(case, arch)
    mesh = read_mesh(case)
    zone = mesh.markers["rest (cell zone)"]["polyhedron8"]
    assert [set(row) for row in zone.tolist()] == [set(hexahedra()[k]) for k in (0, 1, 5)]
    faces = mesh.markers["rest (face zone)"]["quad"]
    assert faces.tolist() == [hexahedron_faces()[0][k] for k in (0, 30)]
    assert mesh.boundaries == [*mesh.kinds, "rest (face zone)"]
    write_mesh(mesh, tmp_path / "out", mesh.points + 1)
    assert read_mesh(tmp_path / "out").marker_counts == mesh.marker_counts


def test_a_zone_with_cells_that_are_not_there_is_refused(tmp_path):
    case = make(tmp_path / "case")
    add_zones(case, cells=(0, 12))
    with pytest.raises(InputError, match="zone rest refers to a cell not in 0 to 11"):
        read_mesh(case)


def test_a_compressed_file_of_several_members_is_read_whole(tmp_path):
    case = make(tmp_path / "case", compress=True)
    path = case / "constant" / "polyMesh" / "points.gz"
    data = gzip.decompress(path.read_bytes())
    path.write_bytes(gzip.compress(data[:700]) + gzip.compress(data[700:]))
    mesh = read_mesh(case)
    assert np.array_equal(mesh.points, grid_points())
    write_mesh(mesh, tmp_path / "out")
    assert files(tmp_path / "out") == files(case)
    path.write_bytes(path.read_bytes()[:-9])
    with pytest.raises(InputError, match="damaged compression"):
        read_mesh(case)


NESTED = """4
(
    front
    {{
        type cyclicAMI; nFaces 2; startFace {0};
        surface {{ type triSurfaceMesh; name "a}}b.obj"; nFaces 9; inner {{ startFace 0; }} }}
        neighbourPatch rear;
    }}
    rear {{ type cyclicAMI; nFaces 2; startFace {1}; neighbourPatch front; coupled {{}} }}
    "a b" {{ surface {{ name x; }} type wall; inGroups 1(wall); nFaces 0; startFace {1}; }}
    rest {{ type wall; nFaces {2}; startFace {3}; }}
)
"""


def test_dictionaries_inside_a_patch_hide_nothing(tmp_path):
    case = make(tmp_path / "case")
    inner = len(block()[3])
    outer = len(block()[1]) - inner
    text = NESTED.format(inner, inner + 2, outer - 4, inner + 4)
    (case / "constant" / "polyMesh" / "boundary").write_text(
        HEADER.format(form="ascii", arch="", kind="list", name="boundary") + text
    )
    mesh = read_mesh(case)
    assert mesh.marker_counts == {"front": 2, "rear": 2, "a b": 0, "rest": outer - 4}
    assert mesh.kinds == {"front": "periodic", "rear": "periodic", "a b": "wall", "rest": "wall"}
    assert mesh.partners == {"front": "rear", "rear": "front"}
    boundary = case / "constant" / "polyMesh" / "boundary"
    boundary.write_text(boundary.read_text().replace("coupled {}", "coupled {"))
    with pytest.raises(InputError, match="does not end"):
        read_mesh(case)


@pytest.mark.parametrize("name", ["faces", "owner", "neighbour", "boundary"])
@pytest.mark.parametrize("where", ["elsewhere", "itself"])
def test_points_are_not_mixed_with_a_mesh_that_has_changed_since(case, tmp_path, name, where):
    mesh = read_mesh(case)
    folder = case / "constant" / "polyMesh"
    file = next(path for path in (folder / name, folder / f"{name}.gz") if path.exists())
    file.write_bytes(file.read_bytes() + b"\n")
    target = case if where == "itself" else tmp_path / "new"
    before = files(case)
    with pytest.raises(InputError, match=f"{name}.* has changed since the mesh was read"):
        write_mesh(mesh, target, mesh.points + 0.5)
    assert files(case) == before
    assert not (tmp_path / "new").exists()


def test_a_packed_case_is_written_although_its_folder_is_gone(case, tmp_path):
    record = BodyRecord("case", case)
    record.packed = references.contents(record)
    record.sha256 = references.fingerprint(record.packed)
    mesh = read_record(record).command.mesh
    assert not mesh.template.folder.exists()
    write_mesh(mesh, tmp_path / "new", mesh.points + 0.5)
    assert np.allclose(read_mesh(tmp_path / "new").points, mesh.points + 0.5, atol=1e-6)
    written, old = files(tmp_path / "new"), files(case)
    assert {k: v for k, v in written.items() if "points" not in k} == {
        k: v for k, v in old.items() if "points" not in k
    }
