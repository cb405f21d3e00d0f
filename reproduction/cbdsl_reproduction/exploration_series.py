"""Explorations of the source's Chapter 6, as data."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from cbdsl import ExploreRequest
from cbdsl.api.shipped import shipped_folder

# The sum of all elements of a covariance (Section 6.1).
_MEASURE = {"measure": "sum"}


class ExploredAction(NamedTuple):
    """Action of a series.

    Attributes:
        name: Name in the catalog.
        program: Name of the program that runs.
        values: Values of its parameters; ``?`` for a channel that is found while it runs.
    """

    name: str
    program: str
    values: Mapping[str, str] = {}

    @property
    def text(self) -> str:
        """Argument of ``cb explore`` for the action."""
        values = ",".join(f"{key}={value}" for key, value in self.values.items())
        return f"{self.name}={self.program}" + (f":{values}" if values else "")


@dataclass(frozen=True)
class ExplorationSeries:
    """Series of explorations of one world, each from zero.

    Attributes:
        name: Name of the files of its trials.
        label: Label in tables and pictures.
        feature: Channel that identifies the object.
        stage: Name of the stage.
        explored: Available actions.
        algorithm: Algorithm that chooses actions.
        constants: Constants of the algorithm that differ from the source's, as text.
        actions: Number of actions of each exploration, as in the source.
        trials: Number of trials, as in the source, which drew most of them from its models.
        grown_from: Preceding exploration with fewer available actions; ``actions`` are added to
            the actions of that exploration.
    """

    name: str
    label: str
    feature: str
    stage: str
    explored: tuple[ExploredAction, ...]
    algorithm: str = "explore_catalog"
    constants: Mapping[str, str] = field(default_factory=dict)
    actions: int = 100
    trials: int = 25
    grown_from: ExplorationSeries | None = None

    @property
    def settings(self) -> Mapping[str, str]:
        """Constants of the algorithm that differ from its defaults, as text."""
        return _MEASURE | dict(self.constants)

    def command(self, seed: int, actions: int, backend: str, cameras: str | None) -> str:
        """Return the command line of ``cb explore`` for the same exploration."""
        words = ["cb", "explore", *(each.text for each in self.explored)]
        words += ["--out", f"{self.name}.yaml", "--stage", self.stage, "--feature", self.feature]
        words += ["--seed", str(seed), "--backend", backend]
        words += ["--cameras", cameras] if cameras is not None else []
        words += ["--algorithm", self.algorithm] if self.algorithm != "explore_catalog" else []
        words += [f"--set={name}={value}" for name, value in self.settings.items()]
        words += ["--join"] if self.grown_from is not None else []
        return shlex.join([*words, "--actions", str(actions)])

    def request(self, path: Path) -> ExploreRequest:
        """Return the request of one exploration, without backend and seed."""
        return ExploreRequest(
            programs=[each.text for each in self.explored],
            stage=self.stage,
            out=path,
            feature=self.feature,
            actions=self.actions,
            algorithm=self.algorithm,
            constants=self.settings,
            join=self.grown_from is not None,
            folder=shipped_folder(),
        )


# Value of a parameter for each channel that a run detects.
_OPEN = "?"

_LOOK = ExploredAction("searchtrack", "searchtrack")
_TOUCH = ExploredAction("reachtouch", "reachtouch")
_BOTH = ExploredAction("bimanualtouch", "bimanualtouch")
_INSPECT = ExploredAction("visualinspect", "visualinspect", {"mark": _OPEN})
_SURFACE = ExploredAction("reachtouch", "touch_table")


def _reaching(*colors: str) -> tuple[ExploredAction, ...]:
    return tuple(
        ExploredAction(f"reachtouch_{color}", "reachtouch", {"feature": color}) for color in colors
    )


# Half of the points of a table are out of reach, and each attempt takes 8 s. With a limit of 60 s,
# one in twelve of 423 touches was still searching for another point at the end.
_SEARCHED = {"longest": "120 s"}

TABLE = ExplorationSeries(
    "table",
    "green table",
    "green",
    "exploring_table",
    (_LOOK, _SURFACE, _BOTH, _INSPECT),
    constants=_SEARCHED,
)
BASKETBALL = ExplorationSeries(
    "basketball", "basketball", "yellow", "exploring_basketball", (_LOOK, _TOUCH, _BOTH, _INSPECT)
)
RED_BALL = ExplorationSeries(
    "red_ball", "red ball", "red", "exploring_red_ball", (_LOOK, _TOUCH, _BOTH, _INSPECT)
)


def _placed(known: ExplorationSeries, goal: str) -> ExplorationSeries:
    """Return the same series with a pad in the world; PICKANDPLACE is added later."""
    # No object has the obstacle's colour: a patch of the ball's own colour would repel the ball.
    values = {"goal": goal, "obstacle": "hue_9"}
    beside = replace(known, name=f"{known.name}_beside_pad", stage=f"{known.stage}_and_pad")
    return replace(
        beside,
        name=f"{known.name}_placed",
        explored=(*known.explored, ExploredAction("pick_and_place", "pick_and_place", values)),
        actions=50,
        grown_from=beside,
    )


TABLE_PLACED = _placed(TABLE, "blue")
BASKETBALL_PLACED = _placed(BASKETBALL, "green")
RED_BALL_PLACED = _placed(RED_BALL, "green")
TABLE_MODELS = ExplorationSeries(
    "table_models",
    "green table",
    "green",
    "exploring_table",
    (_LOOK, _SURFACE),
    "explore_models",
    _SEARCHED,
)
THREE_BALLS = ExplorationSeries(
    "scattered_balls",
    "three balls",
    "red",
    "scattered_balls",
    _reaching("red", "yellow", "blue"),
    "explore_models",
)
NOVEL = ExplorationSeries(
    "novel_and_surprising",
    "novelty and surprise",
    "red",
    "novel_and_surprising",
    _reaching("red", "blue"),
    "explore_models",
)
