"""Explanations: predictions come true, and levels that block a lower level are named."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.causes import LIMITS
from cbdsl.runtime.explanation import Explanation, TickExplanation
from cbdsl.runtime.tick import Tick
from tests.conftest import Checked
from tests.runtime.conftest import Play
from tests.runtime.synthetic import World

ARM = "potential: spring, feedback: right_arm, effector: right_arm"
# Two springs with conflicting references for the same joints.
RIVALS = f"""
controllers:
  ready: {{{ARM}, reference: right_arm.ready}}
  home: {{{ARM}, reference: right_arm.home}}
actions: [ready, home, home ◁ ready]
policy: {{"**": home ◁ ready}}
limits: {{transition_time: 2 s}}
"""
TIP = """
controllers:
  reach:
    potential: spring
    reference: [60 cm, -20 cm, 10 cm]
    feedback: right_arm.position
    effector: right_arm.position
actions: [reach]
policy: {X: reach, "0": reach}
"""


@pytest.fixture
def explained(written: Callable[..., CheckedProgram], play: Play) -> Callable[..., list]:
    def explain(body: str, **more: object) -> list[TickExplanation]:
        explanation = Explanation()
        told: list[TickExplanation] = []

        def watch(tick: Tick) -> None:
            told.append(explanation.note(tick))

        play(written(body), watch=watch, **more)
        return told

    return explain


def test_predicted_change_of_phi_equals_the_measured_one(
    explained: Callable[..., list[TickExplanation]],
) -> None:
    """Joints follow at once here, so that only the step's second order is left."""
    for body, name in ((RIVALS, "ready"), (TIP, "reach")):
        levels = [level for tick in explained(body) for level in tick.levels if level.name == name]
        assert np.isnan(levels[0].predicted) and np.isnan(levels[0].measured)
        predicted = np.array([level.predicted for level in levels[1:]])
        measured = np.array([level.measured for level in levels[1:]])
        assert predicted.min() < -1e-4
        assert np.abs(predicted - measured).max() < 0.1 * np.abs(predicted).max()


def test_measured_change_of_a_blocked_joint_differs_from_the_prediction(
    explained: Callable[..., list[TickExplanation]], dexter: RobotDocument
) -> None:
    names = dexter.effectors["right_arm"].joints
    told = explained(RIVALS, begin=lambda rng: World(blocked=names))
    levels = [level for tick in told for level in tick.levels if level.name == "ready"]
    assert min(level.predicted for level in levels[1:]) < -1e-4
    assert all(level.measured == 0.0 for level in levels[1:])


def test_note_of_a_level_that_requests_nothing_has_no_share(
    explained: Callable[..., list[TickExplanation]], dexter: RobotDocument
) -> None:
    """Run a level at its reference, up to rounding, below one that moves the arm."""
    arm = dexter.effectors["right_arm"]
    assert arm.start is not None
    start = np.nextafter(arm.postures[arm.start], 10.0)
    at = ", ".join(f"{angle!r}" for angle in start.tolist())
    body = f"""{TIP.partition("actions")[0]}  stay: {{{ARM}, reference: [{at}]}}
actions: [reach, stay, stay ◁ reach]
policy: {{"**": stay ◁ reach}}
limits: {{transition_time: 2 s}}
"""
    ticks = [{level.name: level for level in tick.levels} for tick in explained(body)]
    assert np.isnan(ticks[0]["stay"].share)
    assert np.isfinite(ticks[5]["stay"].share) and np.isfinite(ticks[0]["reach"].share)


def test_level_above_that_takes_all_freedom_is_named(
    explained: Callable[..., list[TickExplanation]],
) -> None:
    for tick in explained(RIVALS):
        above, below = tick.levels
        assert (above.name, below.name) == ("ready", "home")
        assert above.held_by == ""
        assert below.rank == 0
        assert below.held_by == ("ready" if below.share < 0.5 else "")


def test_level_that_carries_another_too_far_is_named(
    explained: Callable[..., list[TickExplanation]],
) -> None:
    """Two springs to one posture, the lower with a tenth of the gain: it is carried ten times."""
    body = RIVALS.replace("right_arm.home", "right_arm.ready, gain: 0.2 /s")
    pushed = [below for _, below in (tick.levels for tick in explained(body)) if below.share > 1.5]
    assert max(below.share for below in pushed) == pytest.approx(10.0, abs=1.0)
    assert {(below.pushed_by, below.held_by) for below in pushed} == {("ready", "")}


def test_limits_are_named(
    explained: Callable[..., list[TickExplanation]],
) -> None:
    """Move the head closer to the end of its tilt than the margin allows."""
    body = """
controllers:
  look: {potential: spring, reference: [0 deg, 85.9 deg], feedback: head, effector: head}
actions: [look]
policy: {X: look, "0": look}
"""
    last = explained(body)[-1]
    assert last.at_limits == ("tilt",)
    assert last.levels[0].held_by == LIMITS


def test_names_are_qualified_by_the_programs_that_use_them(play: Play, checked: Checked) -> None:
    explanation = Explanation()
    names: set[str] = set()
    play(
        checked("reachtouch"),
        watch=lambda tick: names.update(each.name for each in explanation.note(tick).levels),
        joints={"pan": 0.8, "tilt": 0.2},
    )
    assert {"searchtrack.search", "approach", "touch"} <= names
