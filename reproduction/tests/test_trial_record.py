"""Records: kept to the byte, read back, and refused if they are of another kind."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from cbdsl.learning.allocation_tree import TriedContext
from cbdsl_reproduction.affordance_trials import AffordanceTrial
from cbdsl_reproduction.chapter_5.motion_episodes import MotionEpisode
from cbdsl_reproduction.chapter_5.schema_trees import AssimilationTrial
from cbdsl_reproduction.chapter_5.touch_trials import TouchTrial
from cbdsl_reproduction.constellation_trials import ConstellationTrial
from cbdsl_reproduction.growing_stack_trials import GrowingStack
from cbdsl_reproduction.impedance_trials import ImpedanceTrial
from cbdsl_reproduction.stack_trials import StackTrial
from cbdsl_reproduction.trial_record import plain_data, read_record

# Rows as they stand in kept files.
ROWS: dict[type[Any], str] = {
    AffordanceTrial: '{"things": "place:football", "seed": 3, "rewarded": true, '
    '"ending": "At rest."}',
    ConstellationTrial: '{"things": "a_on_b", "seed": 3, "judged": true, "stands": false, '
    '"before": {"offset": [0.25, -0.5]}, "after": {}, "ending": "At rest."}',
    GrowingStack: '{"things": "a_b_c", "seed": 3, "tracked": false, "stands": true, '
    '"views": [{"a": [0.1, 0.2]}, {}], "ending": "At rest."}',
    ImpedanceTrial: '{"things": "box_on_box", "seed": 1, "profile": [{"direction": "dPz", '
    '"sign": -1, "displacement": -0.002, "load": -2.0, "tracked": true, "residue": 0.0, '
    '"resistance": -1.0}], "ending": "Succeeded", "sim_seconds": 60.0}',
    MotionEpisode: '{"things": "nothing", "seed": 1, "posture": [], "off": NaN, "ending": ""}',
    StackTrial: '{"things": "a_on_b", "seed": 2, "released": false, "stands": false, '
    '"offset": NaN, "pace": NaN, "seconds": 0.0, "ending": ""}',
    TouchTrial: '{"things": "bimanual", "seed": 5, "place": [0.5, 0.1, 0.8]}',
    AssimilationTrial: '{"things": "reachtouch", "seed": 0, "tried": [{"features": {"x": 0.5}, '
    '"outcomes": {"left_arm": false}, "counts": true}]}',
}


@pytest.mark.parametrize("kind", ROWS, ids=lambda kind: str(kind.__name__))
def test_kept_line_is_read_and_written_again_to_the_byte(kind: type[Any]) -> None:
    record = read_record(kind, json.loads(ROWS[kind]))
    assert isinstance(record, kind)
    assert json.dumps(plain_data(record)) == ROWS[kind]


@pytest.mark.parametrize("kind", ROWS, ids=lambda kind: str(kind.__name__))
def test_record_with_missing_or_unknown_fields_is_none(kind: type[Any]) -> None:
    data = json.loads(ROWS[kind])
    for other in ({**data, "pace_2": 0.0}, {k: v for k, v in data.items() if k != "seed"}, [data]):
        with pytest.raises(ValueError, match=f"^no {kind.__name__}: "):
            read_record(kind, other)


def test_read_fields_have_the_declared_types() -> None:
    stack = read_record(GrowingStack, json.loads(ROWS[GrowingStack]))
    assert stack.views == ({"a": (0.1, 0.2)}, {})
    (tried,) = read_record(AssimilationTrial, json.loads(ROWS[AssimilationTrial])).tried
    assert tried == TriedContext({"x": 0.5}, {"left_arm": False}, counts=True)
    assert math.isnan(read_record(MotionEpisode, json.loads(ROWS[MotionEpisode])).off)


def test_field_with_a_default_may_be_missing() -> None:
    assert read_record(TriedContext, {"features": {}, "outcomes": {}}) == TriedContext({}, {})


@pytest.mark.parametrize(
    ("kind", "field", "value"),
    [
        (TouchTrial, "place", 0.5),
        (TouchTrial, "place", "left"),
        (ConstellationTrial, "before", [0.5]),
        (ConstellationTrial, "after", {"offset": 0.5}),
        (AssimilationTrial, "tried", [{"features": {}}]),
        (ImpedanceTrial, "profile", [{"direction": "dPz"}]),
    ],
)
def test_field_of_another_shape_is_refused(kind: type[Any], field: str, value: object) -> None:
    with pytest.raises(ValueError, match=r"no list|no names and values|missing or unknown"):
        read_record(kind, {**json.loads(ROWS[kind]), field: value})
