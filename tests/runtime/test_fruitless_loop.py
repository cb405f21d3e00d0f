"""Loops of actions that change nothing end the program, and all others go on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.fruitless_loop import FruitlessLoop, last_rounds
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.resource import Resource
from tests.conftest import Checked
from tests.runtime.conftest import Play
from tests.runtime.synthetic import World
from tests.runtime.test_program_run import Written

STAY = "{potential: spring, reference: here, feedback: head, effector: head}"
SLOW = STAY.replace("}", ", quiescence: {rate: 100, window: 1.5 s}}")
SEARCH = (
    "{potential: spring, reference: head.uniform, feedback: head, effector: head, gain: 8 /s, "
    "speed: 1.5 rad/s}"
)
REACH = (
    "{potential: spring, reference: stereo.sat_10, feedback: right_arm.position, "
    "effector: right_arm.position}"
)
POSITIONAL = "actions: [first, reach]\npolicy: {XX: first, 0X: first, 1X: reach, X-: first}\n"
STEPS = "steps:\n  first: {then: reach}\n  reach: {then: end, failed: first}\n"


def nothing(rng: np.random.Generator) -> World:
    return World()


def program_of(written: Written, first: str, policy: str) -> CheckedProgram:
    """Return a program of an action and a reach whose object is never seen by both cameras."""
    return written(
        f"controllers: {{first: {first}, reach: {REACH}}}\n{policy}"
        "limits: {transitions: 100, transition_time: 4 s}\n"
    )


@pytest.mark.parametrize("policy", [POSITIONAL, STEPS])
def test_loop_that_changes_nothing_ends_early_with_its_steps(
    written: Written, play: Play, policy: str
) -> None:
    result = play(program_of(written, STAY, policy), nothing).result
    assert len(result.actions) < 100
    assert "went round first and reach for 3.0 s, and no round changed a signal" in result.ending
    assert "stereo.sat_10 stayed undefined" in result.ending


def test_loop_whose_joints_move_goes_on(written: Written, play: Play) -> None:
    result = play(program_of(written, SEARCH, POSITIONAL), nothing).result
    assert "used up its 100 transitions" in result.ending


def test_loop_that_waits_goes_on(written: Written, play: Play) -> None:
    result = play(program_of(written, SLOW, POSITIONAL), nothing).result
    assert "used up its 100 transitions" in result.ending


class Measured:
    """Signals of one resource and one joint, which a test sets."""

    def __init__(self) -> None:
        self.time, self.positions = 0.0, np.zeros(1)
        self.value: np.ndarray | None = None

    def read(self, resource: Resource) -> Reading | None:
        return None if self.value is None else Reading(self.value, None, 0)


@pytest.mark.parametrize("kind", ["joint", "value", "undefined"])
def test_loop_ends_only_after_the_last_change_of_a_signal(written: Written, kind: str) -> None:
    signals = Measured()
    loop = FruitlessLoop(program_of(written, STAY, POSITIONAL), signals)  # type: ignore[arg-type]
    ended = 0.0
    for tick in range(200):
        signals.time = 0.1 * tick
        count = min(tick, 60)
        if kind == "joint":
            signals.positions = np.array([0.02 * count])
        elif kind == "value":
            signals.value = np.array([0.05 * count, 0.0, 0.0])
        elif count % 20 == 10:
            signals.value = np.zeros(3) if signals.value is None else None
        if loop.note(("first", "reach")[tick % 2], ("1X", "X-")[tick % 2]):
            ended = signals.time
            break
    last = {"undefined": 5.0}.get(kind, 6.0)
    assert ended == pytest.approx(last + 3.0, abs=0.31)


@pytest.mark.parametrize("time", [0.2, 0.5, 0.9, 1.2])
@pytest.mark.parametrize("size", [2, 3, 8])
def test_loop_of_quick_actions_ends_after_a_round_and_one_that_waits_goes_on(
    written: Written, size: int, time: float
) -> None:
    signals, ended = Measured(), 0.0
    loop = FruitlessLoop(program_of(written, STAY, POSITIONAL), signals)  # type: ignore[arg-type]
    for number in range(100):
        signals.time = time * number
        if loop.note(f"action {number % size}", "1X"):
            ended = signals.time
            break
    if time > 1.0:
        assert not ended
    else:
        least = 2 * size * time + max(3.0, size * time)
        assert least - 1e-6 <= ended <= least + 2 * time


TURN = (
    "{{potential: spring, reference: [{} deg, 0 deg], feedback: head, effector: head, "
    "speed: 0.6 rad/s}}"
)
PATROL = "right: {then: reach}\n  reach: {then: end, failed: left}\n"


@pytest.mark.parametrize("then", [PATROL, "right: {then: left}\n"])
def test_slow_loop_that_moves_ends_early_if_an_action_is_undefined(
    written: Written, play: Play, then: str
) -> None:
    reach = f", reach: {REACH}" if then == PATROL else ""
    program = written(
        f"controllers: {{left: {TURN.format(40)}, right: {TURN.format(-40)}{reach}}}\n"
        f"steps:\n  left: {{then: right}}\n  {then}"
        "limits: {transitions: 50, transition_time: 6 s}\n"
    )
    ending = play(program, nothing).result.ending
    assert ("went round" if then == PATROL else "used up its 50 transitions") in ending


@pytest.fixture
def two_actions(written: Written) -> CheckedProgram:
    return program_of(written, STAY, POSITIONAL)


PARTS = st.tuples(st.floats(0.1, 4.0), st.booleans(), st.sampled_from("1-"))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(PARTS, min_size=2, max_size=6), st.sampled_from([0.0, 0.01]))
def test_loop_ends_unless_it_waits_drifts_or_moves_without_an_undefined_state(
    two_actions: CheckedProgram, parts: list[tuple[float, bool, str]], drift: float
) -> None:
    signals, ended, place = Measured(), 0.0, 0.0
    loop = FruitlessLoop(two_actions, signals)  # type: ignore[arg-type]
    places = []
    for number in range(120 * len(parts)):
        lasts, moves, state = parts[number % len(parts)]
        place = float(number % len(parts)) if moves else place
        signals.time += lasts
        signals.positions = np.array([place + drift * (number // len(parts))])
        places.append(place)
        if loop.note(f"action {number % len(parts)}", f"X{state}"):
            ended = signals.time
            break
    durations, last = [each[0] for each in parts], places[-len(parts) - 1 :]
    kept = dict(zip(range(len(places) - len(parts), len(places)), np.diff(last) == 0, strict=True))
    waits = any(same and durations[n % len(parts)] > 1.0 for n, same in kept.items())
    means = not all(kept.values()) and all(state == "1" for *_, state in parts)
    if drift or waits or means:
        assert not ended
    else:
        patience = max(3.0 if all(kept.values()) else 30.0, sum(durations))
        assert patience <= ended + 1e-9 <= patience + 5 * sum(durations)


class MeasuredObject(Measured):
    """Signals of which only those of an object change."""

    def read(self, resource: Resource) -> Reading | None:
        is_of_object = resource.name.startswith("stereo")
        return super().read(resource) if is_of_object else Reading(np.zeros(1), None, 0)


def test_loop_goes_on_while_the_signal_of_a_condition_changes(written: Written) -> None:
    signals = MeasuredObject()
    program = written(
        f"controllers: {{first: {STAY}, second: {STAY}}}\n"
        "conditions: {raised: stereo.sat_10.z > 1 m}\n"
        "steps:\n"
        "  first: {exits: [raised: end, first at rest: second]}\n"
        "  second: {exits: [second at rest: first]}\n"
    )
    loop = FruitlessLoop(program, signals)  # type: ignore[arg-type]
    for tick in range(100):
        signals.time, signals.value = 0.1 * tick, np.array([0.0, 0.0, 0.05 * tick])
        assert not loop.note(("first", "second")[tick % 2], ("1X0", "X1X")[tick % 2])


@pytest.mark.parametrize("name", ["searchtrack", "reachtouch"])
def test_shipped_search_for_an_absent_object_goes_on(
    checked: Checked, play: Play, name: str
) -> None:
    assert "went round" not in play(checked(name), nothing).result.ending


@given(st.text("abc", max_size=6), st.text("abc", min_size=1, max_size=5), st.integers(2, 4))
def test_last_rounds_of_a_course_are_the_shortest_ones(
    before: str, around: str, rounds: int
) -> None:
    course = before + rounds * around
    size, count = last_rounds(course, len(around), rounds)
    assert 0 < size <= len(around)
    assert count >= rounds
    assert course.endswith(count * course[-size:])
    shorter = range(1, size)
    assert not any(course.endswith(rounds * course[-each:]) for each in shorter)
    assert last_rounds(course, len(around), len(course) + 1) == (0, 0)
