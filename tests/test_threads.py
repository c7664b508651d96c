import multiprocessing
import threading

import pytest

from ffdstudio import threads


def test_each_item_is_worked_on_once(monkeypatch):
    monkeypatch.setattr(threads, "count", lambda: 4)
    done = []
    threads.for_each(done.append, range(1000))
    assert sorted(done) == list(range(1000))
    threads.for_each(done.append, [])
    assert len(done) == 1000


def test_an_error_in_any_thread_reaches_the_caller():
    caller = threading.current_thread()
    for here in (True, False):

        def fail(_, here=here):
            if (threading.current_thread() is caller) == here:
                raise ValueError("as told")

        if here or threads.count() > 1:
            with pytest.raises(ValueError, match="as told"):
                _often(fail)


def _often(work):
    for _ in range(1000):  # until the thread in question gets an item
        threads.for_each(work, range(100))


def test_work_may_ask_for_threads_itself(monkeypatch):
    monkeypatch.setattr(threads, "count", lambda: 2)
    done = []
    threads.for_each(lambda _: threads.for_each(done.append, range(10)), range(10))
    assert len(done) == 100


def _child(answers):
    done = []
    threads.for_each(done.append, range(100))
    answers.put(len(done))


@pytest.mark.skipif(
    "fork" not in multiprocessing.get_all_start_methods(), reason="this system cannot fork"
)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_child_has_threads_of_its_own():
    threads.for_each(str, range(100))
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    child = context.Process(target=_child, args=(answers,))
    child.start()
    assert answers.get(timeout=30) == 100
    child.join(timeout=30)
