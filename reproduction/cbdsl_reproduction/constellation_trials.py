"""Trials of constellations: features of two objects before and after stacking."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from cbdsl.api.control import Kinematics
from cbdsl.api.sensing import (
    EpisodeListeners,
    FeatureReader,
    Runner,
    Tick,
    pair_features,
    resources,
)
from cbdsl_reproduction.simulation_fixture import simulation_fixture
from cbdsl_reproduction.stack_trials import StackJudge
from cbdsl_reproduction.trial_digest import trial_digest

PROGRAM, STAGE = "stand", "stacking"
#: Channels that identify the objects of the stage.
CHANNELS: Mapping[str, str] = {
    "blue_box": "blue",
    "purple_box": "hue_9",
    "basketball": "red",
    "football": "green",
}

Features = Mapping[str, tuple[float, ...]]


class ConstellationTrial(NamedTuple):
    """Episode of stacking a pair.

    Attributes:
        things: Context, such as ``football_on_blue_box``.
        seed: Seed of the episode.
        judged: True if the stack stands according to the robot's own signals.
        stands: True if the stack stands according to the simulator's ground truth.
        before: Features of both objects side by side.
        after: Features after the hand has left, without undefined ones.
        ending: Ending of the program.
    """

    things: str
    seed: int
    judged: bool
    stands: bool
    before: Features
    after: Features
    ending: str


def constellation_digest(things: str) -> str:
    """Return the digest of all inputs of a pair's trials except seed and engine."""
    return trial_digest(PROGRAM, _values(things), STAGE)


def _values(things: str) -> dict[str, str]:
    """Return the values of the program's parameters for a pair."""
    upper, _, lower = things.partition("_on_")
    return {"feature": CHANNELS[upper], "goal": CHANNELS[lower]}


def run_constellations(
    things: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[ConstellationTrial]:
    """Stack two objects, once for each seed, and record their features.

    Args:
        things: Context of the stage ``stacking`` with two objects.
        seeds: Seeds of the episodes.
        engine, cameras: Engine and cameras of the simulation.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
    """
    values = _values(things)
    with simulation_fixture(PROGRAM, values, STAGE, engine, cameras) as lab:
        camera = next(iter(lab.robot.cameras))
        features = pair_features(values["feature"], values["goal"], camera, resources(lab.robot))
        kinematics, observed = Kinematics(lab.robot, lab.urdf), tuple(features.values())
        runner = Runner(lab.robot, kinematics, lab.program, lab.backend, observed=observed)
        for seed in seeds:
            judge, reader = StackJudge(lab.backend.truth, ("base", "top")), FeatureReader(features)

            def note(tick: Tick, judge: StackJudge = judge, reader: FeatureReader = reader) -> None:
                judge.note(tick)
                reader.note_tick(tick)

            result = runner.run(lab.stage, seed, things, observer=EpisodeListeners(on_tick=note))
            after = {key: runner.signals.read(each) for key, each in features.items()}
            yield ConstellationTrial(
                things,
                seed,
                result.outcome == "success" and not result.far,
                judge.conclude(things, seed, result.ending).stands,
                reader.values,
                {k: tuple(each.value.tolist()) for k, each in after.items() if each is not None},
                result.ending,
            )
