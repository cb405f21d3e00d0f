"""Setup: every shipped stage as instructions for a person."""

from __future__ import annotations

import pytest

from cbdsl.documents.stage import StageDocument
from cbdsl_drive.setup import describe_setup
from tests.backends.conftest import LIBRARY, robot_named, stage_named


@pytest.mark.parametrize("name", LIBRARY.names(StageDocument))
def test_setup_of_a_shipped_stage_names_all_that_is_shown(name: str) -> None:
    stage = stage_named(name)
    robot = robot_named(stage.robot)
    for context, shown in stage.contexts.items():
        text = describe_setup(stage, context, robot)
        assert all(f"'{fixture}'" in text for fixture in stage.fixtures)
        things = {thing for each in shown.presentations.values() for thing in each.things}
        placed = [each for each in shown.presentations.values() if each.place is not None]
        assert not placed or all(f"'{thing}'" in text for thing in things)
        assert text.splitlines()[0].startswith(f"stage '{name}', context '{context}'")


def test_setup_states_places_in_centimetres() -> None:
    text = describe_setup(stage_named("table_right"), "in_view", robot_named("dexter"))
    assert " cm" in text
