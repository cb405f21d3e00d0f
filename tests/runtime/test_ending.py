"""Descriptions of the end of an episode, by the last readings of its controllers."""

from __future__ import annotations

import math
from types import SimpleNamespace as Made
from typing import Any

import pytest

from cbdsl.program.controller import Relative
from cbdsl.runtime.causes import (
    BLOCKED,
    CREEPING,
    HELD,
    LIMITS,
    OPTIMUM,
    OUT_OF_REACH,
    SINGULAR,
    RestCause,
)
from cbdsl.runtime.ending import describe, describe_lateness, describe_stop, stuck_leads
from cbdsl.types.resource import Origin
from cbdsl.types.resource_type import configuration

PALM = Made(name="right_arm.position", origin=Origin.KINEMATICS)
BALL = Made(name="ball.position", origin=Origin.ENVIRONMENT)


def lead(error: float, **other: Any) -> Any:
    """Return a controller that moves the palm to the ball, by its last readings."""
    own = {
        "name": "reach", "feedback": PALM, "reference": BALL, "potential": "spring",
        "task": Made(name="position"), "requires": None,
    }  # fmt: skip
    controller = Made(**own | {name: other.pop(name) for name in own if name in other})
    runs = {
        "error": error, "predicate": "1", "phi": 0.5, "stuck": False, "exhausted": False,
        "astray": False, "lacks_hold": False,
        "engaged": False, "preparation": Made(no_path=""),
    }  # fmt: skip
    return Made(controller=controller, **runs | other)


def ended(*leads: Any, **other: Any) -> Any:
    """Return a program whose last action had some controllers, without reward."""
    action = Made(program=None, name="go")
    program = Made(success=None, reward_ends=False)
    facts = {
        "program": program, "action": action, "leads": lambda _: leads, "outcome": "",
        "predicate": "-", "rewarded": False, "state": "X1", "ending": "the time was up",
        "active": lambda: [Made(run=each, peers={}) for each in leads], "children": {},
        "losses": (),
    }  # fmt: skip
    return Made(**facts | other)


def told(*leads: Any, **other: Any) -> str:
    return describe(ended(*leads, **other), 3.24, ())


@pytest.mark.parametrize(
    ("run", "clause"),
    [
        (lead(0.0149), "reach came to rest 1.5 cm from ball.position"),
        (lead(0.0149, predicate="0"), "reach was still 1.5 cm from ball.position"),
        (
            lead(0.021, stuck=True),
            "reach is stuck, 2.1 cm from ball.position",
        ),
        (lead(0.5), "reach came to rest 50.0 cm from"),
        (lead(0.2, task=Made(name="force")), "reach came to rest 0.2 N from"),
        (lead(0.05, task=Made(name="heading")), "reach came to rest 2.9 deg from"),
        (lead(0.0524, task=Made(name="orientation")), "came to rest 3.0 deg from"),
        (lead(0.1, stuck=True, task=configuration(2)), "reach is stuck, 5.7 deg from"),
        (lead(0.004, task=configuration(2, ["m", "m"])), "came to rest 4.0 mm from"),
        (lead(0.1, task=configuration(2, ["rad", "m"])), "to rest 0.1 (rad and m) from"),
        (lead(0.25, task=Made(name="scalar")), "reach came to rest 0.250 from"),
        (lead(0.1, reference=None), "came to rest at a potential of 0.5"),
        (lead(0.01, reference=Relative(None, (0.1,))), "1.0 cm from its reference"),
        (lead(0.01, reference=Relative(BALL, (0.1,))), "1.0 cm from beside ball.position"),
        (lead(math.nan), "reach had no ball.position"),
        (lead(math.nan, feedback=BALL, reference=PALM), "reach had no ball.position"),
        (lead(math.nan, reference=None), "reach had no right_arm.position"),
        (lead(math.nan, exhausted=True), "reach closed on nothing"),
        (lead(math.nan, astray=True), "reach felt something else than the object"),
        (lead(0.1, preparation=Made(no_path="a wall")), "reach had no way: a wall"),
        (lead(0.01, potential="harmonic"), "came to rest at least 1.0 cm from"),
        (lead(0.01, potential="harmonic", phi=0.001), "came to rest 1.0 cm from"),
    ],
)
def test_each_controller_has_a_clause(run: Any, clause: str) -> None:
    assert clause in told(run)


def test_ending_names_a_missing_hold_and_the_colours_that_are_seen() -> None:
    assert "reach moves a held object, and no hand holds one" in told(
        lead(math.nan, lacks_hold=True, predicate="-")
    )
    run = ended(lead(math.nan, predicate="-"))
    assert "; the cameras see red and blue;" in describe(run, 3.0, (), colors=["red", "blue"])
    assert "the cameras see no named colour" in describe(run, 3.0, (), colors=[])


def test_sentence_has_verdict_time_state_and_reasons() -> None:
    ball = lead(0.01)
    assert told(ball) == (
        "Not rewarded after 3.2 s in state X1: reach came to rest 1.0 cm from ball.position; "
        "the time was up."
    )
    assert told(ball, predicate="1").startswith("Done after")
    assert "the time was up" not in told(ball, predicate="1")
    rewarded = told(ball, predicate="1", rewarded=True)
    assert rewarded.startswith("Rewarded") and "the time was up" in rewarded
    assert told(ball, outcome="success", rewarded=True).startswith("Succeeded")
    assert told(ball, outcome="failure").startswith("Failed")
    neither = Made(success="held", reward_ends=False)
    assert told(ball, program=neither, rewarded=True).startswith("Neither succeeded nor failed")
    ends = Made(success="held", reward_ends=True)
    assert told(ball, program=ends, rewarded=True).startswith("Rewarded")
    assert told(action=None) == "Not rewarded after 3.2 s in state X1: the time was up."


