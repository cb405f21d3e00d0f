"""Postures all over the joint ranges."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cbdsl.kinematics.kinematics import Kinematics


@pytest.fixture(params=range(3))
def posture(kinematics: Kinematics, request: pytest.FixtureRequest) -> NDArray[np.float64]:
    rng = np.random.default_rng(request.param)
    return rng.uniform(kinematics.lower, kinematics.upper)
