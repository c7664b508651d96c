"""Which files of an OpenFOAM case are its mesh."""

from ffdstudio.project.files.references import files_of


def test_a_linked_mesh_counts_and_other_links_are_not_followed(tmp_path):
    mesh = tmp_path / "base" / "polyMesh"
    mesh.mkdir(parents=True)
    (mesh / "points").write_bytes(b"p")
    (mesh / ".points.old").write_bytes(b"hidden")
    (mesh / "polyMesh").symlink_to(mesh)
    case = tmp_path / "case"
    (case / "constant" / "region" / "polyMesh" / "sets").mkdir(parents=True)
    (case / "constant" / "region" / "polyMesh" / "sets" / "a").write_bytes(b"a")
    (case / "constant" / "polyMesh").symlink_to(mesh)
    (case / "0").symlink_to(tmp_path)
    assert sorted(files_of(case)) == [
        "case/constant/polyMesh/points",
        "case/constant/region/polyMesh/sets/a",
    ]
