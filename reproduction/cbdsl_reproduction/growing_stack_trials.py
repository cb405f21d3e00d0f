"""Trials of a growing stack of three: its blobs in the image, and its stability."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from cbdsl.api.control import Kinematics
from cbdsl.api.sensing import EpisodeListeners, Resource, Runner, Signals, Tick, resources
from cbdsl_reproduction.constellation_trials import CHANNELS, STAGE
from cbdsl_reproduction.simulation_fixture import simulation_fixture
from cbdsl_reproduction.stack_trials import StackJudge
from cbdsl_reproduction.trial_digest import trial_digest

PROGRAM, CONTEXT = "stand_three", "blue_box_purple_box_football"
#: Objects, from below.
ORDER = ("blue_box", "purple_box", "football")
_VALUES = {"goal": CHANNELS[ORDER[0]], "middle": CHANNELS[ORDER[1]], "feature": CHANNELS[ORDER[2]]}

# Part of a blob, as a signal's name ends.
_PARTS = ("", ".extent", ".orientation")
# State of the program that stacks three: the hand has returned from the lower pair.
_TWO_STAND = "X1"

Blobs = Mapping[str, tuple[float, ...]]


class GrowingStack(NamedTuple):
    """Episode with a growing stack.

    Attributes:
        things: Context of the stage.
        seed: Seed of the episode.
        tracked: True if the robot tracks both constellations after the release, and judges that
            the stack stands.
        stands: True if each object rests only on the one below, by the simulator's ground truth.
        views: Blobs of the objects by name in the left image, initially, with two stacked, and
            finally. A blob holds the heading to the centre and the extent of the axes, two angles
            each, and the direction of the longer axis except for round ones, rad. Invisible
            objects are left out.
        ending: Ending of the program.
    """

    things: str
    seed: int
    tracked: bool
    stands: bool
    views: Sequence[Blobs]
    ending: str


class _BlobReader:
    """Reader of the blobs of the initial objects, and of two stacked ones."""

    def __init__(self, features: Mapping[str, Sequence[Resource]]) -> None:
        self._features = features
        self.views: list[Blobs] = []

    def note(self, tick: Tick) -> None:
        """Record the blobs of a tick, if they are complete."""
        two = tick.run.children["stack"].state.startswith(_TWO_STAND)
        # The second view requires the first, in which all three are visible simultaneously.
        if len(self.views) == int(two):
            seen = self.look(tick.signals)
            # The third object may be out of view while the head looks at the two stacked ones.
            if seen.keys() >= {*(ORDER[:2] if two else ORDER)}:
                self.views.append(seen)

    def look(self, signals: Signals) -> Blobs:
        """Return the blobs of the visible objects."""
        seen = {name: _blob(signals, parts) for name, parts in self._features.items()}
        return {name: blob for name, blob in seen.items() if blob}


def _blob(signals: Signals, parts: Sequence[Resource]) -> tuple[float, ...]:
    """Return heading, extent and, if defined, direction of a blob; empty if it is invisible."""
    heading, extent, axis = map(signals.read, parts)
    if heading is None or extent is None:
        return ()
    known = [each.value.ravel().tolist() for each in (heading, extent, axis) if each is not None]
    return tuple(round(value, 5) for own in known for value in own)


def growing_digest(context: str) -> str:
    """Return the digest of all inputs of trials except seed and engine."""
    return trial_digest(PROGRAM, _VALUES, STAGE)


def run_growing_stacks(
    context: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[GrowingStack]:
    """Stack three objects, once for each seed, and record their blobs.

    Args:
        context: Context of the stage ``stacking``.
        seeds: Seeds of the episodes.
        engine, cameras: Engine and cameras of the simulation.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
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

            result = runner.run(lab.stage, seed, context, observer=EpisodeListeners(on_tick=note))
            yield GrowingStack(
                context,
                seed,
                result.outcome == "success" and not result.far,
                judge.conclude(context, seed, result.ending).stands,
                (*reader.views, reader.look(runner.signals)),
                result.ending,
            )
