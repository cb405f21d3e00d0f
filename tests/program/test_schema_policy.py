"""Schemas allocate by context, keep allocations that make progress, and try none twice."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.schema_policy import SchemaPolicy
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


def begun(schema: CheckedProgram, features: dict[str, float], **options: bool) -> SchemaPolicy:
    policy = SchemaPolicy(schema, **options)
    policy.begin(lambda: features)
    return policy


def retried(policy: SchemaPolicy, state: str) -> str | None:
    """Return the action after a failure, once the failed allocation has withdrawn."""
    assert policy.choose(state, changed=False) is None and policy.withdraws
    return policy.choose(state, changed=True)


def allocation(action: str | None) -> str:
    """Return the allocation of an action; the learned policy decides its leading part."""
    return (action or "").rpartition(" with ")[2]


def test_a_state_has_one_letter_for_each_abstract_action(schema: CheckedProgram) -> None:
    assert schema.members == ("searchtrack", "reach", "touch")
    allocated = {action.name: action for action in schema.actions}
    assert len(allocated) == 1 + 3 * 4
    assert allocated["searchtrack"].allocation == ""
    left = allocated["reach ◁ touch with left_arm"]
    assert (left.abstract, left.allocation) == ("reach ◁ touch", "left_arm")
    assert left.composition is not None
    moved = {each.lead.effector.name for each in left.composition.primitives}
    assert moved == {"left_arm.position", "left_hand"}


def test_the_tree_chooses_and_progress_keeps_the_choice(schema: CheckedProgram) -> None:
    features = dict(NEAR_LEFT)
    policy = begun(schema, features)
    assert allocation(policy.choose("1XX", changed=True)) == "left_arm"
    features["place.y"] = -0.3
    assert allocation(policy.choose("X0-", changed=True)) == "left_arm"


def test_after_a_failure_the_other_is_tried_and_then_none(schema: CheckedProgram) -> None:
    policy = begun(schema, NEAR_LEFT)
    policy.choose("X0-", changed=True)
    assert allocation(retried(policy, "X0-")) == "right_arm"
    assert allocation(retried(policy, "X0-")) == "reachtouch_bimanual"
    assert policy.choose("X0-", changed=False) is None and not policy.withdraws
    assert policy.reason == "every allocation has been tried"
    policy.begin(lambda: NEAR_LEFT)
    assert allocation(policy.choose("X0-", changed=True)) == "left_arm"


def test_what_fails_unseen_is_not_held_against_it(schema: CheckedProgram) -> None:
    features = dict(UNSEEN)
    policy = begun(schema, features)
    assert allocation(policy.choose("X0-", changed=True)) == "right_arm"
    features.update(place_left := NEAR_LEFT)
    assert place_left and allocation(policy.choose("X0-", changed=False)) == "left_arm"
    assert allocation(retried(policy, "X0-")) == "right_arm"


def test_it_moves_nothing_where_reward_is_unlikely(schema: CheckedProgram) -> None:
    policy = begun(schema, FAR_LEFT)
    assert policy.choose("X--", changed=True) == "searchtrack"
    assert policy.choose("1XX", changed=True) is None
    assert policy.reason == "reward is unlikely here (5 %)"
    learning = begun(schema, FAR_LEFT, gives_up=False)
    assert allocation(learning.choose("1XX", changed=True)) == "left_arm"


def test_what_needs_no_allocation_ends_the_attempt(schema: CheckedProgram) -> None:
    features = dict(NEAR_LEFT)
    policy = begun(schema, features)
    policy.choose("X0-", changed=True)
    assert policy.choose("X--", changed=True) == "searchtrack"
    features["place.y"] = -0.3
    assert allocation(policy.choose("1XX", changed=True)) == "right_arm"


def test_what_brings_programs_begins_anew_after_a_failure() -> None:
    """Start again after a failure: no other allocation can go on from an object in one hand."""
    library = Library(ROOT)
    path = library.locate(ProgramDocument, "pick_and_place")
    learned = library.read(library.locate(PolicyDocument, "pick_and_place"), PolicyDocument)
    program = program_to_assimilate(path, learned, Session(library), {})
    assert program.schema is not None
    known = dict.fromkeys(program.schema.components, 0.5)
    policy = SchemaPolicy(program, lambda _: ("right_arm", "left_arm_handover"), gives_up=False)
    policy.begin(lambda: known)
    assert policy.choose("XXX", changed=True) == "reachtouch with right_arm"
    assert allocation(policy.choose("0XX", changed=True)) == "right_arm"
    assert allocation(policy.choose("1XX", changed=True)) == "right_arm"
    assert allocation(policy.choose("X0-", changed=True)) == "right_arm"
    # The goal is out of reach.
    assert retried(policy, "X0-") == "reachtouch with left_arm_handover"


def test_places_of_several_things_are_looked_for_and_what_is_taken_last() -> None:
    library = Library(ROOT)
    path = library.locate(ProgramDocument, "pick_and_place")
    learned = library.read(library.locate(PolicyDocument, "pick_and_place"), PolicyDocument)
    program = program_to_assimilate(path, learned, Session(library), {})
    assert program.schema is not None
    features = {name: each.name for name, each in program.schema.features.items()}
    assert features == {"feature_place": "stereo.red", "goal_place": "stereo.green"}
    assert list(program.looks) == ["goal_place", "feature_place"]
    assert program.looks["goal_place"].values == {"feature": "green"}


def test_an_untried_context_is_tried_and_named(schema: CheckedProgram) -> None:
    assert schema.schema is not None
    known = schema.schema._replace(tried={"place.x": (0.3, 1.2)})
    policy = begun(schema._replace(schema=known), FAR_LEFT)
    assert allocation(policy.choose("X0-", changed=True)) == "left_arm"
    for _ in range(len(known.allocations) - 1):
        retried(policy, "X0-")
    assert policy.choose("X0-", changed=False) is None
    assert policy.reason.startswith("every allocation has been tried; reward was unknown here (")
    assert "place.x" in policy.reason
