"""Small lattice files that announce great things: one sentence, at once, in little memory."""

import tracemalloc

import pytest

from ffdstudio import InputError, Lattice
from ffdstudio.exchange import read_lattice_file
from ffdstudio.project.files.replaying import replay

CUBE = "0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 1, 1 0 1, 1 1 1, 0 1 1"


def su2(counts, points=0):
    lines = ["NDIME= 3", "NELEM= 0", "NPOIN= 1", "0 0 0", "NMARK= 0"]
    lines += ["FFD_NBOX= 1", "FFD_NLEVEL= 1", "FFD_TAG= B", "FFD_LEVEL= 0"]
    lines += [f"FFD_DEGREE_{d}= {n - 1}" for d, n in zip("IJK", counts, strict=True)]
    lines += ["FFD_PARENTS= 0", "FFD_CHILDREN= 0", "FFD_CORNER_POINTS= 8", *CUBE.split(", ")]
    return "\n".join([*lines, f"FFD_CONTROL_POINTS= {points}", "FFD_SURFACE_POINTS= 0", ""])


def config(counts):
    degrees = ", ".join(str(n - 1) for n in counts)
    return f"FFD_DEFINITION= (B, {CUBE.replace(' ', ', ')})\nFFD_DEGREE= ({degrees})\n"


def prm(counts):
    lines = ["[Box info]"]
    for key, values in (("n control points", counts), ("box length", (1, 1, 1))):
        lines += [f"{key} {a}: {v}" for a, v in zip("xyz", values, strict=True)]
    lines += [f"{key} {a}: 0" for key in ("box origin", "rotation angle") for a in "xyz"]
    return "\n".join([*lines, "[Parameters weights]", *(f"parameter {a}: 0 0 0 0" for a in "xyz")])


def gotools(counts):
    ends = [f"{n} 2\n" + " ".join(["0", *map(str, range(n)), str(n - 1)]) for n in counts]
    return "\n".join(["700 1 0 0", "3 0", *ends, "0 0 0"])


HUGE, LONG = (100_001, 100_001, 11), (2000, 2000, 2)


@pytest.mark.parametrize("counts", [HUGE, LONG, (2, 2, 10**12)])
@pytest.mark.parametrize(
    ("name", "text"), [("a.su2", su2), ("a.cfg", config), ("a.prm", prm), ("a.g2", gotools)]
)
def test_an_announced_net_is_refused_before_it_is_made(tmp_path, name, text, counts):
    if name == "a.g2" and max(counts) > 10**6:
        counts = (5000, 5000, 2)
    path = tmp_path / name
    path.write_text(text(counts))
    tracemalloc.start()
    with pytest.raises(InputError) as error:
        read_lattice_file(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20 * path.stat().st_size + 20e6
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "text", [su2((3, 3, 3), 10**9), su2((3, 3, 3)).replace("NBOX= 1", "NBOX= 9999999")]
)
def test_announced_counts_that_do_not_follow_are_refused(tmp_path, text):
    path = tmp_path / "a.su2"
    path.write_text(text)
    with pytest.raises(InputError, match=r"a\.su2"):
        read_lattice_file(path)


@pytest.mark.parametrize(
    "text",
    [
        "700 1 0 0\n3 0\n0 0\n0 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n",
        "700 1 0 0\n3 0\n1 1\n0 1\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0 0 0 0 0 0 0 0 0 0\n",
        "100 1 0 0\n3 0\n0 0\n",
    ],
)
def test_an_object_without_points_is_refused(tmp_path, text):
    path = tmp_path / "a.g2"
    path.write_text(text)
    with pytest.raises(InputError, match="at least 2 control points"):
        read_lattice_file(path)


@pytest.mark.parametrize("counts", [(999, 2, 2), (2, 60, 2)])
def test_a_degree_without_bounds_is_refused(tmp_path, counts):
    path = tmp_path / "a.cfg"
    path.write_text(config(counts))
    with pytest.raises(InputError, match="more than 50"):
        read_lattice_file(path)


def test_a_broken_ini_is_one_sentence_without_python(tmp_path):
    path = tmp_path / "a.prm"
    path.write_text(prm((2, 2, 2)) + '\n" 3 0 1\n=\n')
    with pytest.raises(InputError, match=r"a\.prm: line \d+ is nothing") as error:
        read_lattice_file(path)
    assert "<string>" not in str(error.value)


@pytest.mark.parametrize("shape", [(100_000, 100_000, 10), (1000, 1000, 60), (2, 2, 10**15)])
def test_a_box_of_any_origin_has_the_same_limit(shape, tmp_path):
    with pytest.raises(InputError, match="more than the 1,000,000"):
        Lattice.box([0, 0, 0], [1, 1, 1], shape)
    path = tmp_path / "a.jsonl"
    path.write_text(
        '{"format":"ffdstudio-journal","schema":1}\n'
        '{"do":"create box","name":"B","lower":[0,0,0],"upper":[1,1,1],'
        f'"shape":{list(shape)},"degrees":[1,1,1]}}\n'
    )
    with pytest.raises(InputError, match="more than the 1,000,000"):
        replay(path)


def test_ragged_indices_in_a_journal_are_one_sentence(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_text(
        '{"format":"ffdstudio-journal","schema":1}\n'
        '{"do":"create box","name":"B","lower":[0,0,0],"upper":[1,1,1],'
        '"shape":[4,4,4],"degrees":[3,3,3]}\n'
        '{"do":"move points","item":"lattice1","points":[[1,1],[2,2,2]],"positions":[[0,0,0]]}\n'
    )
    with pytest.raises(InputError, match="has 3 indices"):
        replay(path)


@pytest.mark.parametrize("weight", [2e4, 1e-5, 1e308, 5e-324])
def test_weights_beyond_what_can_be_evaluated_are_refused(weight):
    """At a factor of a million points of the box itself are lost, and looking for them is slow."""
    box = Lattice.box([0, 0, 0], [1, 1, 1], (3, 3, 3))
    weights = box.weights.copy()
    weights[1, 1, 1] = weight
    with pytest.raises(InputError, match="differ by more than a factor of 10000"):
        box.moved(weights=weights)
    weights[1, 1, 1] = 1e4
    box.moved(weights=weights)
