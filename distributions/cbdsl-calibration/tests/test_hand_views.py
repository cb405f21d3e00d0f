"""Journals of calibrations: measured views survive, and other files are rejected."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.storage.journal import Journal, JournalError
from cbdsl.yaml_text.library import Library
from cbdsl_calibration.hand_view import HandView
from cbdsl_calibration.hand_views import HAND_VIEWS, HandViews
from cbdsl_calibration.watching import watch
from tests.conftest import Checked

IDENTITY = {"command": "cb calibrate dexter", "robot": {"name": "dexter", "sha256": "1"}}


def view(number: int) -> HandView:
    rng = np.random.default_rng(number)
    shapes = [(3,), (3, 3), (2,)]
    position, rotation, point = (rng.standard_normal(shape) for shape in shapes)
    tips = rng.standard_normal((3, 3))
    return HandView("left", position, rotation, point, float(number), tips, number % 2)


def test_views_are_the_same_after_a_crash(tmp_path: Path) -> None:
    file = tmp_path / "mine.jsonl"
    with Journal(file, IDENTITY, HAND_VIEWS) as journal:
        journal.append(HandViews(0, [view(0), view(2)]))
        journal.append(HandViews(0, []))
    file.write_bytes(file.read_bytes() + b'{"hold": 0, "vie')
    with Journal(file, IDENTITY, HAND_VIEWS) as journal:
        assert [row.hold for row in journal.rows] == [0, 0]
        for kept, was in zip(journal.rows[0].views, (view(0), view(2)), strict=True):
            assert all(map(np.array_equal, kept, was))
        journal.append(HandViews(1, [view(1)]))
    with Journal(file, IDENTITY, HAND_VIEWS) as journal:
        assert [(row.hold, len(row.views)) for row in journal.rows] == [(0, 2), (0, 0), (1, 1)]


def test_another_calibration_does_not_go_on(tmp_path: Path) -> None:
    file = tmp_path / "mine.jsonl"
    with Journal(file, IDENTITY, HAND_VIEWS) as journal:
        journal.append(HandViews(0, [view(0)]))
    changed = IDENTITY | {"robot": {"name": "dexter", "sha256": "2"}}
    with pytest.raises(JournalError, match="another calibration: robot 'dexter' has changed since"):
        Journal(file, changed, HAND_VIEWS)


@pytest.mark.parametrize(
    "line", ['{"hold": 0}', '{"hold": 0, "views": [{"camera": "left"}]}', "[]", "nonsense"]
)
def test_damaged_journal_is_reported_with_its_line(tmp_path: Path, line: str) -> None:
    file = tmp_path / "mine.jsonl"
    with Journal(file, IDENTITY, HAND_VIEWS) as journal:
        journal.append(HandViews(0, [view(0)]))
    file.write_text(file.read_text() + line + "\n")
    with pytest.raises(JournalError, match=r"mine.jsonl, line 3: .*the same command goes on there"):
        Journal(file, IDENTITY, HAND_VIEWS)


class _KilledError(Exception):
    """The process ends here."""


def test_interrupted_watch_goes_on_with_another_hold(
    checked: Checked, dexter: RobotDocument, urdf: Path, library: Library, tmp_path: Path
) -> None:
    program = checked("show_ball")._replace(transitions=12)
    file = library.locate(StageDocument, "ball_in_hand")
    stage = library.read(file, StageDocument).document
    backend, told = embody("kinematic", dexter, urdf), []

    def interrupt(done: int, _: int) -> None:
        told.append(done)
        if done == 7:
            raise _KilledError

    def run() -> list[HandView]:
        kinematics = Kinematics(dexter, urdf)
        with Journal(tmp_path / "mine.jsonl", IDENTITY, HAND_VIEWS) as journal:
            return watch(dexter, kinematics, program, backend, stage, 3, interrupt, journal)

    with pytest.raises(_KilledError):
        run()
    before = (tmp_path / "mine.jsonl").read_bytes()
    views = run()
    assert told == list(range(1, 13))
    assert {each.hold for each in views} == {0, 1}
    assert (tmp_path / "mine.jsonl").read_bytes().startswith(before)
    assert len(run()) == len(views), "nothing is left to watch"
    backend.close()
