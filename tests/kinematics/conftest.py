"""Postures all over the joint ranges, and randomness with one seed, so that a failure repeats."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats


@pytest.fixture(params=range(3))
def posture(kinematics: Kinematics, request: pytest.FixtureRequest) -> Floats:
    rng = np.random.default_rng(request.param)
    return rng.uniform(kinematics.lower, kinematics.upper)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)
