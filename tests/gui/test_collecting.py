"""Cycles are collected in the GUI thread, whoever has made them."""

from __future__ import annotations

import gc
import threading
import weakref
from typing import Any

import pytest

pytest.importorskip("PySide6")

from ffdstudio.gui.gui_gc import collector
from ffdstudio.gui.jobs import Jobs


class Loop:
    """Refers to itself, and tells in which thread it ends."""

    def __init__(self, ends: list[int]) -> None:
        self.me = self
        weakref.finalize(self, lambda: ends.append(threading.get_ident()))


@pytest.fixture
def jobs(qtbot: Any) -> Any:
    jobs = Jobs()
    yield jobs
    jobs.close()


def test_the_automatic_collector_is_off_and_there_is_one_of_ours(jobs: Jobs) -> None:
    assert not gc.isenabled()
    assert collector() is collector()


def test_cycles_of_a_worker_end_in_the_gui_thread(jobs: Jobs, qtbot: Any) -> None:
    ends: list[int] = []
    begun: list[int] = []

    def work(progress: Any) -> None:
        begun.append(threading.get_ident())
        for _ in range(5000):  # far more than makes the automatic collector run
            Loop(ends)

    jobs.start("loops", work, lambda _: None)
    qtbot.waitUntil(lambda: bool(begun) and not jobs.running)
    qtbot.waitUntil(lambda: len(ends) >= 5000, timeout=10_000)
    assert set(ends) == {threading.get_ident()} != set(begun)


def test_a_full_collection_waits_for_work_but_not_for_ever(
    jobs: Jobs, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ffdstudio.gui import gui_gc as collecting

    asked: list[tuple[int, ...]] = []
    monkeypatch.setattr(collecting.gc, "collect", lambda *generation: asked.append(generation))
    monkeypatch.setattr(collecting.gc, "get_count", lambda: (0, 0, 11))
    collector()._waited, go = 0, threading.Event()
    jobs.start("work", lambda progress: go.wait(20), lambda _: None)
    for _ in range(collecting.PATIENCE):
        collector().collect()
    assert asked == []
    collector().collect()
    assert asked == [()]
    go.set()
    qtbot.waitUntil(lambda: not jobs.running)
    collector().collect()
    assert len(asked) > 1
