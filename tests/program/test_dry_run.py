"""Reports about programs before they run."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.checking.program import check_program
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.dry_run import controllers, coverage, levels, resources, rewarding, rows
from cbdsl.runtime.policies.policy import WrittenPolicy
from cbdsl.types.resource import Origin
from cbdsl.yaml_text.library import Library, shipped

PROGRAMS = Library(shipped()).names(ProgramDocument)


@cache
def program_of(name: str) -> CheckedProgram:
    return check_program(name, {}, Library(shipped()))


@pytest.mark.parametrize("name", PROGRAMS)
def test_stated_freedom_equals_the_null_space_of_random_rows(name: str) -> None:
    """Compare the stated freedom with the null space of random rows above, in a level's joints."""
    program = program_of(name)
    rng = np.random.default_rng(0)
    for action in program.actions:
        stack = levels(program, action)
        joints = sorted({joint for level in stack for joint in level.controller.joints})
        above = np.zeros((0, len(joints)))
        for level in stack:
            own = [joint in level.controller.joints for joint in joints]
            left = sum(own) - np.linalg.matrix_rank(above[:, own]) if len(above) else sum(own)
            assert level.free <= left
            task = rng.normal(size=(level.rows, len(joints))) * own
            above = np.vstack((above, task))
            if all(set(c.controller.joints) == set(stack[0].controller.joints) for c in stack):
                assert level.free == left


@pytest.mark.parametrize("name", PROGRAMS)
def test_stacks_resources_and_rewards(name: str) -> None:
    program = program_of(name)
    known = controllers(program)
    assert len(set(known)) == len(known)
    bound = {resource.name for resource in resources(program)}
    assert bound >= {controller.feedback.name for controller in known}
    for action in program.actions:
        stack = levels(program, action)
        assert len({level.controller for level in stack}) == len(stack)
        assert sorted(level.background for level in stack) == [level.background for level in stack]
        if action.composition is not None:
            first = stack[0]
            assert first.controller == action.composition.primitives[-1].lead
            assert first.free == len(first.controller.joints)
            feedbacks = {c.name: c.feedback.origin for c in known}
            primitives = {p.name: p for p in action.composition.primitives}
            earners = [each for name in rewarding(action) for each in primitives[name].earners]
            assert all(feedbacks[each.name] is Origin.ENVIRONMENT for each in earners)


def test_free_axis_frees_a_row() -> None:
    named = {controller.name: controller for controller in controllers(program_of("reachtouch"))}
    assert {name: rows(named[name]) for name in ("approach", "orient", "posture", "touch")} == {
        "approach": 3,
        "orient": 2,
        "posture": 7,
        "touch": 3,  # one force along the normal of each finger
    }


def test_program_is_rewarding_if_an_action_is() -> None:
    program = program_of("reachtouch")
    earning = {action.name: rewarding(action) for action in program.actions}
    assert earning["searchtrack"] == ("searchtrack",) and earning["reach"] == ()


@given(st.lists(st.text("X-01*", min_size=3, max_size=3), max_size=8, unique=True))
def test_coverage_counts_the_states_of_each_action(patterns: list[str]) -> None:
    program = program_of_policy({pattern: pattern for pattern in patterns})
    policy = WrittenPolicy(program.policy)
    chosen = [
        policy.choose("".join(letters), changed=True).action
        for letters in itertools.product("X-01", repeat=3)
    ]
    shares = coverage(program)
    assert shares.states == 64 and shares.undecided == chosen.count(None)
    assert shares.decided == {pattern: chosen.count(pattern) for pattern in patterns}


def program_of_policy(policy: dict[str, str]) -> CheckedProgram:
    """Return a program of three members with nothing in it but a policy."""
    return CheckedProgram("p", "r", None, {}, ("a", "b", "c"), {}, (), policy, None, 1, 1.0, None)
