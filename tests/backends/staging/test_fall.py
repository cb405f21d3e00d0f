"""Fallen objects are put back after a delay; objects that a hand carries are not."""

from __future__ import annotations

from cbdsl.backends.staging.scripted_action import Fall


def test_fall_is_due_after_the_delay_below_the_height() -> None:
    fall = Fall(height=0.0, delay=1.0)
    due = [fall.is_due(height, time, touched=False) for time, height in enumerate((0, -0.1, -1))]
    assert due == [False, False, False]
    assert not fall.is_due(-1.0, 2.9, touched=False)
    assert fall.is_due(-1.0, 3.0, touched=False)


def test_fall_is_due_again_only_after_another_fall() -> None:
    fall = Fall(height=0.0, delay=1.0)
    assert not fall.is_due(-1.0, 0.0, touched=False)
    assert not fall.is_due(0.0, 2.0, touched=False)
    assert not fall.is_due(-1.0, 2.5, touched=False)
    assert fall.is_due(-1.0, 3.5, touched=False)


def test_fall_of_a_touched_object_is_never_due() -> None:
    fall = Fall(height=0.0, delay=1.0)
    assert not any(fall.is_due(-1.0, float(time), touched=True) for time in range(5))
