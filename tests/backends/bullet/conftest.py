"""Dexter in PyBullet, and stages made for tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[3]
URDF = ROOT / "robots" / "dexter.urdf"
LIBRARY = Library(ROOT)


def stage_named(name: str) -> StageDocument:
    return LIBRARY.read(LIBRARY.locate(StageDocument, name), StageDocument).document


def made_stage(context: dict[str, Any], **parts: Any) -> StageDocument:
    """A stage with one context, ``only``."""
    head = {"cbdsl": 1, "kind": "stage", "name": "made", "robot": "dexter"}
    return StageDocument.model_validate({**head, "contexts": {"only": context}, **parts})


def with_vision(robot: RobotDocument, **changes: Any) -> RobotDocument:
    return robot.model_copy(update={"vision": robot.vision.model_copy(update=changes)})


@pytest.fixture(scope="session")
def dexter() -> RobotDocument:
    return LIBRARY.read(LIBRARY.locate(RobotDocument, "dexter"), RobotDocument).document


@pytest.fixture(scope="session")
def backend(dexter: RobotDocument) -> Iterator[BulletBackend]:
    """A backend with whatever renderer works here."""
    backend = BulletBackend(dexter, URDF)
    yield backend
    backend.close()


@pytest.fixture(scope="session")
def blind(dexter: RobotDocument) -> Iterator[BulletBackend]:
    """A backend that spends no time on images, with load cells that have no noise."""
    quiet = dexter.model_copy(
        update={"cameras": {}, "contact": dexter.contact.model_copy(update={"noise": 0.0})}
    )
    backend = BulletBackend(with_vision(quiet, renderer="tiny"), URDF)
    yield backend
    backend.close()
