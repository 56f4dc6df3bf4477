"""What all tests share."""

import os
import signal
import sys
from collections.abc import Iterator
from unittest.mock import Mock

import pytest
from hypothesis import HealthCheck, settings
from threadpoolctl import threadpool_limits

from grainfit import one_thread

# Workers and children of the tests find compiled modules, as users do, also where an image of a
# container forbids to keep them: each start would compile all of grainfit again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# How fast examples are drawn says how busy a machine is, and nothing of a test.
settings.register_profile(
    "busy machine", suppress_health_check=[HealthCheck.too_slow], deadline=None
)
settings.load_profile("busy machine")


@pytest.fixture(scope="session", autouse=True)
def _one_thread_of_linear_algebra() -> Iterator[None]:
    """As in a calibration: threads on small matrices cost more than they give."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield


@pytest.fixture
def thread_limits(monkeypatch: pytest.MonkeyPatch) -> Mock:
    """Count the limits that are set for threads of linear algebra."""
    found = Mock(wraps=threadpool_limits)
    monkeypatch.setattr(one_thread, "threadpool_limits", found)
    return found


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Let SIGINT interrupt this process and its children, as in a terminal.

    A shell without job control starts what is in the background with SIGINT ignored, and so would
    every child of the tests be.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the slow tests: at the end, one of them alone would keep everybody waiting.

    The longest ones calibrate real heaps and come last by name.
    """
    slow = [item for item in items if item.get_closest_marker("slow")]
    fast = [item for item in items if not item.get_closest_marker("slow")]
    items[:] = slow[::-1] + fast
