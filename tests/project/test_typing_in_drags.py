"""Numbers typed during a drag, by the events that the window sends."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffdstudio.project.commands import CreateBox
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.tools import Options, Tools
from ffdstudio.project.interaction.typed_numbers import evaluated
from ffdstudio.project.view.camera import Camera
from tests.project.scenes import opened, write_cube

CAMERA = Camera(np.diag([1.0, 1.0, -0.1, 1.0]), 400, 400)


@pytest.fixture
def document(tmp_path):
    box = CreateBox("Box", (-0.1,) * 3, (1.1,) * 3, (3, 3, 3), (2, 2, 2))
    document = opened(write_cube(tmp_path / "cube.su2"), box)
    document.select([(2, 2, 2)])
    return document


def typed(document, keys, options=None):
    """Begin a drag of the front corner, type, and return what is said; Return takes it."""
    tools = Tools(document, options or Options())
    point = document.model.active_lattice.current.control_points[2, 2, 2]
    x, y = CAMERA.project(point)[0]
    tools.handle(PointerEvent("press", CAMERA, x, y, "left"))
    tools.handle(PointerEvent("move", CAMERA, x + 30, y - 10))
    for key in keys:
        tools.handle(PointerEvent("key", CAMERA, x, y, key=key))
    said = tools.feedback.text
    tools.handle(PointerEvent("key", CAMERA, x, y, key="Return"))
    return said


def moved(document):
    item = document.model.active_lattice
    return (item.current.control_points - item.rest.control_points)[2, 2, 2]


def test_a_typed_vector_takes_the_place_of_the_mouse(document):
    said = typed(document, ["0", ".", "2", "Tab", "-", "0", ".", "1"])
    assert moved(document) == pytest.approx([0.2, -0.1, 0])
    assert said.startswith("x 0.2   y -0.1|   z 0")
    assert document.history.labels[-1].startswith("Move")


def test_along_a_locked_axis_one_number_is_enough_and_expressions_count(document):
    typed(document, ["Y", "=", "1", "/", "4"])
    assert moved(document) == pytest.approx([0, 0.25, 0])


def test_backspace_takes_back_and_an_empty_text_gives_the_mouse_back(document):
    typed(document, ["5", "Backspace"])
    assert moved(document)[0] == pytest.approx(30 / 200)


def test_angles_and_factors_are_typed(document):
    document.select([(2, 2, 2), (0, 2, 2)])
    typed(document, ["9", "0"], Options("rotate"))
    assert moved(document) == pytest.approx([-0.6, 0.6, 0])
    document.undo()
    typed(document, ["2"], Options("scale"))
    assert moved(document) == pytest.approx([0.6, 0, 0])


@given(st.text(alphabet="0123456789.,+-*/()=e _x", max_size=40))
def test_whatever_is_typed_is_a_finite_number_or_none(text):
    value = evaluated(text)
    assert value is None or np.isfinite(value)


def test_only_arithmetic_is_understood():
    for text in ("__import__('os')", "x", "2**9999999", "[1]", "1 if 1 else 2", "9" * 400 + "e9"):
        assert evaluated(text) is None
