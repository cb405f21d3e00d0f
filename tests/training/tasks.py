"""Learning tasks on the kinematic backend, which are over soon; and their documents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from cbdsl.backends.backend import find_backend
from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.program import check_program
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.training.learning_task import LearningTask
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT


def made_tasks(folder: Path, trials: int, episodes: int) -> list[LearningTask]:
    """Return trials of SEARCHTRACK whose policies go to a folder."""
    library = Library(ROOT)
    robot = library.locate(RobotDocument, "dexter")
    stage = library.locate(StageDocument, "searchtrack_training")
    document = library.read(robot, RobotDocument).document
    first = LearningTask(
        program=check_program("searchtrack", {}, library),
        digest=program_digest(library.locate(ProgramDocument, "searchtrack"), library),
        robot=document,
        urdf=robot.parent / document.model,
        stage=library.read(stage, StageDocument).document,
        backend="kinematic",
        learner="accommodate",
        constants=AccommodateConstants(),
        seed=4,
        number=0,
        episodes=episodes,
        command="cb learn searchtrack",
        path=folder / "policy.yaml",
    )
    paths = (folder / f"policy_{number}.yaml" for number in range(trials))
    return [replace(first, number=number, path=path) for number, path in enumerate(paths)]


def run_here(tasks: Sequence[LearningTask]) -> None:
    """Carry out trials in this process, one after the other, on the same body."""
    first = tasks[0]
    body = find_backend(first.backend)(first.robot, first.urdf)
    for each in tasks:
        each.run(body, Kinematics(each.robot, each.urdf))
    body.close()


def outcome(folder: Path) -> dict[str, bytes]:
    """Return the documents in a folder, by name."""
    return {file.name: file.read_bytes() for file in sorted(folder.glob("*.yaml"))}
