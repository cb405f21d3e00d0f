"""Trial jobs of experiments: they leave no trials to run, and do not change the outcome."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cbdsl.api.trials import TaskObserver
from cbdsl.backends.backend import find_backend
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl_reproduction.experiment import Experiment, RunSettings
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import data
from cbdsl_reproduction.trial_job import trial_jobs
from cbdsl_reproduction.trial_runner import shipped_dexter

LEARNING = [
    pytest.param(each, id=each.name, marks=[] if each.name == "fig-4.4" else pytest.mark.slow)
    for each in EXPERIMENTS.values()
    if each.learns and "4.2.1" in each.section
]


def run(experiment: Experiment, settings: RunSettings) -> list[tuple[int, int]]:
    """Carry out all jobs here, the last one first, and return the progress of each."""
    robot, urdf = shipped_dexter()
    body, kinematics = find_backend(settings.backend)(robot, urdf), Kinematics(robot, urdf)
    with trial_jobs(experiment, settings) as jobs:
        assert [job.progress() for job in jobs] == [(0, 0)] * len(jobs)
        for job in reversed(jobs):
            job.run(body, kinematics, TaskObserver())
        return [job.progress() for job in jobs]


@pytest.mark.parametrize("experiment", LEARNING)
def test_experiment_after_all_shares_runs_nothing_and_has_the_same_outcome(
    experiment: Experiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    settings = RunSettings(seed=2, quick=True, trials=2, folder=here)
    alone = experiment.load()(settings)
    shared = replace(settings, folder=there)
    for done, total in run(experiment, shared):
        assert done == total > 0

    def none(*_: object) -> None:
        raise AssertionError("all episodes are kept")

    monkeypatch.setattr(BackendEpisodeRunner, "run", none)
    outcome = experiment.load()(shared)
    for part in ("quantities", "charts"):  # notes may contain run times
        assert data(experiment, shared, outcome)[part] == data(experiment, settings, alone)[part]
    kept = {file.relative_to(there) for file in there.rglob("*") if file.is_file()}
    assert kept == {file.relative_to(here) for file in here.rglob("*") if file.is_file()}
