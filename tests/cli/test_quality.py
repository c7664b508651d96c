"""``ffdstudio quality``: the table, JSON, comparison, and what it refuses."""

import json

import numpy as np
import pytest

from ffdstudio.cli.main import main

SU2 = """NDIME= 2
NELEM= 2
5 0 1 2 0
5 0 2 3 1
NPOIN= 4
0 0 0
1 0 1
1 1 2
{} 3
NMARK= 1
MARKER_TAG= wall
MARKER_ELEMS= 1
3 0 1
"""


@pytest.fixture
def meshes(tmp_path):
    """A plane mesh, the same one stretched, one with an inverted cell, and another mesh."""
    corners = {"rest": "0 1", "moved": "0 1.25", "folded": "2 -1"}
    for name, corner in corners.items():
        (tmp_path / f"{name}.su2").write_text(SU2.format(corner))
    other = SU2.format("0 1").replace("5 0 1 2 0\n5 0 2 3 1", "5 0 1 3 0\n5 1 2 3 1")
    (tmp_path / "other.su2").write_text(other)
    return tmp_path


def told(capsys, *arguments):
    code = main(["quality", *map(str, arguments)])
    return code, capsys.readouterr()


def test_json_has_min_max_and_mean_of_each_measure(meshes, capsys):
    code, out = told(capsys, meshes / "rest.su2", "--json")
    result = json.loads(out.out)
    assert code == 0
    assert (result["cells"], result["inverted"]) == (2, 0)
    assert result["measures"]["volume"]["mean"] == 0.5
    for entry in result["measures"].values():
        assert entry["min"] <= entry["mean"] <= entry["max"]
    assert "volume_ratio" not in result["measures"]


def test_against_the_undeformed_mesh(meshes, capsys):
    code, out = told(capsys, meshes / "moved.su2", "--against", meshes / "rest.su2", "--json")
    measures = json.loads(out.out)["measures"]
    assert code == 0
    assert measures["volume_ratio"]["max"] == pytest.approx(1.25)
    assert measures["first_layer_ratio"]["max"] == pytest.approx(1.0)
    assert np.isfinite(measures["volume_ratio"]["percentiles"]["50"])


def test_an_inverted_cell_is_exit_code_1(meshes, capsys):
    code, out = told(capsys, meshes / "folded.su2", "--against", meshes / "rest.su2")
    assert code == 1
    assert "1 inverted" in out.out


def test_without_a_reference_nothing_is_called_inverted(meshes, capsys):
    code, out = told(capsys, meshes / "folded.su2")
    assert code == 0
    first = out.out.splitlines()[0]
    assert "inverted" not in first
    assert "negative corner" in first
    assert "--against" in first


def test_the_table_names_measures_limits_and_definitions(meshes, capsys):
    code, out = told(capsys, meshes / "rest.su2")
    assert code == 0
    for word in ("skewness", "OpenFOAM", "Fluent", "SU2", "Verdict", "worst cell"):
        assert word in out.out


def test_another_mesh_is_no_reference(meshes, capsys):
    code, out = told(capsys, meshes / "moved.su2", "--against", meshes / "other.su2")
    assert code == 2
    assert "not the same mesh" in out.err


def test_a_negative_number_of_worst_cells_is_refused(meshes, capsys):
    code, out = told(capsys, meshes / "rest.su2", "--worst", "-1")
    assert code == 2
    assert "--worst" in out.err
