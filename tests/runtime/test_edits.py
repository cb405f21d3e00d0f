"""Edits of a running program: taken up at a change of state, with the world and the limits kept."""

from __future__ import annotations

import gc
import random
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from cbdsl.checking.program import check_program
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.edit import EditTaken
from cbdsl.program.transition import Transition
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from tests.runtime.conftest import made_stage, on_table
from tests.runtime.synthetic import SyntheticBackend

# Angle by which loads deflect the joints from their references, rad: more than a tick may move.
SAG = 0.04
HEAD = "cbdsl: 1\nkind: program\nname: shuttle\nrobot: dexter\n"
ARM = "potential: spring, feedback: right_arm.position, effector: right_arm"
QUICK = "quiescence: {rate: 1e-3, window: 0.1 s}"
NEAR, FAR = "[75 cm, -30 cm, 10 cm]", "[65 cm, -20 cm, 30 cm]"


def controller(reference: str = NEAR, more: str = "") -> str:
    return f"{{{ARM}, reference: {reference}, {QUICK}{more}}}"


def shuttle(
    near: str = "",
    steps: str = "{near: {then: far}, far: {then: near}}",
    more: str = "",
    controllers: str = "",
) -> str:
    own = f"  near: {near or controller()}\n  far: {controller(FAR)}\n{controllers}"
    return f"{HEAD}controllers:\n{own}steps: {steps}\nlimits: {{episode_time: 12 s}}\n{more}"


class Editor(EpisodeObserver):
    """Observer that offers programs at given ticks, and checks properties of every tick.

    After a change of state the last offered program runs, and no reference moves beyond the limits.
    """

    def __init__(
        self, runner: Runner, step: np.ndarray, edits: Mapping[int, CheckedProgram], last: int
    ) -> None:
        self.runner, self.edits, self.last, self._step = runner, edits, last, step
        self.ticks = 0
        self.taken: list[tuple[int, EditTaken]] = []
        self.transitions: list[tuple[int, Transition]] = []
        self.runs: list[dict[str, tuple[int, str]]] = []
        self.bounds: list[int] = []
        self.result: EpisodeResult | None = None
        self._offered: CheckedProgram | None = None

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        self._reference: np.ndarray | None = None
        self._changed = False

    def note_edit(self, edit: EditTaken) -> None:
        self.taken.append((self.ticks, edit))

    def note_transition(self, transition: Transition) -> None:
        self.transitions.append((self.ticks, transition))
        self._changed |= transition.depth == 0

    def note_tick(self, tick: Tick) -> None:
        if self._changed and self._offered is not None:
            assert tick.run.program == self._offered, "no edit is lost"
        self._changed = False
        reference = tick.actuation.reference.copy()
        if self._reference is not None:
            assert (np.abs(reference - self._reference) <= self._step).all()
        self._reference = reference
        runs = {each.controller.name: (id(each), each.predicate) for each in tick.run.runs}
        self.runs.append(runs)
        self.bounds.append(len(tick.actuation.load_guards.names))
        if self.ticks in self.edits:
            self._offered = self.edits[self.ticks]
            self.runner.offer(self._offered)
        self.ticks += 1
        if self.ticks >= self.last:
            raise KeyboardInterrupt

    def note_end(self, result: EpisodeResult) -> None:
        self.result = result


class LoadedBackend(SyntheticBackend):
    """Body whose joints stay behind their references under a load."""

    def step(self) -> None:
        self.applied[-1] = self.applied[-1] - SAG
        super().step()


Edit = Callable[..., Editor]
Check = Callable[[str], CheckedProgram]


@pytest.fixture
def check(tmp_path: Path) -> Check:
    def checked(text: str) -> CheckedProgram:
        path = tmp_path / "shuttle.yaml"
        path.write_text(text, encoding="utf-8")
        return check_program(path)

    return checked


@pytest.fixture
def edit(dexter: RobotDocument, urdf: Path, kinematics: Kinematics) -> Edit:
    """Return a function that runs episodes of a program with edits, until a number of ticks."""

    def run(program: CheckedProgram, edits: Mapping[int, CheckedProgram], last: int = 0) -> Editor:
        backend = LoadedBackend(dexter, urdf, lambda rng: on_table())
        runner = Runner(dexter, kinematics, program, backend)
        speed = np.minimum(kinematics.speed, dexter.control.joint_speed)
        step = speed * backend.control_period + 1e-9
        editor = Editor(runner, step, edits, last or 10_000)
        with suppress(KeyboardInterrupt):
            while editor.ticks < last or not editor.ticks:
                runner.run(made_stage({}), 0, observer=editor)
        return editor

    return run


ELSEWHERE = controller("[70 cm, -40 cm, 20 cm]")


def steps_after(played: Editor, tick: int) -> list[str]:
    """Return the actions that ran to rest from a tick on, without the states on their way."""
    after = [each for at, each in played.transitions if at >= tick]
    return [each.action for each in after if "1" in each.next_state]


