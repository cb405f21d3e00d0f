"""The composer: gains, references and stacks changed by hand, in synthetic episodes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.runtime.program_composer import Composer, ComposerError
from cbdsl.runtime.tick import Tick
from tests.conftest import Checked
from tests.runtime.conftest import Play

#: Free place within reach of the right hand, m.
ELSEWHERE = (0.45, -0.3, 0.25)


class Hand:
    """Changes at given ticks, and the observations of every tick."""

    def __init__(self, changes: dict[int, Callable[[Composer], object]], last: int) -> None:
        self.composer, self.changes, self.last = Composer(), changes, last
        self.ticks: list[tuple[str, tuple[str, ...], str]] = []
        self.tips: list[np.ndarray] = []
        self.answers: list[object] = []

    def __call__(self, tick: Tick) -> None:
        if not self.ticks:
            self.composer.begin(tick.run)
        active = tuple(each.run.controller.name for each in tick.run.active())
        self.ticks.append((tick.run.state, active, tick.run.predicate))
        named = {run.controller.name: run for run in tick.run.runs}
        tip = tick.signals.read(named["approach"].controller.feedback)
        assert tip is not None
        self.tips.append(tip.value.copy())
        number = len(self.ticks)
        if number in self.changes:
            try:
                self.answers.append(self.changes[number](self.composer))
            except ComposerError as error:
                self.answers.append(str(error))
        if number == self.last:
            raise KeyboardInterrupt


def watch(play: Play, checked: Checked, hand: Hand) -> None:
    with pytest.raises(KeyboardInterrupt):
        play(checked("reachtouch"), watch=hand)


def test_composed_stack_acts_in_its_order_and_the_program_waits(
    play: Play, checked: Checked
) -> None:
    stack = ("orient", "approach")
    hand = Hand({100: lambda c: c.compose(stack)}, last=400)
    watch(play, checked, hand)
    before, after = hand.ticks[99], hand.ticks[150]
    assert before[1][:2] != stack
    assert after[1] == (*stack, "preshape", "home"), "the background stays below"
    assert {state for state, _, _ in hand.ticks[101:]} == {before[0]}
    assert {predicate for _, _, predicate in hand.ticks} == {"0"}


def test_given_back_the_program_chooses_again_and_comes_to_its_end(
    play: Play, checked: Checked
) -> None:
    hand = Hand(
        {100: lambda c: c.compose(["approach"]), 200: lambda c: c.compose(None)}, last=100_000
    )
    result = play(checked("reachtouch"), watch=hand).result
    assert result.rewarded
    assert {active for _, active, _ in hand.ticks[100:199]} == {("approach", "preshape", "home")}
    assert hand.composer.stack is None


def test_held_reference_is_gone_to_and_given_back(play: Play, checked: Checked) -> None:
    hand = Hand(
        {
            100: lambda c: c.compose(["approach"]),
            101: lambda c: c.hold("approach", ELSEWHERE),
            600: lambda c: dict(c.positions()),
            601: lambda c: c.hold("approach", None),
            1100: lambda c: dict(c.positions()),
        },
        last=1100,
    )
    watch(play, checked, hand)
    held, own = hand.answers[2], hand.answers[4]
    assert held["approach"] == pytest.approx(ELSEWHERE)  # type: ignore[index]
    assert np.linalg.norm(np.subtract(own["approach"], ELSEWHERE)) > 0.1  # type: ignore[index]
    # The point in front of the palm goes there; the tip is behind it by the standoff.
    distances = [np.linalg.norm(tip - ELSEWHERE) for tip in (hand.tips[99], hand.tips[599])]
    assert 0.08 < distances[1] < 0.15 < distances[0]
    assert np.linalg.norm(hand.tips[1099] - hand.tips[599]) > 0.1


def test_larger_gain_moves_the_hand_faster(play: Play, checked: Checked) -> None:
    def after(gain: float) -> float:
        changes = {
            1: lambda c: c.compose(["posture"]),
            2: lambda c: c.set_gain("posture", gain),
        }
        hand = Hand(changes, last=20)
        watch(play, checked, hand)
        return float(np.linalg.norm(hand.tips[-1] - hand.tips[0]))

    slow, fast = after(0.05), after(0.5)
    assert slow > 0 and fast > 3 * slow


def test_changes_last_over_episodes(play: Play, checked: Checked) -> None:
    first = Hand(
        {
            10: lambda c: c.set_gain("approach", 3.0),
            11: lambda c: c.hold("approach", ELSEWHERE),
            12: lambda c: c.compose(["approach"]),
        },
        last=13,
    )
    watch(play, checked, first)
    second = Hand({5: lambda c: c.positions()}, last=5)
    second.composer = first.composer
    gains: list[float] = []

    def look(tick: Tick) -> None:
        second(tick)
        gains.extend(r.gain for r in tick.run.runs if r.controller.name == "approach")

    with pytest.raises(KeyboardInterrupt):
        play(checked("reachtouch"), watch=look)
    assert second.ticks[2][1][0] == "approach"
    assert second.answers[0]["approach"] == pytest.approx(ELSEWHERE)  # type: ignore[index]
    assert gains[-1] == 3.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.set_gain("approac", 1.0), "did you mean 'approach'"),
        (lambda c: c.set_gain("approach", 0.0), "above 0"),
        (lambda c: c.set_gain("approach", math.nan), "above 0"),
        (lambda c: c.set_gain("approach", 1e6), "at most"),
        (lambda c: c.hold("touch", ELSEWHERE), "only constant or sensed positions"),
        (lambda c: c.hold("posture", None), "only constant or sensed positions"),
        (lambda c: c.hold("approach", (1.0, 2.0)), "three numbers"),
        (lambda c: c.hold("approach", (1.0, 2.0, math.inf)), "three numbers"),
        (lambda c: c.compose([]), "at least one"),
        (lambda c: c.compose(["touch", "touch"]), "each of them once"),
        (lambda c: c.compose(["searchtrack.track"]), "unknown controller"),
    ],
)
def test_impossible_change_is_refused_without_effect(
    play: Play, checked: Checked, change: Callable[[Composer], object], words: str
) -> None:
    hand = Hand({2: change}, last=3)
    watch(play, checked, hand)
    assert words in str(hand.answers[0])
    composer = hand.composer
    assert (composer.gains, composer.targets, composer.stack) == ({}, {}, None)


def test_change_before_an_episode_is_refused() -> None:
    with pytest.raises(ComposerError, match="no episode"):
        Composer().compose(["approach"])
