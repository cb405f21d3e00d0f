"""Schemas allocate by context, keep allocations that make progress, and try none twice."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.policies.policy import Choice
from cbdsl.runtime.policies.schema_policy import SchemaPolicy
from cbdsl.types.decision_tree import Leaf, Split
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

SIDES = Split("place.y", 0.0, Leaf(("left_arm",)), Leaf(("right_arm",)))
REACH = Split("place.x", 1.0, Leaf(0.05), Leaf(0.95))
NEAR_LEFT = {"place.x": 0.5, "place.y": 0.3}
FAR_LEFT = {"place.x": 1.5, "place.y": 0.3}
UNSEEN = {"place.x": math.nan, "place.y": math.nan}


@pytest.fixture(scope="module")
def schema() -> CheckedProgram:
    """Return REACHTOUCH with either limb, by the side of the object."""
    library = Library(ROOT)
    path: Path = library.locate(ProgramDocument, "reachtouch")
    policy = library.read(library.locate(PolicyDocument, "reachtouch"), PolicyDocument)
    program = program_to_assimilate(path, policy, Session(library), {})
    assert program.schema is not None
    knowledge = program.schema._replace(choice=SIDES, reward=REACH)
    return program._replace(schema=knowledge)


Choose = Callable[[str, bool], Choice]


def begun(schema: CheckedProgram, features: dict[str, float], **options: bool) -> Choose:
    """Return the choice of a schema's policy by a state, and by whether that is new."""
    policy = SchemaPolicy(schema, **options)
    return lambda state, changed: policy.choose(state, changed=changed, features=features)


def retried(choose: Choose, state: str) -> Choice:
    """Return the choice after a failure, once the failed allocation has withdrawn."""
    assert choose(state, False) == Choice(None, withdraws=True)
    return choose(state, True)


def test_state_has_one_letter_for_each_abstract_action(schema: CheckedProgram) -> None:
    assert schema.members == ("searchtrack", "reach", "touch")
    allocated = {action.name: action for action in schema.actions}
    assert len(allocated) == 1 + 3 * 4
    assert allocated["searchtrack"].allocation == ""
    left = allocated["reach ◁ touch with left_arm"]
    assert (left.abstract, left.allocation) == ("reach ◁ touch", "left_arm")
    assert left.composition is not None
    moved = {each.lead.effector.name for each in left.composition.primitives}
    assert moved == {"left_arm.position", "left_hand"}


def test_tree_chooses_and_progress_keeps_the_choice(schema: CheckedProgram) -> None:
    features = dict(NEAR_LEFT)
    choose = begun(schema, features)
    assert choose("1XX", True).allocation == "left_arm"
    features["place.y"] = -0.3
    assert choose("X0-", True).allocation == "left_arm"


def test_after_a_failure_the_next_allocation_is_tried_until_none_is_left(
    schema: CheckedProgram,
) -> None:
    policy = SchemaPolicy(schema)

    def choose(state: str, changed: bool) -> Choice:
        return policy.choose(state, changed=changed, features=NEAR_LEFT)

    choose("X0-", True)
    assert retried(choose, "X0-").allocation == "right_arm"
    assert retried(choose, "X0-").allocation == "reachtouch_bimanual"
    assert choose("X0-", False) == Choice(None, reason="every allocation has been tried")
    policy.begin()
    assert choose("X0-", True).allocation == "left_arm"


def test_failure_with_undefined_features_excludes_no_allocation(schema: CheckedProgram) -> None:
    features = dict(UNSEEN)
    choose = begun(schema, features)
    assert choose("X0-", True).allocation == "right_arm"
    features.update(place_left := NEAR_LEFT)
    assert place_left and choose("X0-", False).allocation == "left_arm"
    assert retried(choose, "X0-").allocation == "right_arm"


def test_schema_policy_without_predicted_reward_moves_nothing(schema: CheckedProgram) -> None:
    choose = begun(schema, FAR_LEFT)
    assert choose("X--", True) == Choice("searchtrack")
    assert choose("1XX", True) == Choice(None, reason="reward is unlikely here (5 %)")
    learning = begun(schema, FAR_LEFT, gives_up=False)
    assert learning("1XX", True).allocation == "left_arm"


def test_action_without_allocation_ends_the_attempt(schema: CheckedProgram) -> None:
    features = dict(NEAR_LEFT)
    choose = begun(schema, features)
    choose("X0-", True)
    assert choose("X--", True) == Choice("searchtrack")
    features["place.y"] = -0.3
    assert choose("1XX", True).allocation == "right_arm"


def test_carrying_program_restarts_after_a_failure() -> None:
    """Start again after a failure: no other allocation can go on from an object in one hand."""
    library = Library(ROOT)
    path = library.locate(ProgramDocument, "pick_and_place")
    learned = library.read(library.locate(PolicyDocument, "pick_and_place"), PolicyDocument)
    program = program_to_assimilate(path, learned, Session(library), {})
    assert program.schema is not None
    known = dict.fromkeys(program.schema.components, 0.5)
    policy = SchemaPolicy(program, lambda _: ("right_arm", "left_arm_handover"), gives_up=False)

    def choose(state: str, changed: bool) -> Choice:
        return policy.choose(state, changed=changed, features=known)

    assert choose("XXX", True) == Choice("reachtouch", "right_arm")
    assert choose("0XX", True).allocation == "right_arm"
    assert choose("1XX", True).allocation == "right_arm"
    assert choose("X0-", True).allocation == "right_arm"
    # The goal is out of reach.
    assert retried(choose, "X0-") == Choice("reachtouch", "left_arm_handover")


def test_features_are_looked_for_in_order_with_the_grasped_object_last() -> None:
    library = Library(ROOT)
    path = library.locate(ProgramDocument, "pick_and_place")
    learned = library.read(library.locate(PolicyDocument, "pick_and_place"), PolicyDocument)
    program = program_to_assimilate(path, learned, Session(library), {})
    assert program.schema is not None
    features = {name: each.name for name, each in program.schema.features.items()}
    assert features == {"feature_place": "stereo.red", "goal_place": "stereo.green"}
    assert list(program.looks) == ["goal_place", "feature_place"]
    assert program.looks["goal_place"].values == {"feature": "green"}


def test_untried_context_is_tried_and_named(schema: CheckedProgram) -> None:
    assert schema.schema is not None
    known = schema.schema._replace(tried={"place.x": (0.3, 1.2)})
    choose = begun(schema._replace(schema=known), FAR_LEFT)
    assert choose("X0-", True).allocation == "left_arm"
    for _ in range(len(known.allocations) - 1):
        retried(choose, "X0-")
    choice = choose("X0-", False)
    assert choice.action is None and not choice.withdraws
    assert choice.reason.startswith("every allocation has been tried; reward was unknown here (")
    assert "place.x" in choice.reason
