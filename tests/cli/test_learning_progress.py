"""What people see of a trial while it runs."""

from __future__ import annotations

import io
import sys

import pytest

from cbdsl.cli.learning_progress import LearningProgress
from tests.training.toy import ToyClassroom, toy_provenance, toy_trial

EPISODES = 14


class Terminal(io.StringIO):
    """A standard output that is a terminal."""

    def isatty(self) -> bool:
        return True


def watched() -> None:
    trial, classroom = toy_trial(), ToyClassroom()
    trial.run(classroom)
    with LearningProgress() as progress:
        progress.begin(trial, toy_provenance(trial, EPISODES))
        while len(trial.experiences) < EPISODES:
            trial.run(classroom)
            progress.note(trial, 30.0)


def test_lines_say_what_was_how_it_goes_and_how_long_it_takes(
    capsys: pytest.CaptureFixture[str],
) -> None:
    watched()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("searchtrack on searchtrack_training, seed 1")
    assert lines[1] == "1 of 14 episodes are over"
    assert lines[2].startswith("episode 2 of 14: ") and "reward 1 in " in lines[2]
    assert lines[2].endswith("about 6 min 00 s left")
    assert lines[-1].startswith("episode 14 of 14: ") and "last 10: 10 rewarded" in lines[-1]
    assert "left" not in lines[-1]


def test_a_terminal_shows_all_of_it_on_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stdout", terminal)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    watched()
    last = terminal.getvalue().split("\r")[-1]
    assert "14/14" in last and "last 10: 10 rewarded" in last and "per transition" in last
