"""Judges: conditions with aims, and a function that measures episodes of a condition."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple


class Aim(NamedTuple):
    """Least or largest share of the episodes with an outcome, from 0 to 1."""

    least: float = 0.0
    most: float = 1.0

    def is_met(self, successes: int, count: int) -> bool:
        """Return whether a number of successes is within the aim; without episodes only ANY is."""
        return self == ANY or (count > 0 and self.least * count <= successes <= self.most * count)

    @property
    def is_least(self) -> bool:
        """True if episodes should have the outcome, rather than lack it."""
        return self.most == 1.0

    def __str__(self) -> str:
        if self.most < 1.0:
            return f"at most {100 * self.most:g} %" if self.most else "none"
        return f"at least {100 * self.least:g} %" if self.least else ""


ANY = Aim()
NONE = Aim(most=0.0)


class BodyChoice(NamedTuple):
    """Backend and kind of cameras, by name; the backend's own cameras if ``None``."""

    backend: str
    cameras: str | None


BULLET = BodyChoice("bullet", None)


@dataclass(frozen=True)
class JudgedCondition:
    """Setting of episodes, and the aims of their outcomes.

    Attributes:
        name: Name in results.
        program: Name of the program; empty without a shipped one.
        aims: Aim of each outcome that the judge counts.
        stage: Name of the stage; the program's own if ``None``.
        context: Context of the stage; drawn by share if ``None``.
        values: Values of the program's parameters.
    """

    name: str
    program: str
    aims: Mapping[str, Aim]
    stage: str | None = None
    context: str | None = None
    values: Mapping[str, str] = field(default_factory=dict)


# A plain dictionary, which other processes can send.
_UNMEASURED: Mapping[str, float] = {}


class EpisodeVerdict(NamedTuple):
    """Verdict on an episode.

    Attributes:
        seed: Seed of the episode.
        outcomes: True for each outcome that the episode has; ``None`` if it does not count.
        seconds: Simulated time, s.
        ending: Reason of the end.
        measures: Measured quantities, with their units in their names.
        context: Context of the stage.
    """

    seed: int
    outcomes: Mapping[str, bool | None]
    seconds: float
    ending: str
    measures: Mapping[str, float] = _UNMEASURED
    context: str = ""


class Score(NamedTuple):
    """Mean of a measure over the episodes, which has to be below that of a baseline.

    Attributes:
        name: Name in results.
        measure: Name of the measure.
        baseline: Name of the measure of the baseline.
    """

    name: str
    measure: str
    baseline: str


Measure = Callable[[JudgedCondition, BodyChoice, Sequence[int]], Iterator[EpisodeVerdict]]


@dataclass(frozen=True)
class Judge:
    """Judge of a capability.

    Attributes:
        name: Name on the command line.
        title: Description, one line.
        conditions: Conditions that it measures.
        measure: Function that yields the verdict on each seed's episode.
        body: Default backend and cameras.
        episodes: Default number of episodes of each condition.
        scores: Means that each condition compares.
        knowledge: Files below ``knowledge`` that the judged behaviour depends on, besides
            documents of its programs.
        folder: Folder of this package with further code and documents that the judged behaviour
            depends on.
        is_real_time: True if its episodes run in real time, so that one process measures them.
    """

    name: str
    title: str
    conditions: tuple[JudgedCondition, ...]
    measure: Measure
    body: BodyChoice = BULLET
    episodes: int = 20
    scores: tuple[Score, ...] = ()
    knowledge: tuple[str, ...] = ()
    folder: str | None = None
    is_real_time: bool = False

    @property
    def programs(self) -> tuple[str, ...]:
        """Names of the programs, in the order of the conditions."""
        names = dict.fromkeys(condition.program for condition in self.conditions)
        return tuple(name for name in names if name)
