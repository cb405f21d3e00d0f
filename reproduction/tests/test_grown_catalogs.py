"""Catalogs that PICKANDPLACE joins: they are extended, and judged by its reward."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cbdsl.training.exploration.action_runner import ActionRunner
from cbdsl_reproduction.chapter_7.grown_catalogs import FIGURES, joined_after
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import data
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

NAMES = ("fig-7.7", "fig-7.8", "fig-7.9")


def test_meta_catalogs_are_of_the_same_explorations() -> None:
    series = [EXPERIMENTS[name].imported().series_of(name)[0] for name in NAMES]
    assert list(EXPERIMENTS["fig-7.10"].imported().series_of("fig-7.10")) == series


@pytest.mark.parametrize("name", NAMES)
def test_one_action_joins_after_a_hundred_in_the_same_world(name: str) -> None:
    series = FIGURES[name].series
    known = series.grown_from
    assert known is not None and known.grown_from is None
    assert (known.actions, series.actions, series.trials) == (100, 50, 25)
    assert series.stage == known.stage and series.feature == known.feature
    assert [each.name for each in series.explored[len(known.explored) :]] == ["pick_and_place"]
    command = series.command(1, 150, "mujoco", None)
    assert "--join" in command and "--join" not in known.command(1, 100, "mujoco", None)


@pytest.mark.parametrize("name", NAMES)
def test_colour_of_a_placed_object_is_no_obstacle(name: str) -> None:
    """Obstacles have no object color: a blue patch on a ball would repel the ball itself."""
    _, task = FIGURES[name].series.request(Path("any.yaml")).task()
    placing = next(each for each in task.actions if each.name == "pick_and_place")
    aliases = task.robot.vision.channels.aliases
    assert task.joins
    assert placing.program.parameters["obstacle"] not in {*aliases, *aliases.values()}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_finished_trial_is_kept_and_not_repeated(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[tuple[int, int]] = []
    settings = RunSettings(
        seed=3, quick=True, trials=1, folder=tmp_path, backend="mujoco", cameras="ideal"
    )
    watched = replace(settings, progress=lambda over, total: done.append((over, total)))
    first = EXPERIMENTS[name].load()(watched)
    assert done[-1] == (12, 12)

    def none(*_: object) -> None:
        raise AssertionError("all actions are kept")

    monkeypatch.setattr(ActionRunner, "run", none)
    with trial_runner(settings) as dexter:
        (catalog,) = dexter.explore(FIGURES[name].series)
    assert isinstance(dexter, TrialRunner)
    assert joined_after([catalog]) == 6
    assert catalog.steps is not None and "pick_and_place" not in catalog.steps.action[:6]
    again = EXPERIMENTS[name].load()(settings)
    assert data(EXPERIMENTS[name], settings, again) == data(EXPERIMENTS[name], settings, first)
    assert all(picture.svg().startswith("<svg") for picture in first.charts)
