"""Consent of the operator at the terminal: given at a prompt or in advance."""

from __future__ import annotations

import io
import sys

import pytest

from cbdsl.api.load import load
from cbdsl.cli.episodes.attendance import TerminalPerson, attend
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from tests.backends.conftest import URDF, sightless


def test_consent_in_advance_confirms_the_set_up_stage() -> None:
    assert TerminalPerson(yes=True).confirm("", "is this set up", released=True)


@pytest.mark.parametrize(("yes", "released"), [(False, True), (True, False), (False, False)])
def test_question_without_a_terminal_is_refused(
    yes: bool, released: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO("y\n"))
    with pytest.raises(UsageError, match="no terminal to answer at"):
        TerminalPerson(yes=yes).confirm("", "release it", released=released)


@pytest.mark.parametrize(("answer", "agreed"), [("y\n", True), ("n\n", False)])
def test_question_at_a_terminal_shows_the_situation(
    answer: str,
    agreed: bool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    terminal = io.StringIO(answer)
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stdin", terminal)
    person = TerminalPerson(yes=False)
    assert person.confirm("stage 'bare'", "is this set up", released=True) is agreed
    told = capsys.readouterr().err
    assert "stage 'bare'" in told
    assert "Is this set up" in told


@pytest.mark.parametrize(("yes", "interface"), [(True, None), (False, "eth0")])
def test_options_of_real_robots_are_refused_in_simulation(
    yes: bool, interface: str | None, dexter: RobotDocument
) -> None:
    from cbdsl.backends.backend import embody

    simulated = embody("kinematic", sightless(dexter), URDF)
    request, kinematics = load("posture"), Kinematics(dexter, URDF)
    with pytest.raises(UsageError, match="is for a real robot"):
        attend(simulated, kinematics, request, yes=yes, interface=interface)
    attend(simulated, kinematics, request, yes=False, interface=None)
    simulated.close()