def test_limits_are_reported_after_failures_and_guards_always() -> None:
    for facts, said in (({}, True), ({"rewarded": True}, False), ({"outcome": "success"}, False)):
        text = describe(ended(lead(0.01), **facts), 1.0, ("elbow",), ("the guard held",))
        assert ("at their limits were elbow" in text) is said
        assert text.endswith("the guard held.")


@pytest.mark.parametrize("felt", [False, True])
def test_missing_requirement_is_reported_with_its_controller(felt: bool) -> None:
    touch = lead(math.nan, name="touch", feedback=BALL, task=Made(name="force"), exhausted=felt)
    two = [lead(math.nan, name=name, requires="touch") for name in ("left", "right")]
    run = ended(*two)
    run.active = lambda: [Made(run=each, peers={"touch": touch}) for each in two]
    absence = "touch closed on nothing" if felt else "touch felt nothing"
    assert f"{absence}, and left and right require it" in describe(run, 1.0, ())
    run.leads = lambda _: two[:1]
    assert f"{absence}, and left requires it" in describe(run, 1.0, ())
    touch.engaged, touch.error = True, 0.1
    assert "left had no ball.position" in describe(run, 1.0, ())


def test_lost_and_sought_resource_is_reported_with_its_requirer() -> None:
    touch = lead(math.nan, name="touch", feedback=BALL, task=Made(name="force"), engaged=True)
    left = lead(math.nan, name="left", requires="touch")
    run = ended(left)
    run.active = lambda: [Made(run=left, peers={"touch": touch})]
    assert "touch had no ball.position, and left requires it" in describe(run, 1.0, ())


def test_ending_of_a_used_program_is_reported() -> None:
    child = ended(lead(0.01), ending="it had no more to do")
    parent = ended(action=Made(program="child", name="find"), children={"find": child})
    assert "reach came to rest 1.0 cm from ball.position; it had no more to do" in describe(
        parent, 1.0, ()
    )
    child.leads = lambda _: (lead(0.1, stuck=True), lead(0.01, name="other"))
    assert [each.controller.name for each in stuck_leads(parent)] == ["reach"]
    assert stuck_leads(ended(action=None)) == ()


def test_stops_are_reported_with_their_cause() -> None:
    run = ended()
    assert describe_stop(run, 1.26, KeyboardInterrupt()) == "Interrupted after 1.3 s in state X1."
    fault = RuntimeError("outer")
    assert describe_stop(run, 1.0, fault) == "Failed after 1.0 s in state X1: outer."
    fault.__cause__ = ValueError("inner")
    assert describe_stop(run, 1.0, fault) == "Failed after 1.0 s in state X1: inner."
    late = describe_lateness(run, 1.0, 0.0252, 0.016)
    assert "took 25.2 ms" in late and "deadline is 16 ms" in late


@pytest.mark.parametrize(
    ("cause", "clause"),
    [
        (RestCause(LIMITS, (LIMITS,), ("elbow",)), "at the limit of elbow, 28.5 cm from"),
        (
            RestCause(LIMITS, (LIMITS,), ("elbow", "wrist")),
            "at the limits of elbow and wrist, 28.5 cm",
        ),
        (RestCause(HELD, ("turn",)), ", held by turn, 28.5 cm from"),
        (
            RestCause(HELD, ("turn", LIMITS), ("a", "b", "c")),
            ", held by turn and the limits of a, b and",
        ),
        (RestCause(OPTIMUM), " at a local optimum, 28.5 cm from ball.position; the time"),
        (
            RestCause(OPTIMUM, least=0.001),
            " at a local optimum, 28.5 cm from ball.position; the time",
        ),
        (RestCause(SINGULAR), " at a singular posture, 28.5 cm from"),
        (
            RestCause(OUT_OF_REACH, least=0.284),
            " out of reach, 28.5 cm from ball.position; the time",
        ),
        (
            RestCause(OUT_OF_REACH, least=0.1),
            "28.5 cm from ball.position (another posture is 10.0 cm",
        ),
        (RestCause(BLOCKED, joints=("elbow",)), ", blocked at elbow, 28.5 cm from"),
        (
            RestCause(BLOCKED, joints=("elbow",), obstructions=("elbow bears 41.9 of 30 N m",)),
            ", blocked at elbow (elbow bears 41.9 of 30 N m), 28.5 cm from",
        ),
        (RestCause(CREEPING), ", still creeping, 28.5 cm from"),
        (None, "reach is stuck, 28.5 cm from"),
    ],
)
def test_ending_of_a_stuck_controller_names_its_cause(cause: RestCause | None, clause: str) -> None:
    text = describe(ended(lead(0.285, stuck=True)), 3.24, (), (), {"reach": cause})
    assert "reach is stuck" in text and clause in text


def test_ending_of_an_arrived_controller_names_no_cause() -> None:
    text = describe(ended(lead(0.01)), 3.24, (), (), {"reach": RestCause(OPTIMUM)})
    assert "optimum" not in text and "stuck" not in text


@pytest.mark.parametrize(
    ("facts", "said"), [({}, True), ({"rewarded": True}, False), ({"outcome": "success"}, False)]
)
def test_describe_names_an_object_that_is_gone(facts: dict[str, Any], said: bool) -> None:
    gone = "the object of red is gone: last seen 20.0 s before, at (60, -30, -38) cm"
    text = describe(ended(lead(math.nan), losses=(gone,), **facts), 1.0, ())
    assert (gone in text) is said
