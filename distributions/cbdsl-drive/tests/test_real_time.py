"""Real time: short collections of garbage, and threads that precede other processes."""

from __future__ import annotations

import gc
import os
import sys
import threading
from collections.abc import Iterator

import pytest

from cbdsl_drive.real_time import RealTime

on_linux = pytest.mark.skipif(sys.platform != "linux", reason="SCHED_FIFO is of Linux")


@pytest.fixture
def real_time() -> Iterator[RealTime]:
    entered = RealTime()
    yield entered
    entered.end()


def test_real_time_leaves_few_objects_to_collections(real_time: RealTime) -> None:
    before = len(gc.get_objects())
    real_time.begin()
    assert len(gc.get_objects()) < before / 20
    real_time.end()
    assert len(gc.get_objects()) > before / 2


def test_real_time_of_several_episodes_keeps_no_garbage(real_time: RealTime) -> None:
    frozen = []
    for _ in range(3):
        real_time.begin()
        for _ in range(5000):
            ring: list[object] = []
            ring.append(ring)
        frozen.append(gc.get_freeze_count())
    assert frozen[2] < frozen[0] + 5000


def test_real_time_restores_the_thresholds_of_collections(real_time: RealTime) -> None:
    before = gc.get_threshold()
    gc.set_threshold(100_000)
    try:
        real_time.begin()
        assert gc.get_threshold()[0] < 100_000
        real_time.end()
        assert gc.get_threshold()[0] == 100_000
    finally:
        gc.set_threshold(*before)


@on_linux
def test_real_time_raises_present_threads_and_lowers_them_again(
    real_time: RealTime, monkeypatch: pytest.MonkeyPatch
) -> None:
    policies: dict[int, int] = {}
    monkeypatch.setattr(os, "sched_getscheduler", lambda thread: policies.get(thread, 0))
    monkeypatch.setattr(
        os, "sched_setscheduler", lambda thread, policy, _: policies.update({thread: policy})
    )
    ended = threading.Event()
    other = threading.Thread(target=ended.wait)
    other.start()
    try:
        real_time.begin()
        assert {threading.get_native_id(), other.native_id} <= policies.keys()
        assert set(policies.values()) == {os.SCHED_FIFO | os.SCHED_RESET_ON_FORK}
        real_time.end()
        assert set(policies.values()) == {os.SCHED_OTHER}
    finally:
        ended.set()
        other.join()


@on_linux
def test_real_time_without_permission_changes_no_priority(
    real_time: RealTime, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    before = os.sched_getscheduler(0)
    real_time.begin()
    real_time.end()
    assert os.sched_getscheduler(0) == before
