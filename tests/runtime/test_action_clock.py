"""Clock of a program's run: limits of actions, of idle time, and of the whole episode."""

from __future__ import annotations

import pytest

from cbdsl.runtime.action_clock import ActionClock
from tests.conftest import Checked


@pytest.fixture
def clock(checked: Checked) -> ActionClock:
    """Return a clock of ticks of 1 s with limits of 3 s, 2 s idle and 5 s in total."""
    program = checked("posture")._replace(transition_time=3.0, idle_time=2.0, episode_time=5.0)
    return ActionClock(program, 1.0)


def test_action_is_over_after_its_time(clock: ActionClock) -> None:
    over = []
    for _ in range(4):
        clock.advance()
        over.append(clock.is_over)
    assert over == [False, False, False, True] and clock.seconds == 4.0
    clock.begin_action()
    assert not clock.is_over and clock.ticks == 0


def test_episode_is_over_after_actions_and_searches(clock: ActionClock) -> None:
    for _ in range(2):
        clock.advance()
        clock.begin_action()
        clock.advance_search()
    assert not clock.is_episode_over
    clock.advance()
    assert clock.is_episode_over
    clock.restart()
    assert not clock.is_episode_over


def test_idle_time_begins_again_after_activity(clock: ActionClock) -> None:
    idle = [clock.is_idle(strives=each) for each in (False, False, True, False, False, False)]
    assert idle == [False, False, False, False, False, True]


def test_program_without_limits_is_neither_idle_nor_over(checked: Checked) -> None:
    program = checked("posture")._replace(idle_time=None, episode_time=None)
    clock = ActionClock(program, 1e9)
    clock.advance()
    assert not clock.is_episode_over and not clock.is_idle(strives=False)
