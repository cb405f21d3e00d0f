"""Fallen objects are put back after a delay; objects that a hand carries are not."""

from __future__ import annotations

from cbdsl.backends.staging.fall import Fall


def test_it_is_due_once_it_has_lain_below_for_long_enough() -> None:
    fall = Fall(height=0.0, delay=1.0)
    due = [fall.is_due(height, time, touched=False) for time, height in enumerate((0, -0.1, -1))]
    assert due == [False, False, False]
    assert not fall.is_due(-1.0, 2.9, touched=False)
    assert fall.is_due(-1.0, 3.0, touched=False)


def test_what_is_back_has_to_fall_again() -> None:
    fall = Fall(height=0.0, delay=1.0)
    assert not fall.is_due(-1.0, 0.0, touched=False)
    assert not fall.is_due(0.0, 2.0, touched=False)
    assert not fall.is_due(-1.0, 2.5, touched=False)
    assert fall.is_due(-1.0, 3.5, touched=False)


def test_what_a_hand_carries_below_its_place_is_left_to_it() -> None:
    fall = Fall(height=0.0, delay=1.0)
    assert not any(fall.is_due(-1.0, float(time), touched=True) for time in range(5))
