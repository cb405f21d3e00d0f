"""Strain is the torque of drives beyond the weight of the links, low-pass filtered."""

from __future__ import annotations

from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest

from cbdsl.documents.robot import JointTorques
from cbdsl.sensing.touch.touch import Strain

WEIGHT = np.array([3.0, -1.0])


def strain(filter_: float | None) -> Strain:
    kinematics: Any = Made(joints=("a", "b"), weight=lambda: WEIGHT)
    settings = None if filter_ is None else JointTorques.model_construct(filter=filter_)
    made = Strain(settings, kinematics)
    made.needed = True
    return made


def seen(time: float, *efforts: float) -> Any:
    return Made(time=time, efforts=np.array(efforts) if efforts else None)


def test_strain_is_filtered_with_its_time_constant() -> None:
    felt = strain(0.5)
    felt.update(seen(2.0, 9.0, 9.0))
    assert not felt.torques.any(), "before the first step no drive has exerted anything"
    felt.update(seen(2.25, 5.0, -1.0))
    share = 1 - np.exp(-0.5)
    assert felt.torques == pytest.approx([2.0 * share, 0.0])
    felt.update(seen(3.25, 5.0, 3.0))
    rest = np.exp(-2.0)
    assert felt.torques == pytest.approx([2 - (2 - 2.0 * share) * rest, 4 * (1 - rest)])
    felt.update(seen(3.25, 99.0, 99.0))
    assert felt.torques[0] < 2.0, "at the same time nothing new was measured"


def test_strain_without_a_filter_is_the_current_measurement() -> None:
    felt = strain(0.0)
    for time in (0.0, 0.1):
        felt.update(seen(time, 5.0, 3.0))
    assert felt.torques == pytest.approx([2.0, 4.0])
    felt.reset()
    assert not felt.torques.any()
    felt.update(seen(0.2, 5.0, 3.0))
    assert not felt.torques.any()


@pytest.mark.parametrize("why", ["unneeded", "no such drives", "nothing measured"])
def test_strain_without_a_request_or_a_measurement_is_zero(why: str) -> None:
    felt = strain(None if why == "no such drives" else 0.0)
    felt.needed = why != "unneeded"
    for time in (0.0, 0.1):
        felt.update(seen(time) if why == "nothing measured" else seen(time, 5.0, 3.0))
    assert not felt.torques.any()


def test_strain_is_not_needed_initially() -> None:
    assert not Strain(None, Made(joints=("a",))).needed  # type: ignore[arg-type]
