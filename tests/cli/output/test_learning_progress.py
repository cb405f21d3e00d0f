"""Progress lines of a trial while it runs."""

from __future__ import annotations

import io
import sys
from dataclasses import replace

import pytest

from cbdsl.cli.output.learning_progress import LearningProgress
from tests.training.toy import ToyEpisodeRunner, toy_trial

EPISODES = 14


class Terminal(io.StringIO):
    """Standard output that is a terminal."""

    def isatty(self) -> bool:
        return True


def watched(*, trials: int = 1) -> None:
    """Run trials whose later episodes take half a minute each, and report their progress."""
    with LearningProgress("searchtrack", trials, EPISODES) as progress:
        for number in range(trials):
            trial, runner = toy_trial(), ToyEpisodeRunner()
            trial.run(runner)
            progress.begin(number, "nothing", trial.experiences)
            while len(trial.experiences) < EPISODES:
                progress.note(number, replace(trial.run(runner), wall_seconds=30.0))


def test_progress_lines_state_episodes_rewards_and_remaining_time(
    capsys: pytest.CaptureFixture[str],
) -> None:
    watched()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "searchtrack; images by nothing"
    assert lines[1] == "1 of 14 episodes are over"
    assert lines[2].startswith("episode 2 of 14: ") and "reward 1 in " in lines[2]
    assert lines[2].endswith("about 6 min 00 s left")
    assert lines[-1].startswith("episode 14 of 14: ") and "last 10: 10 rewarded" in lines[-1]
    assert "left" not in lines[-1]


def test_progress_lines_of_several_trials_name_the_trial_and_the_total_time(
    capsys: pytest.CaptureFixture[str],
) -> None:
    watched(trials=3)
    lines = capsys.readouterr().out.splitlines()
    assert sum("images by" in line for line in lines) == 1
    assert lines[1] == "trial 0: 1 of 14 episodes are over"
    assert lines[2].startswith("trial 0, episode 2 of 14: ")
    assert lines[2].endswith("2 of 42 in all; about 20 min 00 s left")
    assert lines[-1].startswith("trial 2, episode 14 of 14: ")
    assert lines[-1].endswith("42 of 42 in all")


def test_remaining_time_of_parallel_trials_is_divided_by_their_number(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with LearningProgress("searchtrack", trials=8, episodes=10, at_once=4) as progress:
        progress.begin(2, "nothing", [])
        progress.note(2, replace(toy_trial().run(ToyEpisodeRunner()), wall_seconds=12.0))
    assert capsys.readouterr().out.splitlines()[-1].endswith("about 3 min 57 s left")


@pytest.mark.parametrize("trials", [1, 30])
def test_progress_on_a_terminal_is_one_line(monkeypatch: pytest.MonkeyPatch, trials: int) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stdout", terminal)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    watched(trials=trials)
    last = terminal.getvalue().split("\r")[-1]
    total = trials * EPISODES
    assert f"{total}/{total}" in last and "last 10: 10 rewarded" in last
    assert "per transition" in last
