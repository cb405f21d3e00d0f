"""Controllers in one compiled call do what each does by itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from cbdsl.control.crew import Crew, gather
from cbdsl.control.kernel import DONE, ERROR, FOLLOW, PHI, REST, SEEK
from cbdsl.control.member import Member
from cbdsl.control.predicate import QuiescenceMonitor
from cbdsl.control.signal import Floats
from cbdsl.control.stack import Stack
from cbdsl.control.task import Task
from cbdsl.sensing.reading import Reading
from tests.control.test_kernel import CASES, JOINTS, drawn, readings
from tests.control.test_task import TICK

#: All but manipulability, whose curvature is too much to be copied.
MEMBERS = CASES[:-1]


@dataclass
class Team:
    """One member per case, with a stack of their levels."""

    members: list[Member]
    stack: Stack
    columns: np.ndarray

    def act(self, positions: Floats, first: int = 0, last: int = len(MEMBERS)) -> int:
        crew = Crew(self.members, self.stack, self.columns)
        return crew.act(first, last, positions, posture=7)


@pytest.fixture
def team(rng: np.random.Generator) -> Team:
    members = []
    for potential, controller in MEMBERS:
        monitor = QuiescenceMonitor(1e-3, rng.uniform(0.02, 0.1), TICK)
        members.append(Member(potential, Task(controller, potential, TICK), monitor, JOINTS))
    stack = Stack([(str(i), member.task.before.size) for i, member in enumerate(members)], 5)
    columns = rng.integers(-1, JOINTS, (len(members), 5))
    gather(members[::-1])  # in any order
    return Team(members, stack, columns)


def feel(member: Member, reading: Reading, reference: Floats, stamp: int) -> None:
    assert member.aim(Reading(reference, np.zeros((0, 0)), 0))
    assert member.feel(reading, stamp, 0.0)
    member.duty = FOLLOW


def test_together_they_do_what_each_does_by_itself(team: Team, rng: np.random.Generator) -> None:
    alone = [Task(controller, potential, TICK) for potential, controller in MEMBERS]
    monitors = [
        QuiescenceMonitor(settings[1] / settings[0], settings[0], TICK)
        for settings in (member.monitor.settings for member in team.members)
    ]
    stack = Stack([(str(i), task.before.size) for i, task in enumerate(alone)], 5)
    for place, task in enumerate(alone):
        task.join(stack, place, team.columns[place])
    streams = [list(readings(controller, rng)) for _, controller in MEMBERS]
    references = [drawn(controller, rng) for _, controller in MEMBERS]
    for tick in range(30):
        stack.turn()
        team.stack.turn()
        # From the eighth on nothing changes, and some come to rest.
        now = [stream[min(tick, 7)] for stream in streams]
        for member, reading, reference in zip(team.members, now, references, strict=True):
            feel(member, reading, reference, stamp=tick)
        assert team.act(np.zeros(JOINTS)) == len(MEMBERS)
        for place, task in enumerate(alone):
            found = task.act(now[place], references[place], 0.0)
            assert team.members[place].outcome[[PHI, ERROR]].tolist() == list(found)
            predicate = monitors[place].update(found[0], tick)
            assert team.members[place].monitor.predicate == predicate
        np.testing.assert_array_equal(team.stack.rows, stack.rows)
        np.testing.assert_array_equal(team.stack.wanted, stack.wanted)
        np.testing.assert_array_equal(team.stack.ages, stack.ages)
    assert {monitor.predicate for monitor in monitors} == {"1"}


def test_duties(team: Team, rng: np.random.Generator) -> None:
    """Who rests has no level, who seeks no potential, and who is done is left alone."""
    duties = [FOLLOW, SEEK, REST, DONE, FOLLOW, REST]
    for tick in range(2):
        team.stack.turn()
        cases = zip(team.members, MEMBERS, duties, strict=True)
        for member, (_, controller), duty in cases:
            feel(member, next(readings(controller, rng)), drawn(controller, rng), tick)
            member.duty = duty
        assert team.act(np.zeros(JOINTS)) == len(MEMBERS)
    assert team.stack.ages.tolist() == [2, 2, 0, 0, 2, 0]
    judged = [bool(np.isfinite(member.outcome[PHI])) for member in team.members]
    assert judged == [True, False, False, False, True, False]
    predicates = "".join(member.monitor.predicate for member in team.members)
    assert predicates == "0XXX0X"


def test_it_stops_at_what_is_not_finite_and_goes_on_after_it(
    team: Team, rng: np.random.Generator
) -> None:
    for member, (_, controller) in zip(team.members, MEMBERS, strict=True):
        feel(member, next(readings(controller, rng)), drawn(controller, rng), 0)
    team.members[2].jacobian[:] = np.nan
    assert team.act(np.zeros(JOINTS)) == 2
    assert team.stack.ages.tolist() == [1, 1, 0, 0, 0, 0]
    assert team.act(np.zeros(JOINTS), first=3) == len(MEMBERS)
    assert team.stack.ages.tolist() == [1, 1, 0, 1, 1, 1]


def test_who_follows_joints_reads_them_itself(team: Team, rng: np.random.Generator) -> None:
    place = 2  # a spring of a configuration
    member, positions, reference = team.members[place], rng.normal(size=JOINTS), rng.normal(size=3)
    member.aim(Reading(reference, np.zeros((0, 0)), 0))
    member.follow_joints(np.array([4, 0, 8]))
    member.duty = FOLLOW
    team.columns[place] = [8, 4, 1, 0, -1]
    team.act(positions)
    residual = reference - positions[[4, 0, 8]]
    assert member.outcome[ERROR] == pytest.approx(np.linalg.norm(residual))
    (level,) = team.stack.midway()
    np.testing.assert_array_equal(level.jacobian, np.eye(5)[[1, 3, 0]])


def test_gathered_they_remember_what_they_knew(team: Team, rng: np.random.Generator) -> None:
    for member, (_, controller) in zip(team.members, MEMBERS, strict=True):
        feel(member, next(readings(controller, rng)), drawn(controller, rng), 0)
    team.act(np.zeros(JOINTS))
    arrays = ("plan", "constants", "value", "reference", "jacobian", "outcome")
    before = [[getattr(each, name).copy() for name in arrays] for each in team.members]
    rates = [member.task.before.copy() for member in team.members]
    gather(team.members)
    for member, kept, rate in zip(team.members, before, rates, strict=True):
        for name, array in zip(arrays, kept, strict=True):
            np.testing.assert_array_equal(getattr(member, name), array)
        np.testing.assert_array_equal(member.task.before, rate)
        assert np.shares_memory(member.task.before, team.members[0].task.before.base)


@pytest.mark.parametrize("rows", [2, 4])
def test_what_is_misshapen_does_not_fit(team: Team, rows: int) -> None:
    member = team.members[0]
    assert not member.aim(Reading(np.zeros(rows), np.zeros((0, 0)), 0))
    assert not member.feel(Reading(np.zeros(rows), np.zeros((3, JOINTS)), 0), 0, 0.0)
    assert not member.feel(Reading(np.zeros(3), np.zeros((rows, JOINTS)), 0), 0, 0.0)
