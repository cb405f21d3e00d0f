"""Touch trials: episodes that end in a rewarded touch, and where that was felt (Section 5.2.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from cbdsl.reproduction.simulation_fixture import simulation_fixture
from cbdsl.reproduction.trial_digest import trial_digest
from cbdsl.runtime.episode import Tick
from cbdsl.sensing.contact_place import contact_places

# Of Dexter's fingertips, m.
_RADIUS = 0.012

_HANDS = {"left_arm": "left_hand", "right_arm": "right_hand"}

Place = tuple[float, ...]


class TouchSource(NamedTuple):
    """A way to gather touches.

    Attributes:
        program: that is run.
        stage: where.
        values: of its parameters.
        arm: whose hand's touch is rewarded.
    """

    program: str
    stage: str
    values: Mapping[str, str]
    arm: str

    @property
    def hand(self) -> str:
        """The hand of the arm."""
        return _HANDS[self.arm]


_LEFT = {"arm": "left_arm", "hand": "left_hand"}
#: Either arm touches the table and an object on it; both touch what one of them brings up.
SOURCES: Mapping[str, TouchSource] = {
    "table_right": TouchSource("touch_table", "bare_table", {}, "right_arm"),
    "table_left": TouchSource("touch_table", "bare_table", _LEFT, "left_arm"),
    "object_right": TouchSource("reachtouch", "table_right", {}, "right_arm"),
    "object_left": TouchSource("reachtouch", "table_left", _LEFT, "left_arm"),
    "bimanual": TouchSource("bimanualtouch", "table_right", {}, "left_arm"),
}


class TouchTrial(NamedTuple):
    """One episode.

    Attributes:
        things: its source.
        seed: of the episode.
        place: mean of the fingertips' contacts, m, world frame; empty where it was not rewarded.
    """

    things: str
    seed: int
    place: Place


def touch_digest(source: str) -> str:
    """Digest of all that decides trials of a source beside seed and engine."""
    own = SOURCES[source]
    return trial_digest(own.program, own.values, own.stage)


@contextmanager
def toucher(source: str, engine: str, cameras: str | None) -> Iterator[Callable[[int], TouchTrial]]:
    """Runs episodes of one source, each by its seed.

    Raises:
        BackendError, EpisodeError: the simulator cannot run it.
        ImportError: it is not installed.
    """
    own = SOURCES[source]
    with simulation_fixture(own.program, own.values, own.stage, engine, cameras) as lab:
        runner = lab.runner()

        def touch(seed: int) -> TouchTrial:
            last: list[Tick] = []

            def note(tick: Tick) -> None:
                last[:] = [tick]

            result = runner.run(lab.stage, seed, on_tick=note)
            if not result.rewarded:
                return TouchTrial(source, seed, ())
            places = contact_places(last[0].signals, own.hand, _RADIUS)
            place = places.mean(axis=0) if len(places) else ()
            return TouchTrial(source, seed, tuple(round(float(each), 4) for each in place))

        yield touch
