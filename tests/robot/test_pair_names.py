"""Names of signals of two channels."""

from __future__ import annotations

import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.pair_names import pair_resource
from cbdsl.robot.resources import resources
from cbdsl.types.resource import SolidSignal
from cbdsl.types.resource_type import ORIENTATION


@pytest.mark.parametrize("arm", ["left_arm", "right_arm"])
def test_pair_name_beside_of_an_arm_is_an_orientation(arm: str, dexter: RobotDocument) -> None:
    found = pair_resource(f"stereo.red.on.green.beside.{arm}", resources(dexter))
    assert found is not None and found.type == ORIENTATION
    red, green = (resources(dexter)[f"stereo.{name}"].source for name in ("red", "green"))
    assert isinstance(found.source, SolidSignal)
    assert (found.source.channel, found.source.other) == (red.channel, green.channel)  # type: ignore[union-attr]
    assert (found.source.part, found.source.effector) == ("beside", arm)


@pytest.mark.parametrize(
    "name",
    [
        "stereo.red.on.green.beside",
        "stereo.red.on.green.beside.right_hand",
        "stereo.red.on.green.beside.arms",
        "stereo.red.on.green.beside.nothing",
        "stereo.red.on.green.above.right_arm",
        "left.red.on.green.beside.right_arm",
    ],
)
def test_pair_name_beside_of_no_arm_is_unknown(name: str, dexter: RobotDocument) -> None:
    assert pair_resource(name, resources(dexter)) is None
