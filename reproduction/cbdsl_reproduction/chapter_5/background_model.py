"""Background model: head postures at which each channel is tracked in a room (Figures 5.3 to 5.5).

SEARCHTRACK is run with one channel after another. If the channel is tracked, the posture of the
head is a sample of the background model. After ten unsuccessful looks the channel is given up
(Section 5.2.1).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cbdsl.api.sensing import EpisodeListeners, Tick, channel_names
from cbdsl_reproduction.chapter_4.posture_panels import PosturePanels
from cbdsl_reproduction.chapter_5.background_documents import write_backgrounds
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.kept_rows import KeptRows
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above
from cbdsl_reproduction.simulation_fixture import SimulationFixture, simulation_fixture

_PROGRAM, _STAGE, _EFFECTOR = "searchtrack", "furnished", "head"
#: Figures of the source by the beginning of their channels' names.
FIGURES = {"sat": ("5.3", "saturation"), "hue": ("5.4", "hue"), "int": ("5.5", "intensity")}
_POSITIVES, _QUICK_POSITIVES = 50, 1
# Ten looks have two transitions each: on the way, and there. Tracking takes three more.
_TRANSITIONS = 23
_TRACKED = {
    prefix: Claim(
        f"Section 5.2.1, Figure {figure}",
        f"{word}: channels that can be tracked",
        "%",
        "most, and a few not at all",
        above(50),
    )
    for prefix, (figure, word) in FIGURES.items()
}
CLAIMS: Claims = {"fig-5.3-5.5": tuple(_TRACKED.values())}

Posture = tuple[float, ...]


class ChannelSearch(NamedTuple):
    """Search for a channel with up to ten looks.

    Attributes:
        channel: Name of the channel.
        seed: Seed of the search.
        posture: Posture of the head that tracks the channel, rad; empty if it was not tracked.
    """

    channel: str
    seed: int
    posture: Posture


class KeptSearches:
    """Searches that are stored in a file as soon as they end.

    Args:
        path: File with a line of JSON for each search; it need not exist.
    """

    def __init__(self, path: Path) -> None:
        self._rows = KeptRows(path)
        self._known = {
            (channel, seed): ChannelSearch(channel, seed, tuple(posture))
            for channel, seed, posture in self._rows
        }

    def get(self, channel: str, seed: int, look: Callable[[int], Posture]) -> ChannelSearch:
        """Return a search, from the file or by running it."""
        known = self._known.get((channel, seed))
        if known is None:
            known = self._known[channel, seed] = ChannelSearch(channel, seed, look(seed))
            self._rows.add(known)
        return known


@dataclass(frozen=True)
class TrackedPostures:
    """Postures in which a channel was tracked.

    Attributes:
        channel: Name of the channel.
        postures: Postures of the head that tracks the channel, rad.
        given_up: True if the last search was unsuccessful.
    """

    channel: str
    postures: tuple[Posture, ...]
    given_up: bool


def run(settings: RunSettings) -> Result:
    """Search for every channel, and draw the postures at which each was tracked."""
    wanted = _QUICK_POSITIVES if settings.quick else settings.trials or _POSITIVES
    kept = KeptSearches(settings.folder / "background_searches.jsonl")
    channels: list[TrackedPostures] = []
    with simulation_fixture(_PROGRAM, stage=_STAGE) as lab:
        # Bins alone: the channel of motion has an experiment of its
        # own, in which objects are shaken (Figure 5.2).
        names = [name for name in channel_names(lab.robot.vision.channels) if "_" in name]
        limits = _limits(lab)
    for number, channel in enumerate(names):
        settings.progress(number, len(names))
        with simulation_fixture(_PROGRAM, {"feature": channel}, _STAGE) as lab:
            look, first = looker(lab), settings.seed
            # The generator is lazy: no search runs after the first unsuccessful one.
            searches = (kept.get(channel, seed, look) for seed in range(first, first + wanted))
            channels.append(tracked_postures(channel, searches))
    settings.progress(len(names), len(names))
    tracked = {each.channel: each.postures for each in channels}
    write_backgrounds(settings.folder, lab.robot.name, _EFFECTOR, _STAGE, tracked)
    return Result(tuple(quantities(channels)), tuple(_pictures(channels, limits)), _notes(channels))


def tracked_postures(channel: str, searches: Iterable[ChannelSearch]) -> TrackedPostures:
    """Collect the postures of searches, up to the first unsuccessful one."""
    postures: list[Posture] = []
    for search in searches:
        if not search.posture:
            return TrackedPostures(channel, tuple(postures), True)
        postures.append(search.posture)
    return TrackedPostures(channel, tuple(postures), False)


def looker(lab: SimulationFixture) -> Callable[[int], Posture]:
    """Return a function that searches for a channel and returns the final head posture."""
    program = lab.program._replace(transitions=_TRANSITIONS)
    runner = replace(lab, program=program).runner()

    def look(seed: int) -> Posture:
        last: list[Posture] = [()]

        def note(tick: Tick) -> None:
            # Only the final posture counts. Its four decimals, 0.1
            # mrad, are far below the bandwidth of the models, 0.05 rad.
            columns = tick.signals.joints.of(_EFFECTOR)
            last[0] = tuple(round(float(a), 4) for a in tick.observation.positions[columns])

        result = runner.run(lab.stage, seed, observer=EpisodeListeners(on_tick=note))
        return last[0] if result.rewarded else ()

    return look


def quantities(channels: Sequence[TrackedPostures]) -> Iterator[Quantity]:
    """Yield the shares of channels that can be tracked."""
    for prefix, (figure, _) in FIGURES.items():
        own = [each for each in channels if each.channel.startswith(prefix)]
        empty = [each.channel for each in own if not each.postures]
        yield percentage(
            _TRACKED[prefix],
            len(own) - len(empty),
            len(own),
            of="channels",
            note=f"Figure {figure}; empty: {', '.join(empty) or 'none'}",
        )


def _limits(lab: SimulationFixture) -> Mapping[str, tuple[float, float]]:
    kinematics = lab.kinematics
    columns = kinematics.joints.of(_EFFECTOR)
    return {
        joint: (float(kinematics.lower[column]), float(kinematics.upper[column]))
        for joint, column in zip(lab.robot.joints(_EFFECTOR), columns, strict=True)
    }


def _pictures(
    channels: Sequence[TrackedPostures], limits: Mapping[str, tuple[float, float]]
) -> Iterator[PosturePanels]:
    for prefix, (figure, word) in FIGURES.items():
        panels = {
            each.channel: np.array(each.postures).reshape(-1, 2)
            for each in channels
            if each.channel.startswith(prefix)
        }
        title = f"Where channels of {word} are trackable (Figure {figure})"
        yield PosturePanels(f"background_{word}", title, panels, limits)


def _notes(channels: Sequence[TrackedPostures]) -> tuple[str, ...]:
    samples = sum(len(each.postures) for each in channels)
    given_up = [each.channel for each in channels if each.given_up and each.postures]
    return (
        f"{samples} samples on stage {_STAGE}, rendered, from postures of the head drawn anew. "
        f"Given up after some samples: {', '.join(given_up) or 'none'}.",
    )