def test_edited_step_begins_again_at_the_next_change_of_state(edit: Edit, check: Check) -> None:
    played = edit(check(shuttle()), {5: check(shuttle(ELSEWHERE))})
    ((tick, taken),) = played.taken
    assert tick > 5
    assert taken.note == "step 'near' begins again"
    assert tick in [at for at, each in played.transitions if each.next_state == "1X"]
    assert steps_after(played, tick)[:3] == ["near", "near", "far"]


def test_edit_of_another_step_lets_the_new_exits_decide(edit: Edit, check: Check) -> None:
    steps = "{near: {then: third}, far: {then: near}, third: {then: near}}"
    third = check(shuttle(steps=steps, controllers=f"  third: {ELSEWHERE}\n"))
    played = edit(check(shuttle()), {5: third})
    ((tick, taken),) = played.taken
    assert taken.note == "the exits of step 'near' decide"
    assert steps_after(played, tick)[:3] == ["near", "third", "near"]


def test_edit_that_renames_the_running_step_goes_on_with_its_exits(
    edit: Edit, check: Check
) -> None:
    steps = "{there: {do: near, then: far}, far: {then: there}}"
    played = edit(check(shuttle()), {5: check(shuttle(steps=steps))})
    ((tick, taken),) = played.taken
    assert taken.note == "the exits of step 'there', which was 'near', decide"
    assert steps_after(played, tick)[:3] == ["near", "far", "near"]


def test_edit_without_the_running_step_begins_with_the_first_step(edit: Edit, check: Check) -> None:
    steps = "{far: {then: third}, third: {then: far}}"
    gone = check(shuttle(steps=steps, controllers=f"  third: {ELSEWHERE}\n"))
    played = edit(check(shuttle()), {5: gone})
    ((tick, taken),) = played.taken
    assert taken.note == "it has no step 'near' and begins with its first step"
    assert steps_after(played, tick)[:3] == ["near", "far", "third"]


def test_edit_that_succeeds_in_the_running_step_ends_the_episode(edit: Edit, check: Check) -> None:
    steps = "{near: {then: succeed}, far: {then: near}}"
    played = edit(check(shuttle()), {5: check(shuttle(steps=steps))})
    assert played.result is not None
    assert played.result.outcome == "success"
    assert len(played.taken) == 1


def test_last_edit_before_the_change_of_state_replaces_the_others(edit: Edit, check: Check) -> None:
    one, other = check(shuttle(ELSEWHERE)), check(shuttle(more="description: other\n"))
    moved = check(shuttle(controller("[68 cm, -25 cm, 25 cm]")))
    played = edit(check(shuttle()), {5: one, 9: moved})
    assert [each.program for _, each in played.taken] == [moved]
    assert edit(check(shuttle()), {5: one, 9: other}).taken == [], "the edit was undone"


STILL = (
    "  still: {potential: spring, feedback: right_hand, effector: right_hand, "
    "reference: right_hand.preshape}\n"
)


def test_unchanged_controller_of_a_step_that_begins_again_goes_on(edit: Edit, check: Check) -> None:
    steps = "{near: {do: near ◁ still, then: far}, far: {do: far ◁ still, then: near}}"
    before = check(shuttle(steps=steps, controllers=STILL))
    played = edit(before, {5: check(shuttle(ELSEWHERE, steps=steps, controllers=STILL))})
    ((tick, taken),) = played.taken
    assert taken.note == "step 'near' begins again"
    still = [each["still"] for each in played.runs[5 : tick + 50]]
    assert {run for run, _ in still} == {still[0][0]}
    assert "X" not in {predicate for _, predicate in still}
    assert played.runs[tick - 1]["near"][0] != played.runs[tick]["near"][0]


def test_edit_of_a_subprogram_is_taken_up_at_a_change_of_its_own(
    edit: Edit, check: Check, tmp_path: Path
) -> None:
    def outer(inner: str) -> CheckedProgram:
        check(inner)
        text = f"{HEAD}use: {{go: {{program: shuttle}}}}\nsteps: {{go: {{then: succeed}}}}\n"
        path = tmp_path / "outer.yaml"
        path.write_text(text.replace("name: shuttle", "name: outer"), encoding="utf-8")
        return check_program(path)

    steps = "{near: {then: third}, far: {then: near}, third: {then: succeed}}"
    edited = outer(shuttle(steps=steps, controllers=f"  third: {ELSEWHERE}\n"))
    played = edit(outer(shuttle()), {5: edited})
    inner, whole = [each for _, each in played.taken]
    assert (inner.depth, inner.title) == (1, "go (shuttle)")
    assert inner.note == "the exits of step 'near' decide"
    assert whole.depth == 0 and whole.time > inner.time
    assert whole.note == "the exits of step 'go' decide"
    assert played.result is not None and played.result.outcome == "success"


def test_edit_may_look_for_a_colour_that_the_program_did_not_know(edit: Edit, check: Check) -> None:
    played = edit(check(shuttle()), {5: check(shuttle(controller("stereo.sat_10")))}, last=600)
    assert len(played.taken) == 1
    seen = played.runner.signals.vision.seen
    assert [*seen] == ["left", "right"]
    assert all("sat_10" in each for each in seen.values())


