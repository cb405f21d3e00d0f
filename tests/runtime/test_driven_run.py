"""Runs of programs whose predicates are set by hand, tick by tick, and their reactions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import SimpleNamespace as Made

import numpy as np
import pytest

from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.program.schema import NO_FEATURES
from cbdsl.program.transition import Transition
from cbdsl.runtime import actuation as actuation_module
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.explanation import named_runs
from cbdsl.runtime.policies.policy import Choice
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from tests.conftest import Checked

#: Control period, s; sums of it are exact.
PERIOD = 0.125
HEAD = "potential: spring, feedback: head, effector: head"
TWO = f"""
controllers:
  left: {{{HEAD}, reference: [0.5 rad, 0 rad]}}
  right: {{{HEAD}, reference: [-0.5 rad, 0 rad]}}
actions: [left, right, left ◁ right]
"""


class Driven:
    """A program whose controllers have the predicates that a test gives them."""

    def __init__(self, program: CheckedProgram, robot: RobotDocument, kinematics: Kinematics):
        self.signals, self.plan = (
            Signals(robot, kinematics, resources_of(program)),
            ControllerPlan(),
        )
        self.signals.reset()
        still = np.zeros(len(self.signals.joints))
        cells = robot.load_cells.items()
        loads = {(hand, cell): np.zeros(6) for hand, own in cells for cell in own}
        self.signals.update(Observation(0.0, still, still, loads, {}))
        self.run = ProgramRun(program, self.signals, self.plan, PERIOD)
        self.transitions: list[Transition] = []
        self.run.begin(np.random.default_rng(0), self.transitions.append)
        self.run.activate()

    def named(self, name: str) -> ControllerRun:
        return dict(named_runs(self.run))[name]

    def advance(self, **predicates: str) -> None:
        """Advance a tick, after which some controllers have these predicates."""
        for name, letter in predicates.items():
            self.named(name).predicate = letter
        self.run.advance()

    def ticks_to_the_end(self) -> int:
        """Return the number of ticks until the end with predicates as they are."""
        for tick in range(1, 1000):
            self.run.advance()
            if self.run.predicate != "0":
                return tick
        raise AssertionError("it does not end")

    @property
    def acting(self) -> list[str]:
        return [item.run.controller.name for item in self.run.active()]


Drive = Callable[..., Driven]


@pytest.fixture
def drive(
    written: Callable[..., CheckedProgram], dexter: RobotDocument, kinematics: Kinematics
) -> Drive:
    """Return a function that drives a program given by its text, or checked."""

    def made(program: str | CheckedProgram) -> Driven:
        checked = written(program) if isinstance(program, str) else program
        return Driven(checked, dexter, kinematics)

    return made


def test_state_without_an_action_ends_the_run(drive: Drive) -> None:
    driven = drive(TWO + "policy: {XX: left, 0X: right}\nlimits: {transition_time: 1 s}\n")
    driven.advance(left="0")
    assert (driven.run.state, driven.transitions[0].ticks) == ("0X", 1)
    driven.named("left").predicate, driven.named("right").predicate = "X", "0"
    driven.advance()
    assert driven.run.state == "X0"
    assert driven.run.predicate == "-" and "has no action for state X0" in driven.run.ending


def test_action_without_a_transition_ends_after_its_time(drive: Drive) -> None:
    driven = drive(TWO + "policy: {XX: left, 0X: left}\nlimits: {transition_time: 1 s}\n")
    driven.advance(left="0")
    assert driven.ticks_to_the_end() == 9, "8 are no longer than 1 s"
    assert driven.run.ending == "left changed nothing in 1 s (state 0X)"
    assert [each.ticks for each in driven.transitions] == [1, 9]
    assert driven.run.transitions == 2


def test_idle_ticks_count_from_the_last_that_strove(drive: Drive) -> None:
    limits = "limits: {transition_time: 9 s, idle_time: 0.5 s}\n"
    driven = drive(TWO + "policy: {XX: left, 1X: left}\n" + limits)
    for _ in range(4):
        driven.advance(left="X")
    assert not driven.transitions, "of 4 ticks none is longer than 0.5 s"
    driven.advance(left="1")
    assert driven.run.state == "1X" and driven.run.predicate == "0"
    assert driven.ticks_to_the_end() == 5
    again = drive(TWO + "policy: {XX: left, 0X: left}\n" + limits)
    again.advance(left="0")
    assert again.ticks_to_the_end() == 73, "what strives is not idle"


def test_episode_is_over_with_its_time(drive: Drive) -> None:
    limits = "limits: {transition_time: 9 s, episode_time: 1 s}\n"
    driven = drive(TWO + "policy: {XX: left, 0X: left}\n" + limits)
    driven.named("left").predicate = "0"
    assert driven.ticks_to_the_end() == 8
    assert driven.run.ending == "the 1 s of own were over"
    assert driven.run.predicate == "-"


def test_no_more_transitions_are_made_than_allowed(drive: Drive) -> None:
    driven = drive(TWO + 'policy: {"**": left}\nlimits: {transitions: 3}\n')
    for letter in "01":
        driven.advance(left=letter)
        assert driven.run.predicate == "0"
    driven.advance(left="0")
    assert driven.run.predicate == "-"
    assert driven.run.ending == "own used up its 3 transitions"
    states = [(each.state, each.next_state) for each in driven.transitions]
    assert states == [("XX", "0X"), ("0X", "1X"), ("1X", "0X")]
    driven.advance(left="1")
    assert len(driven.transitions) == 3, "what has ended goes on no more"


def test_controllers_of_the_next_action_continue_and_others_stop(drive: Drive) -> None:
    driven = drive(TWO + "policy: {XX: left ◁ right, 00: left, 0X: right}\n")
    assert driven.acting == ["right", "left"]
    driven.advance(left="0", right="0")
    assert driven.acting == ["left"]
    assert (driven.named("left").predicate, driven.named("right").predicate) == ("0", "X")
    driven.advance()
    assert driven.acting == ["right"]
    assert (driven.named("left").predicate, driven.named("right").predicate) == ("X", "0")


def test_stack_by_hand_stops_all_others_but_the_background(drive: Drive) -> None:
    arm = "potential: spring, feedback: right_arm, effector: right_arm, reference: right_arm.ready"
    driven = drive(
        TWO.replace("actions:", f"  rest: {{{arm}}}\nbackground: rest\nactions:")
        + 'policy: {"**": left ◁ right}\n'
    )
    driven.advance(left="0", right="0", rest="1")
    driven.run.compose(["left"])
    assert driven.acting == ["left", "rest"]
    letters = {name: driven.named(name).predicate for name in ("left", "right", "rest")}
    assert letters == {"left": "0", "right": "X", "rest": "1"}
    driven.advance(left="1")
    assert len(driven.transitions) == 1, "meanwhile it has no transitions"
    driven.run.compose(None)
    assert driven.run.state == "XX" and driven.acting == ["right", "left", "rest"]
    assert driven.run.action is not None


def test_without_an_open_choice_nothing_is_decided(drive: Drive) -> None:
    driven = drive(TWO + "policy: {XX: left}\n")
    with pytest.raises(ValueError, match="no choice is open"):
        driven.run.decide("left")


def every(run: ProgramRun) -> Iterator[ProgramRun]:
    yield run
    for child in run.children.values():
        yield from every(child)


def test_stopped_program_stops_all_programs_that_it_uses(drive: Drive, checked: Checked) -> None:
    driven = drive(checked("visualinspect"))
    for run in every(driven.run):
        run.activate()
        run.rewarded, run.transitions = True, 3
    for _, controller in named_runs(driven.run):
        controller.predicate = "0"
    driven.run.deactivate()
    for run in every(driven.run):
        assert (run.predicate, run.transitions, run.action) == ("X", 0, None)
        assert (run.ending, run.outcome, run.rewarded, run.is_open) == ("", "", False, False)
        assert run.state == "X" * len(run.program.members)
    assert {each.predicate for _, each in named_runs(driven.run)} == {"X"}
    assert driven.acting == []


def test_levels_are_the_same_object_while_the_same_act(drive: Drive, checked: Checked) -> None:
    driven = drive(checked("reachtouch"))
    assert driven.run.action is not None
    first = driven.run.active()
    assert driven.run.active() is first
    child = next(each for name, each in driven.run.children.items() if name == "searchtrack")
    driven.run._begin_action(Choice("searchtrack"), NO_FEATURES, True)
    with_child = driven.run.active()
    assert with_child is not first and driven.run.active() is with_child
    assert with_child[: len(child.active())] == tuple(child.active())


@pytest.mark.parametrize("longer", [1.0, 2.0])
def test_guards_of_the_law_grow_with_the_ticks(
    dexter: RobotDocument, kinematics: Kinematics, longer: float
) -> None:
    """Damping is a squared singular value, and those grow as far as joints move in a tick."""
    control, period = dexter.control, longer / dexter.control.rate
    signals = Signals(dexter, kinematics, ())
    settings = Actuation(dexter, signals, ControllerPlan(), period).settings
    assert settings.damping == pytest.approx(control.damping * longer**2)
    assert settings.singular_value == pytest.approx(control.singular_value * longer)
    assert settings.joint_step == pytest.approx(control.joint_speed * period)
    assert (settings.limit_margin, settings.lead) == (control.limit_margin, control.lead)


@pytest.mark.parametrize("is_foreign", [False, True])
def test_fault_of_another_package_s_potential_is_reported_as_its(
    drive: Drive, dexter: RobotDocument, monkeypatch: pytest.MonkeyPatch, is_foreign: bool
) -> None:
    driven = drive(TWO + 'policy: {"**": left}\n')
    own = Actuation(dexter, driven.signals, driven.plan, PERIOD)
    own.reset(driven.signals.positions)
    error = ZeroDivisionError("nothing")

    def fail(*arguments: object) -> int:
        raise error

    registry = Made(
        is_builtin=lambda name: name != "spring" or not is_foreign,
        fault=lambda name, reason: RuntimeError(f"{name}: {reason}"),
    )
    monkeypatch.setattr(actuation_module, "bind", lambda *_: fail)
    monkeypatch.setattr(actuation_module, "POTENTIALS", Made(registry=registry))
    with pytest.raises((ZeroDivisionError, RuntimeError)) as raised:
        own.move(driven.run.active())
    if is_foreign:
        assert str(raised.value) == "spring: ZeroDivisionError: nothing"
        assert raised.value.__cause__ is error
    else:
        assert raised.value is error and error.__cause__ is None
