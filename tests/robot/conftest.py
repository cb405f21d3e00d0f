from pathlib import Path

import numpy as np
import pytest
from cbdsl.yaml_text.library import Library

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.kinematics import Kinematics

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def dexter() -> RobotDocument:
    document = Library().load("robot", "dexter").document
    assert isinstance(document, RobotDocument)
    return document


@pytest.fixture(scope="session")
def kinematics(dexter: RobotDocument) -> Kinematics:
    return Kinematics(dexter, ROOT / "robots" / dexter.model)


@pytest.fixture(params=range(3))
def posture(kinematics: Kinematics, request: pytest.FixtureRequest) -> np.ndarray:
    rng = np.random.default_rng(request.param)
    return rng.uniform(kinematics.lower, kinematics.upper)
