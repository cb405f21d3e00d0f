"""Experiments that learn: small ones on the kinematic backend, resumed where they stopped."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest

from cbdsl.learning.experience import Experience
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl_reproduction.experiment import Experiment, RunSettings
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import data
from cbdsl_reproduction.series import SEQUENTIAL
from cbdsl_reproduction.trial_runner import trial_runner

LEARNING = [
    pytest.param(each, id=each.name, marks=[] if "4.2.1" in each.section else pytest.mark.slow)
    for each in EXPERIMENTS.values()
    if each.learns
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that the trials of all experiments share."""
    return tmp_path_factory.mktemp("trials")


@pytest.mark.parametrize("experiment", LEARNING)
def test_experiment_resumes_from_kept_episodes(
    experiment: Experiment, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[tuple[int, int]] = []
    settings = RunSettings(
        seed=2, quick=True, trials=1, folder=folder, progress=lambda *parts: told.append(parts)
    )
    outcome = experiment.load()(settings)
    assert outcome.quantities and outcome.notes
    assert told[-1][0] == told[-1][1]
    for quantity in outcome.quantities:
        if quantity.interval is not None and not math.isnan(quantity.ours):
            low, high = quantity.interval
            assert low - 1e-9 <= quantity.ours <= high + 1e-9, quantity.name
    for picture in outcome.charts:
        ET.fromstring(picture.svg())
        assert picture.name.startswith(experiment.name)

    def none(*_: object) -> None:
        raise AssertionError("all episodes are kept")

    monkeypatch.setattr(BackendEpisodeRunner, "run", none)
    again = experiment.load()(settings)
    assert data(experiment, settings, again) == data(experiment, settings, outcome)


def test_episode_with_equal_choices_of_two_policies_runs_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs: list[int] = []
    hold = BackendEpisodeRunner.run

    def counted(classroom: BackendEpisodeRunner, *arguments: Any) -> Experience:
        runs.append(arguments[2])
        return hold(classroom, *arguments)

    with trial_runner(RunSettings(seed=3, quick=True, trials=1, folder=tmp_path)) as dexter:
        (learned,) = dexter.learn(SEQUENTIAL)
        seeds, program = learned.held_out(4), learned.trial.informed_program()
        monkeypatch.setattr(BackendEpisodeRunner, "run", counted)
        before = dexter.greedy(learned.after(2), "before", seeds, program)
        alone = dexter.greedy(learned, "alone", seeds, program)
        runs.clear()
        known = (*before, *alone[:2])
        assert dexter.greedy(learned, "beside", seeds, program, known=known) == alone
        assert runs == [each.seed for each in alone if each not in known]
        runs.clear()
        assert dexter.greedy(learned, "again", seeds, program, known=(*before, *alone)) == alone
        assert runs == []
