"""Linear algebra has one thread where it is asked for, and a limit is set once."""

from threading import Thread
from unittest.mock import Mock

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from grainfit.one_thread import one_thread


def threads() -> set[int]:
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_a_block_within_another_sets_no_limit(thread_limits: Mock) -> None:
    with one_thread():
        with pytest.raises(ZeroDivisionError), one_thread():
            raise ZeroDivisionError
        assert threads() == {1}
    assert thread_limits.call_count == 1
    with threadpool_limits(limits=2, user_api="blas"):
        with one_thread():
            assert threads() == {1}
        assert threads() == {2}
    assert thread_limits.call_count == 2


def test_a_limit_is_that_of_the_thread_that_asks(thread_limits: Mock) -> None:
    other = Thread(target=one_thread()(lambda: None))
    with one_thread():
        other.start()
        other.join()
    assert thread_limits.call_count == 2
