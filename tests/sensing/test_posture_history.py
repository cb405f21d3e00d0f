"""Posture history: the joints at the time of an exposure."""

from __future__ import annotations

import numpy as np

from cbdsl.sensing.posture_history import PostureHistory


def test_the_posture_is_that_of_the_tick_of_the_exposure() -> None:
    history = PostureHistory()
    for tick in range(20):
        history.note(tick / 60, np.array([float(tick)]))
    assert history.at(12 / 60)[0] == 12
    assert history.at(12.4 / 60)[0] == 12
    assert history.at(15 / 60 - 1e-9)[0] == 15  # rounding of clocks
    assert history.at(19 / 60)[0] == 19


def test_before_all_that_is_known_it_is_the_oldest() -> None:
    history = PostureHistory()
    history.note(1.0, np.array([7.0]))
    assert history.at(0.2)[0] == 7
    history.reset()
    history.note(0.0, np.array([8.0]))
    assert history.at(0.0)[0] == 8
