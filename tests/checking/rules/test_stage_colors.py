"""Notes on channels of a program that no object of its stage has."""

from __future__ import annotations

import pytest

from cbdsl.checking.rules.stage_colors import absent_channels
from cbdsl.documents.robot import RobotDocument
from tests.backends.conftest import stage_named
from tests.conftest import Checked


@pytest.mark.parametrize(
    ("program", "feature", "stage", "absent"),
    [
        ("reachtouch", "red", "table_right", ()),
        ("reachtouch", "hue_6", "table_right", ("hue_6",)),
        ("searchtrack", "yellow", "furnished", ()),  # a fixture
        ("searchtrack", "blue", "spotted_right", ()),  # a spot
        ("searchtrack", "yellow", "spotted_right", ("yellow",)),  # brown table, orange things
        ("searchtrack", "motion", "table_right", ()),
        ("searchtrack", "int_3", "table_right", ()),
        ("searchtrack", "yellow", "absent", ()),  # a stage without objects
    ],
)
def test_absent_channels_are_those_of_no_thing_spot_or_fixture(
    program: str,
    feature: str,
    stage: str,
    absent: tuple[str, ...],
    checked: Checked,
    dexter: RobotDocument,
) -> None:
    found = absent_channels(
        checked(program, feature=feature), stage_named(stage), dexter.vision.channels
    )
    assert found == absent
