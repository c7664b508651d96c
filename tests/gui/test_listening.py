"""Listeners of a signal: one that fails is reported and keeps nothing from the others."""

from __future__ import annotations

import sys

import pytest

pytest.importorskip("PySide6")

from psygnal import Signal

from ffdstudio.gui.subscriptions import Listening


class Source:
    told = Signal(str)


@pytest.fixture
def reported(monkeypatch: pytest.MonkeyPatch) -> list[BaseException]:
    found: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda kind, error, trace: found.append(error))
    return found


def test_a_failing_listener_is_reported_and_the_others_hear(reported: list[BaseException]) -> None:
    source, heard = Source(), []

    def fail() -> None:
        raise KeyError("body2")

    listening = Listening((source.told, fail), (source.told, heard.append))
    source.told.emit("all")
    assert heard == ["all"]
    assert [str(error) for error in reported] == ["'body2'"]
    listening.stop()
    source.told.emit("more")
    assert (len(heard), len(reported)) == (1, 1)


def test_a_listener_gets_as_many_values_as_it_takes(reported: list[BaseException]) -> None:
    source, heard = Source(), []
    listening = Listening((source.told, lambda: heard.append("nothing")))
    source.told.emit("all")
    listening.stop()
    assert heard == ["nothing"]
    assert reported == []
