"""Environment of Gymnasium: the checker of Gymnasium passes, and a step is an action."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import cbdsl

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402

from cbdsl_gym import ID, LETTERS, ProgramEnvironment  # noqa: E402


@pytest.fixture(scope="module")
def environment() -> Iterator[ProgramEnvironment]:
    made = ProgramEnvironment("searchtrack")
    yield made
    made.close()


@pytest.mark.filterwarnings("error")
def test_gymnasium_finds_nothing_wrong(environment: ProgramEnvironment) -> None:
    check_env(environment, skip_render_check=True)


def test_step_runs_an_action_until_the_state_changes(environment: ProgramEnvironment) -> None:
    """Reach the reward with the same actions as the program's own policy."""
    request = cbdsl.load("searchtrack")
    states, info = environment.reset(seed=4)
    assert info["state"] == "XX" and list(states) == [0, 0] and info["time"] == 0.0
    table = request.program.policy
    total = 0.0
    for _ in range(20):
        name = next(a for pattern, a in table.items() if _matches(pattern, info["state"]))
        number = environment.actions.index(name)
        states, reward, terminated, truncated, info = environment.step(np.int64(number))
        assert [LETTERS[each] for each in states] == list(info["state"])
        total += reward
        if terminated or truncated:
            break
    assert terminated and not truncated and total == 1.0
    assert info["time"] > 0.3
    with pytest.raises(gymnasium.error.ResetNeeded):
        environment.step(np.int64(0))


def test_actions_matter_and_limits_truncate() -> None:
    request = cbdsl.load("searchtrack")
    short = request.program._replace(transitions=3)
    environment = ProgramEnvironment(_with(request, short))
    try:
        environment.reset(seed=1)
        search = environment.actions.index("search")
        outcomes = [environment.step(np.int64(search)) for _ in range(3)]
        assert [reward for _, reward, *_ in outcomes] == [0.0, 0.0, 0.0]
        assert [truncated for *_, truncated, _ in outcomes] == [False, False, True]
    finally:
        environment.close()


def test_equal_seeds_and_actions_give_equal_episodes(environment: ProgramEnvironment) -> None:
    def episode(seed: int) -> list[tuple[str, float]]:
        rng = np.random.default_rng(0)
        _, info = environment.reset(seed=seed)
        passed = [(info["state"], 0.0)]
        for _ in range(6):
            *_, terminated, truncated, info = environment.step(
                np.int64(rng.integers(len(environment.actions)))
            )
            passed.append((info["state"], info["time"]))
            if terminated or truncated:
                break
        return passed

    assert episode(8) == episode(8) != episode(9)


@pytest.mark.filterwarnings("error")
def test_make_knows_the_environment_by_its_id() -> None:
    made = gymnasium.make(f"cbdsl_gym:{ID}", program="searchtrack")
    assert isinstance(made.unwrapped, ProgramEnvironment)
    check_env(made.unwrapped, skip_render_check=True)
    first, _ = made.reset(seed=4)
    again, _ = gymnasium.make(ID, program="searchtrack").reset(seed=4)
    assert list(first) == list(again)
    made.close()


def test_state_of_success_is_paid_and_one_of_failure_is_not() -> None:
    request = cbdsl.load("posture", stage="absent")
    for pattern, paid in (("success", 1.0), ("failure", 0.0)):
        program = request.program._replace(**{pattern: ("1",)})
        environment = ProgramEnvironment(_with(request, program))
        environment.reset(seed=1)
        passed = [environment.step(np.int64(0)) for _ in range(2)]
        assert [reward for _, reward, *_ in passed] == [0.0, paid]
        assert [terminated for _, _, terminated, *_ in passed] == [False, True]
        environment.close()


def test_success_that_is_rewarded_is_paid_once() -> None:
    request = cbdsl.load("searchtrack")
    program = request.program._replace(success=("*1",))
    environment = ProgramEnvironment(_with(request, program))
    environment.reset(seed=4)
    action = np.int64(environment.actions.index("search ◁ track"))
    total, terminated = 0.0, False
    while not terminated:
        _, reward, terminated, truncated, _ = environment.step(action)
        assert not truncated
        total += reward
    assert total == 1.0
    environment.close()


def test_closed_environment_and_an_unknown_action_are_reported() -> None:
    environment = ProgramEnvironment("searchtrack")
    environment.reset(seed=1)
    for action in (-1, len(environment.actions)):
        with pytest.raises(gymnasium.error.InvalidAction, match="known: 0 to 3"):
            environment.step(np.int64(action))
    environment.close()
    environment.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        environment.reset(seed=1)
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        environment.step(np.int64(0))


def _with(request: cbdsl.RunRequest, program: object) -> cbdsl.RunRequest:
    from dataclasses import replace

    return replace(request, program=program)


def _matches(pattern: str, state: str) -> bool:
    return all(letter in ("*", own) for letter, own in zip(pattern, state, strict=True))
