"""Touch trials: episodes with a rewarded touch, and the place of contact (Section 5.2.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from cbdsl.api.sensing import EpisodeListeners, Tick
from cbdsl_reproduction.chapter_5.contact_place import contact_places
from cbdsl_reproduction.simulation_fixture import simulation_fixture
from cbdsl_reproduction.trial_digest import trial_digest

# Radius of Dexter's fingertips, m.
_RADIUS = 0.012

_HANDS = {"left_arm": "left_hand", "right_arm": "right_hand"}

Place = tuple[float, ...]


class TouchSource(NamedTuple):
    """Source of touches.

    Attributes:
        program: Name of the program.
        stage: Name of the stage.
        values: Values of the program's parameters.
        arm: Arm whose hand is rewarded for touch.
    """

    program: str
    stage: str
    values: Mapping[str, str]
    arm: str

    @property
    def hand(self) -> str:
        """Hand of the arm."""
        return _HANDS[self.arm]


_LEFT = {"arm": "left_arm", "hand": "left_hand"}
#: Either arm touches the table and an object on it; both touch an object that one of them lifts.
SOURCES: Mapping[str, TouchSource] = {
    "table_right": TouchSource("touch_table", "bare_table", {}, "right_arm"),
    "table_left": TouchSource("touch_table", "bare_table", _LEFT, "left_arm"),
    "object_right": TouchSource("reachtouch", "table_right", {}, "right_arm"),
    "object_left": TouchSource("reachtouch", "table_left", _LEFT, "left_arm"),
    "bimanual": TouchSource("bimanualtouch", "table_right", {}, "left_arm"),
}


class TouchTrial(NamedTuple):
    """Episode of a touch.

    Attributes:
        things: Name of its source.
        seed: Seed of the episode.
        place: Mean of the fingertips' contacts, m, world frame; empty if it was not rewarded.
    """

    things: str
    seed: int
    place: Place


def touch_digest(source: str) -> str:
    """Return the digest of all inputs of a source's trials except seed and engine."""
    own = SOURCES[source]
    return trial_digest(own.program, own.values, own.stage)


@contextmanager
def toucher(source: str, engine: str, cameras: str | None) -> Iterator[Callable[[int], TouchTrial]]:
    """Provide a function that runs episodes of one source, each by its seed.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
    """
    own = SOURCES[source]
    with simulation_fixture(own.program, own.values, own.stage, engine, cameras) as lab:
        runner = lab.runner()

        def touch(seed: int) -> TouchTrial:
            last: list[Tick] = []

            def note(tick: Tick) -> None:
                last[:] = [tick]

            result = runner.run(lab.stage, seed, observer=EpisodeListeners(on_tick=note))
            if not result.rewarded:
                return TouchTrial(source, seed, ())
            places = contact_places(last[0].signals, own.hand, _RADIUS)
            # Several fingertips around an object have their mean within it, and not on its surface.
            place = places.mean(axis=0) if len(places) else ()
            return TouchTrial(source, seed, tuple(round(float(each), 4) for each in place))

        yield touch
