"""Workers: results arrive in the GUI thread, cancelled or outdated ones do not."""

from __future__ import annotations

import threading

import pytest

pytest.importorskip("PySide6")

from ffdstudio.gui.jobs import Jobs


@pytest.fixture
def jobs(qtbot):
    jobs = Jobs()
    yield jobs
    jobs.close()


def test_the_result_arrives_in_the_thread_that_asked(jobs, qtbot):
    came = []
    me = threading.get_ident
    jobs.start("work", lambda p: me(), lambda r: came.append((r, me())))
    qtbot.waitUntil(lambda: bool(came))
    worker, receiver = came[0]
    assert receiver == threading.get_ident() != worker
    assert jobs.running == []


def test_progress_is_reported_and_a_cancel_ends_the_work_at_the_next_report(jobs, qtbot):
    reached, go, came = threading.Event(), threading.Event(), []

    def work(progress):
        progress(0.5, "half")
        reached.set()
        go.wait(10)
        progress(0.9, "nearly")
        came.append("went on")

    job = jobs.start("work", work, came.append)
    qtbot.waitUntil(lambda: job.fraction == 0.5)
    assert job.text == "half"
    assert reached.wait(10)
    job.cancel()
    go.set()
    qtbot.waitUntil(lambda: not jobs.running)
    assert came == []


def test_who_wants_to_know_is_told_of_a_cancel_by_the_user_only(jobs, qtbot):
    go, came = threading.Event(), []
    wait = lambda p: go.wait(10)  # noqa: E731
    jobs.start("old", wait, came.append, key="x", cancelled=lambda: came.append("old"))
    new = jobs.start("new", wait, came.append, key="x", cancelled=lambda: came.append("new"))
    new.cancel()
    go.set()
    qtbot.waitUntil(lambda: not jobs.running)
    assert came == ["new"]


def test_work_with_the_same_key_makes_the_former_one_out_of_date(jobs, qtbot):
    go, came = threading.Event(), []
    jobs.start("old", lambda p: go.wait(10), lambda r: came.append("old"), key="x")
    jobs.start("new", lambda p: None, lambda r: came.append("new"), key="x")
    go.set()
    qtbot.waitUntil(lambda: not jobs.running)
    assert came == ["new"]


def test_an_error_goes_to_who_wants_it_else_to_the_signal(jobs, qtbot):
    def fail(progress):
        raise ValueError("no")

    own, other = [], []
    jobs.failed.connect(lambda job, error: other.append((job.label, str(error))))
    jobs.start("mine", fail, lambda r: None, own.append)
    jobs.start("yours", fail, lambda r: None)
    qtbot.waitUntil(lambda: not jobs.running)
    assert [str(e) for e in own] == ["no"]
    assert other == [("yours", "no")]


def test_finish_waits_for_all_and_delivers(jobs, qtbot):
    came = []
    for number in range(5):
        jobs.start("work", lambda p, n=number: n, came.append)
    jobs.finish()
    assert sorted(came) == [0, 1, 2, 3, 4]


def test_close_waits_for_the_threads_and_calls_nobody(qtbot):
    jobs, came, started = Jobs(), [], threading.Event()

    def work(progress):
        started.set()
        while True:
            progress(0.0)

    jobs.start("work", work, came.append)
    assert started.wait(10)
    before = threading.active_count()
    jobs.close()
    assert threading.active_count() <= before
    qtbot.wait(10)
    assert came == []


def test_a_callback_that_fails_does_not_keep_finish_waiting(jobs, qtbot):
    def fail(_result):
        raise ValueError("a bug")

    with qtbot.captureExceptions() as errors:
        jobs.start("work", lambda p: None, fail)
        jobs.finish()
    assert [str(value) for _, value, _ in errors] == ["a bug"]


def test_jobs_of_one_line_deliver_in_the_order_in_which_they_were_started(jobs, qtbot):
    second, came = threading.Event(), []
    jobs.start("slow", lambda p: second.wait(10), lambda r: came.append("slow"), line="files")
    jobs.start(
        "broken", lambda p: 1 / 0, came.append, lambda e: came.append("broken"), line="files"
    )
    jobs.start("quick", lambda p: None, lambda r: came.append("quick"), line="files")
    jobs.start("other", lambda p: None, lambda r: came.append("other"))
    qtbot.waitUntil(lambda: bool(came))
    second.set()
    qtbot.waitUntil(lambda: not jobs.running)
    assert came == ["other", "slow", "broken", "quick"]


def test_a_cancelled_job_holds_up_nobody_behind_it(jobs, qtbot):
    cancelled, came = threading.Event(), []

    def work(progress):
        cancelled.wait(10)
        progress(0.5)

    slow = jobs.start("slow", work, came.append, line="files")
    jobs.start("quick", lambda p: None, lambda r: came.append("quick"), line="files")
    slow.cancel()
    cancelled.set()
    qtbot.waitUntil(lambda: not jobs.running)
    assert came == ["quick"]


def test_nothing_is_said_to_be_under_way_any_more_when_a_callback_asks(jobs, qtbot):
    seen, came = [], []
    jobs.changed.connect(lambda: seen.append(len(jobs.running)))
    jobs.start("work", lambda p: None, lambda r: came.append(list(seen)))
    qtbot.waitUntil(lambda: bool(came))
    assert came[0][-1] == 0
