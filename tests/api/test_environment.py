"""Environment of Gymnasium: the checker of Gymnasium passes, and a step is an action."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import cbdsl

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402

from cbdsl.api.environment import LETTERS, ProgramEnvironment  # noqa: E402


@pytest.fixture(scope="module")
def environment() -> Iterator[ProgramEnvironment]:
    made = ProgramEnvironment("searchtrack")
    yield made
    made.close()


@pytest.mark.filterwarnings("error")
def test_gymnasium_finds_nothing_wrong(environment: ProgramEnvironment) -> None:
    check_env(environment, skip_render_check=True)


def test_a_step_runs_an_action_until_the_state_changes(environment: ProgramEnvironment) -> None:
    """The same actions as the program's own policy lead to the reward."""
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


def _with(request: cbdsl.RunRequest, program: object) -> cbdsl.RunRequest:
    from dataclasses import replace

    return replace(request, program=program)


def _matches(pattern: str, state: str) -> bool:
    return all(letter in ("*", own) for letter, own in zip(pattern, state, strict=True))