def test_edit_of_a_bound_is_kept_from_its_change_on(edit: Edit, check: Check) -> None:
    bounded = check(shuttle(more="guards: {hand_force: 5 N}\n"))
    played = edit(check(shuttle()), {5: bounded})
    assert len(played.taken) == 1
    assert played.bounds[0] == 0 < played.bounds[-1]


def test_edit_after_the_end_belongs_to_the_next_episode(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, check: Check
) -> None:
    steps = "{near: {then: succeed}, far: {then: near}}"
    backend = SyntheticBackend(dexter, urdf, lambda rng: on_table())
    runner = Runner(dexter, kinematics, check(shuttle(steps=steps)), backend)
    assert runner.run(made_stage({}), 0).actions[-1] == "near"
    runner.offer(check(shuttle(steps="{near: {then: far}, far: {then: succeed}}")))
    assert runner.run(made_stage({}), 0).actions[-1] == "far"


def test_edit_at_the_last_tick_keeps_the_outcome_of_its_episode(edit: Edit, check: Check) -> None:
    steps = "{near: {then: succeed}, far: {then: near}}"
    before = check(shuttle(steps=steps))
    last = edit(before, {}).ticks - 1
    played = edit(before, {last: check(shuttle(ELSEWHERE, steps=steps))})
    assert played.ticks == last + 1
    assert played.result is not None
    assert played.result.succeeded
    assert played.result.outcome == "success"
    assert len(played.taken) <= 1


def test_edits_free_the_controllers_that_they_replace(edit: Edit, check: Check) -> None:
    moved = {
        5 + 200 * n: check(shuttle(controller(f"[{70 - n} cm, -40 cm, 20 cm]"))) for n in range(8)
    }
    played = edit(check(shuttle()), moved, last=1700)
    assert len(played.taken) > 6
    runs = [each for each in gc.get_objects() if isinstance(each, ControllerRun)]
    near = [each for each in runs if each.controller.name == "near"]
    alive = [each for each in near if each._signals is played.runner.signals]
    assert len(alive) <= 3, "the present one, and those that may still go on"


class Writer:
    """Writer of random edits: steps and controllers that come, go, move and change their names."""

    def __init__(self, seed: int) -> None:
        self._rng = random.Random(seed)
        self._names = ["near", "far"]

    def text(self) -> str:
        rng = self._rng
        kept = [name for name in self._names if rng.random() < 0.8] or self._names[:1]
        added = [f"s{rng.randrange(6)}" for _ in range(rng.randrange(1, 3))]
        self._names = list(dict.fromkeys((*kept, *added)))[-4:]
        titles = {
            name: rng.choice([name, name, f"{name}_{rng.randrange(2)}"]) for name in self._names
        }
        own = "".join(f"  {name}: {self._controller()}\n" for name in self._names)
        steps = "".join(f"  {self._step(name, titles)}\n" for name in self._names)
        more = rng.choice(["", "background: still\n", "guards: {hand_force: 5 N}\n"])
        conditions = f"conditions: {{high: right_arm.position.z > {rng.randrange(10, 30)} cm}}\n"
        limits = "limits: {episode_time: 1000 s, transitions: 100000, transition_time: 3 s}\n"
        return f"{HEAD}controllers:\n{own}{STILL}{conditions}steps:\n{steps}{limits}{more}"

    def _controller(self) -> str:
        rng = self._rng
        x, y, z = rng.randrange(45, 80), rng.randrange(-50, -10), rng.randrange(0, 40)
        goals = [f"[{x} cm, {y} cm, {z} cm]"] * 4 + [
            "stereo.sat_10",
            "[250 cm, 0 cm, 0 cm]",
            "[1 cm]",
        ]
        return controller(rng.choice(goals), rng.choice(["", ", gain: 3 /s", ", speed: 30 cm/s"]))

    def _step(self, name: str, titles: Mapping[str, str]) -> str:
        rng = self._rng
        to = rng.choice([*titles.values()] * 5 + ["succeed", "fail by choice", "nowhere"])
        do = rng.choice([name, f"{name} ◁ still"])
        exits = rng.choice(["", f"exits: [high: {rng.choice([*titles.values()])}], "])
        return f"{titles[name]}: {{do: {do}, {exits}then: {to}}}"


@pytest.mark.parametrize(("edits", "seed"), [(10, 0), pytest.param(200, 1, marks=pytest.mark.slow)])
def test_random_edits_are_taken_up_at_the_next_change_without_a_jump(
    edit: Edit, check: Check, edits: int, seed: int
) -> None:
    writer, offered, refused = Writer(seed), dict[int, CheckedProgram](), 0
    while len(offered) < edits:
        try:
            offered[5 + 61 * len(offered)] = check(writer.text())
        except DiagnosticsError:
            refused += 1
    played = edit(check(shuttle()), offered, last=61 * edits + 400)
    assert refused, "some edits do not check"
    assert len(played.taken) > edits / 3
    assert played.taken[-1][1].program == [*offered.values()][-1]
