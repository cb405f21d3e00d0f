"""Action runner: each execution counts once, under the action that was chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.document_digest import ProgramDigest
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.learning.catalogs.model_exploration import ModelConstants, ModelExploration
from cbdsl.robot.resources import resources
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.feature_reader import FeatureReader
from cbdsl.training.exploration.action_runner import ActionRunner
from cbdsl.training.exploration.explorable import OPEN, Explorable, explorable, with_marks
from tests.backends.conftest import stage_named
from tests.conftest import Checked

DIGEST = ProgramDigest("0" * 64, {}, {})
HUE = "visualinspect_blue"

Inspect = Callable[..., ActionOutcome]


@pytest.fixture
def inspection(checked: Checked, dexter: RobotDocument) -> Explorable:
    """Return VISUALINSPECT of a mark of any hue."""

    def bind(name: str, values: Any) -> Explorable:
        made = explorable(name, checked("visualinspect", **values), DIGEST, resources(dexter))
        assert made is not None
        return made

    opened = with_marks("visualinspect", {"feature": "red", "mark": OPEN}, bind, dexter)
    return Explorable(
        **{**opened.__dict__, "marks": {"blue": opened.marks["blue"]}},
    )


@pytest.fixture
def runner(
    inspection: Explorable,
    checked: Checked,
    dexter: RobotDocument,
    kinematics: Kinematics,
    urdf: Path,
) -> Callable[..., ActionRunner]:
    """Return a function that makes a runner of an inspection."""

    def make(*actions: Explorable) -> ActionRunner:
        return ActionRunner(
            dexter,
            kinematics,
            KinematicBackend(dexter, urdf),
            stage_named("table_right"),
            actions or [inspection],
            checked("let_go"),
            5.0,
        )

    return make


@pytest.fixture
def inspect(runner: Callable[..., ActionRunner], monkeypatch: pytest.MonkeyPatch) -> Inspect:
    """Return a function that runs an open inspection whose episode ends as given."""
    made = runner()

    def act(*, rewarded: bool, seconds: float) -> ActionOutcome:
        def episode(_: Any, reader: FeatureReader, *rest: Any, **options: Any) -> EpisodeResult:
            reader.seconds["blue"] = seconds
            reader.values = {n: (0.1,) * r.type.size for n, r in reader._features.items()}
            return EpisodeResult(
                "visualinspect", "", "", 0, rewarded, (), (), 0, 1.0, 1.0, "", "an ending"
            )

        monkeypatch.setattr(made, "_episode", lambda action, reader, *_: episode(action, reader))
        monkeypatch.setattr(made, "_come_back", lambda *_, **__: ({}, 0.0))
        return made.run("visualinspect", ["visualinspect"], 1)

    return act


@pytest.mark.parametrize(
    ("rewarded", "seconds", "counts"),
    [(True, 1.0, True), (True, 0.0, False), (False, 1.0, False), (False, 0.0, False)],
)
def test_inspect_is_rewarded_only_where_its_hue_was_seen(
    inspect: Inspect, rewarded: bool, seconds: float, counts: bool
) -> None:
    outcome = inspect(rewarded=rewarded, seconds=seconds)
    assert outcome.rewarded == counts
    assert outcome.opened == ((HUE,) if seconds else ())


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_inspect_counts_each_execution_under_the_open_action(
    inspect: Inspect, inspection: Explorable, share: float
) -> None:
    """Predict for an open inspection the probability of its own executions."""
    exploration = ModelExploration({"visualinspect": inspection.forms}, ModelConstants())
    for number in range(20):
        rewarded = number < 20 * share
        outcome = inspect(rewarded=rewarded, seconds=1.0 if rewarded else 0.0)
        sizes = {form.name: form.size for form in inspection.forms}
        assert {name: len(values) for name, values in outcome.features.items()} == sizes
        exploration.add(dict.fromkeys(outcome.opened, inspection.marks["blue"].forms))
        exploration.note(outcome)
    affordance = exploration.affordances["visualinspect"]
    assert (affordance.tried, affordance.successes) == (20, round(20 * share))
    others = [each for name, each in exploration.affordances.items() if name != "visualinspect"]
    assert sum(each.tried for each in others) == 0


@pytest.mark.parametrize("interrupted_after", range(5))
def test_marks_take_the_same_turns_in_a_resumed_exploration(
    interrupted_after: int,
    inspection: Explorable,
    runner: Callable[..., ActionRunner],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    blue = inspection.marks["blue"]
    names = ("blue", "green", "red")
    marks = {name: replace(blue, name=f"visualinspect_{name}") for name in names}
    opened = replace(inspection, marks=marks)
    turns: list[str] = []

    def going_on() -> ActionRunner:
        made = runner(opened)

        def episode(own: Explorable, *_: object) -> EpisodeResult:
            turns.append(own.name)
            return EpisodeResult("", "", "", 0, False, (), (), 0, 1.0, 1.0, "", "")

        monkeypatch.setattr(made, "_episode", episode)
        monkeypatch.setattr(made, "_come_back", lambda *_, **__: ({}, 0.0))
        return made

    actions = ["visualinspect", "noop", *["visualinspect"] * 3]
    current = going_on()
    for number, action in enumerate(actions):
        if number == interrupted_after:
            current = going_on()
            for earlier in actions[:number]:
                current.replay(earlier)
        current.run(action, ["visualinspect"], number)
    assert turns == [f"visualinspect_{name}" for name in (*names, "blue")]


def test_inspection_observes_marks_that_ran_as_actions_before(
    inspection: Explorable, runner: Callable[..., ActionRunner], monkeypatch: pytest.MonkeyPatch
) -> None:
    made, observed = runner(), []

    def run(used: Runner, *_: object, **__: object) -> EpisodeResult:
        observed.append({each.name for each in used.observed})
        return EpisodeResult("", "", "", 0, False, (), (), 0, 1.0, 1.0, "", "")

    monkeypatch.setattr(made, "_run", run)
    monkeypatch.setattr(made, "_come_back", lambda *_, **__: ({}, 0.0))
    for name in (HUE, "visualinspect"):
        made.run(name, ["visualinspect", HUE], 1)
    assert {each.name for each in inspection.observed} <= observed[1]
