"""Experiments of Chapter 6: their trials are kept, and their reports describe these trials."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path

import pytest
import typer.main
from typer import Typer

from cbdsl.cli.explore import explore
from cbdsl.training.exploration.action_runner import ActionRunner
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.exploration_series import BASKETBALL, TABLE, TABLE_MODELS, ExplorationSeries
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import data

CHAPTER = [name for name in EXPERIMENTS if name.startswith("fig-6")]


def test_chapter_has_figures_6_2_to_6_8() -> None:
    assert [f"fig-6.{number}" for number in range(2, 9)] == CHAPTER


@pytest.mark.parametrize("name", CHAPTER)
def test_each_figure_has_25_trials_of_100_actions(name: str) -> None:
    series = EXPERIMENTS[name].imported().series_of(name)
    assert series and all(each.trials == 25 and each.actions == 100 for each in series)


@pytest.mark.parametrize(
    ("series", "longest"), [(TABLE, 120.0), (TABLE_MODELS, 120.0), (BASKETBALL, 60.0)]
)
def test_command_of_a_series_sets_the_same_constants(
    series: ExplorationSeries, longest: float, tmp_path: Path
) -> None:
    _, task = series.request(tmp_path / "a.yaml").task()
    assert task.constants.longest == longest
    app = Typer()
    app.command()(explore)
    _, name, *words = shlex.split(series.command(3, 7, "mujoco", "ideal"))
    given = typer.main.get_command(app).make_context(name, words).params
    wanted = [f"{key}={value}" for key, value in series.settings.items()]
    assert list(given["constants"] or []) == wanted


@pytest.mark.slow
@pytest.mark.parametrize("name", CHAPTER)
def test_finished_trial_is_kept_and_not_repeated(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[tuple[int, int]] = []
    settings = RunSettings(seed=3, quick=True, trials=2, folder=tmp_path)
    watched = replace(settings, progress=lambda over, total: done.append((over, total)))
    first = EXPERIMENTS[name].load()(watched)
    assert done[-1][0] == done[-1][1] > 0

    def none(*_: object) -> None:
        raise AssertionError("all actions are kept")

    monkeypatch.setattr(ActionRunner, "run", none)
    again = EXPERIMENTS[name].load()(settings)
    assert data(EXPERIMENTS[name], settings, again) == data(EXPERIMENTS[name], settings, first)
    assert all(picture.svg().startswith("<svg") for picture in first.charts)
