"""Posture history: the joints at the time of an exposure."""

from __future__ import annotations

import numpy as np

from cbdsl.sensing.vision.vision import PostureHistory


def test_posture_is_that_of_the_tick_of_the_exposure() -> None:
    history = PostureHistory()
    for tick in range(20):
        history.note(tick / 60, np.array([float(tick)]))
    assert history.at(12 / 60)[0] == 12
    assert history.at(12.4 / 60)[0] == 12
    assert history.at(15 / 60 - 1e-9)[0] == 15  # rounding of clocks
    assert history.at(19 / 60)[0] == 19


def test_posture_before_the_history_is_the_oldest() -> None:
    history = PostureHistory()
    history.note(1.0, np.array([7.0]))
    assert history.at(0.2)[0] == 7
    history.reset()
    history.note(0.0, np.array([8.0]))
    assert history.at(0.0)[0] == 8


def test_postures_are_kept_for_longer_than_any_image_is_late() -> None:
    history = PostureHistory()
    for tick in range(40):
        history.note(0.1 * tick, np.array([float(tick)]))
    assert history.at(0.0) == 24.0, "1.5 s before the last, at 3.9 s"
    assert history.at(3.0) == 30.0
    assert history.at(2.95) == 30.0, "older ones are gone once a newer one was asked for"
    assert history.at(3.35) == 33.0
    assert history.at(99.0) == history.at(0.0) == 39.0
    history.reset()
    history.note(5.0, np.array([7.0]))
    assert history.at(9.0) == 7.0
