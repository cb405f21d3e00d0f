"""Trials of a stack of three that grows: what the robot sees of it, and whether it stands."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from cbdsl.reproduction.constellation_trials import CHANNELS, STAGE
from cbdsl.reproduction.simulation_fixture import simulation_fixture
from cbdsl.reproduction.stack_trials import StackJudge
from cbdsl.reproduction.trial_digest import trial_digest
from cbdsl.robot.resources import resources
from cbdsl.runtime.episode import Runner, Tick
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import Resource

PROGRAM, CONTEXT = "stand_three", "blue_box_purple_box_football"
#: The things, from below.
ORDER = ("blue_box", "purple_box", "football")
_VALUES = {"goal": CHANNELS[ORDER[0]], "middle": CHANNELS[ORDER[1]], "feature": CHANNELS[ORDER[2]]}

# Part of a blob, as a signal's name ends.
_PARTS = ("", ".extent", ".orientation")
# Of the program that stacks three: the hand has gone home from the lower pair.
_TWO_STAND = "X1"

Blobs = Mapping[str, tuple[float, ...]]


class GrowingStack(NamedTuple):
    """One episode.

    Attributes:
        things: its context.
        seed: of the episode.
        tracked: whether the robot tracks both constellations after the release, and takes the three
            to stand.
        stands: whether each thing rests on the one below it alone, by the simulator's truth.
        views: blobs of the things by name in the left image, as they lie, when two are stacked, and
            in the end: heading to the centre and extent of the axes, two angles each, and the
            direction of the longer axis, which round ones have not; all in rad. What is not seen is
            left out.
        ending: of the program.
    """

    things: str
    seed: int
    tracked: bool
    stands: bool
    views: Sequence[Blobs]
    ending: str


class _BlobReader:
    """Reads the blobs as the things lie, and when two of them are stacked."""

    def __init__(self, features: Mapping[str, Sequence[Resource]]) -> None:
        self._features = features
        self.views: list[Blobs] = []

    def note(self, tick: Tick) -> None:
        """Take in a tick."""
        two = tick.run.children["stack"].state.startswith(_TWO_STAND)
        # Where all three were never in view at once, the second view is none without the first.
        if len(self.views) == int(two):
            seen = self.look(tick.signals)
            # The third one may be out of view of a head that looks at the two that stand.
            if seen.keys() >= {*(ORDER[:2] if two else ORDER)}:
                self.views.append(seen)

    def look(self, signals: Signals) -> Blobs:
        """Blobs of the things that are seen now."""
        seen = {name: _blob(signals, parts) for name, parts in self._features.items()}
        return {name: blob for name, blob in seen.items() if blob}


def _blob(signals: Signals, parts: Sequence[Resource]) -> tuple[float, ...]:
    """Heading, extent and, where it has one, direction of a blob; nothing where it is not seen."""
    heading, extent, axis = map(signals.read, parts)
    if heading is None or extent is None:
        return ()
    known = [each.value.ravel().tolist() for each in (heading, extent, axis) if each is not None]
    return tuple(round(value, 5) for own in known for value in own)


def growing_digest(context: str) -> str:
    """Digest of all that decides trials beside seed and engine."""
    return trial_digest(PROGRAM, _VALUES, STAGE)


def run_growing_stacks(
    context: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[GrowingStack]:
    """Stack three things, once for each seed, and look at them.

    Args:
        context: of the stage ``stacking``.
        seeds: of the episodes.
        engine, cameras: of the simulation.

    Raises:
        BackendError, EpisodeError: the simulator cannot run it.
        ImportError: it is not installed.
    """
    with simulation_fixture(PROGRAM, _VALUES, STAGE, engine, cameras) as lab:
        named, camera = resources(lab.robot), next(iter(lab.robot.cameras))
        features = {
            name: [named[f"{camera}.{CHANNELS[name]}{ending}"] for ending in _PARTS]
            for name in ORDER
        }
        observed = tuple(each for own in features.values() for each in own)
        kinematics = Kinematics(lab.robot, lab.urdf)
        runner = Runner(lab.robot, kinematics, lab.program, lab.backend, observed=observed)
        for seed in seeds:
            judge, reader = StackJudge(lab.backend.truth, ORDER), _BlobReader(features)

            def note(tick: Tick, judge: StackJudge = judge, reader: _BlobReader = reader) -> None:
                judge.note(tick)
                reader.note(tick)

            result = runner.run(lab.stage, seed, context, on_tick=note)
            yield GrowingStack(
                context,
                seed,
                result.outcome == "success" and not result.far,
                judge.conclude(context, seed, result.ending).stands,
                (*reader.views, reader.look(runner.signals)),
                result.ending,
            )
