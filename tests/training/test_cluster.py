"""Trials side by side: the same outcome as one after the other, whoever dies on the way."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.checking.digest import program_digest
from cbdsl.checking.program import check_program
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.accommodate import Constants
from cbdsl.robot.kinematics import Kinematics
from cbdsl.training.assignment import Assignment
from cbdsl.training.course import journal_file
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

pytest.importorskip("distributed", reason="many trials at once need the extra 'learn'")

TRIALS = 3


@pytest.fixture
def assignments(dexter: RobotDocument, urdf: Path, tmp_path: Path) -> list[Assignment]:
    library = Library(ROOT)
    stage = library.locate(StageDocument, "searchtrack_training")
    first = Assignment(
        program=check_program("searchtrack", {}, library),
        program_sha256=program_digest(library.locate(ProgramDocument, "searchtrack"), library),
        robot=dexter,
        urdf=urdf,
        stage=library.read(stage, StageDocument).document,
        backend="bullet",
        constants=Constants(),
        seed=4,
        number=0,
        episodes=4,
        command="cb learn searchtrack",
        path=tmp_path / "policy.yaml",
    )
    paths = (tmp_path / f"policy_{n}.yaml" for n in range(TRIALS))
    return [replace(first, number=n, path=path) for n, path in enumerate(paths)]


def learned_alone(assignments: list[Assignment], folder: Path, body: BulletBackend) -> list[bytes]:
    folder.mkdir()
    for each in assignments:
        moved = replace(each, path=folder / each.path.name)
        moved.carry_out(body, Kinematics(each.robot, each.urdf))
    return [(folder / each.path.name).read_bytes() for each in assignments]


@pytest.mark.slow
def test_killed_workers_lose_no_trial_and_change_nothing(
    assignments: list[Assignment], tmp_path: Path, bullet: BulletBackend
) -> None:
    import psutil

    from cbdsl.training.cluster import carry_out_all

    done: list[list[Path]] = []
    course = threading.Thread(
        target=carry_out_all, args=(assignments, 2, None, done.append), daemon=True
    )
    course.start()
    journal = journal_file(assignments[0].path)
    while not (journal.exists() and journal.read_bytes().count(b"\n") >= 2):
        assert course.is_alive()
        time.sleep(0.05)
    workers = [
        each
        for each in psutil.Process().children(recursive=True)
        if not each.children() and any("spawn_main" in word for word in each.cmdline())
    ]
    for worker in workers:
        worker.kill()
    course.join(timeout=600)
    assert workers and len(done) == TRIALS
    expected = learned_alone(assignments, tmp_path / "alone", bullet)
    assert [each.path.read_bytes() for each in assignments] == expected
