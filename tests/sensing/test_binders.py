"""Binders: one for each type of source that is measured or computed."""

from __future__ import annotations

from typing import get_args

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import (
    GaussianSample,
    KernelSample,
    Source,
    SurfacePoint,
    UniformSample,
)

#: Types of sources whose values are drawn when a controller begins, by ``Signals.sampler``.
DRAWN = {UniformSample, GaussianSample, KernelSample, SurfacePoint}


def test_binders_exist_for_all_sources_but_the_drawn_ones(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    binders = Signals(dexter, kinematics, ())._binders
    assert set(binders._by_type) == set(get_args(Source)) - DRAWN
