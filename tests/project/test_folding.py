"""Whether lattices fold, worked out after each edit while somebody looks."""

from __future__ import annotations

from pathlib import Path

import pytest

from ffdstudio.engine.folds import folds
from ffdstudio.project import commands as c
from ffdstudio.project.checks.folding import Foldings, told
from ffdstudio.project.document import Document
from tests.project.scenes import BOX, opened, write_cube


@pytest.fixture
def cube(tmp_path: Path) -> Document:
    return opened(write_cube(tmp_path / "cube.su2"), BOX)


def move(document: Document, x: float) -> None:
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((x, 0.3, 0.3),)))


def test_nothing_is_known_at_rest_or_while_nobody_looks(cube: Document) -> None:
    foldings = Foldings(cube)
    move(cube, 0.4)
    assert foldings.known("lattice2") is None
    foldings.watch(True)
    known = foldings.known("lattice2")
    assert known is not None
    assert known.locally_invertible
    cube.do(c.ResetPoints("lattice2"))
    assert foldings.known("lattice2") is None
    foldings.close()


def test_the_answer_follows_edits_undo_and_weights(cube: Document) -> None:
    foldings, heard = Foldings(cube), []
    foldings.changed.connect(heard.append)
    foldings.watch(True)
    move(cube, 10.0)
    known = foldings.known("lattice2")
    assert known is not None
    assert known.answer is False
    assert told("Box", known) == (
        "Box folds in 1 knot span, at i -0.1 to 1.1, j -0.1 to 1.1, k -0.1 to 1.1.",
        "problem",
    )
    assert heard[-1] == "lattice2"
    move(cube, 0.4)
    cube.do(c.SetWeights("lattice2", ((1, 1, 1),), (2.0,)))
    known = foldings.known("lattice2")
    assert known is not None
    assert known.method.startswith("sampled")
    cube.undo()
    assert str(foldings.known("lattice2")) == str(folds(cube.model.lattices[0].current))
    cube.do(c.Remove("lattice2"))
    assert foldings.known("lattice2") is None
    foldings.close()
