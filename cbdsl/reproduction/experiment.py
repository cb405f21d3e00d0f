"""An experiment: a name, a place in the source, and a module that measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Protocol

from cbdsl.reproduction.quantity import Quantity

Progress = Callable[[int, int], None]
"""Told how many of how many parts of about the same length are done."""


def _silent(done: int, total: int) -> None:
    """Nobody watches."""


@dataclass(frozen=True)
class RunSettings:
    """How to run an experiment.

    Attributes:
        seed: of everything random; the same seed gives the same outcome.
        quick: a smaller variant that shows that it works; its numbers prove nothing.
        progress: told while it runs.
        backend: what embodies the robot in experiments that let it be chosen.
        trials: how many times it learns from zero, or runs each program; ``None`` for as many as
            the backend is fast enough for, see ``trial_runner``.
        folder: where trials and episodes are kept, episode by episode, and gone on with.
        cameras: kind of the backend's cameras, its own choice when ``None``.
        only: the number of the only trial to run, where others run the others.
    """

    seed: int = 0
    quick: bool = False
    progress: Progress = _silent
    backend: str = "kinematic"
    trials: int | None = None
    folder: Path = Path()
    cameras: str | None = None
    only: int | None = None


class Picture(Protocol):
    """A picture of an experiment, such as a chart.

    Attributes:
        name: of its file, without suffix.
        title: what it shows.
    """

    @property
    def name(self) -> str: ...

    @property
    def title(self) -> str: ...

    def svg(self) -> str:
        """The picture, as the text of an SVG file."""
        ...

    def data(self) -> dict[str, object]:
        """The data of the picture, for scripts."""
        ...


@dataclass(frozen=True)
class Result:
    """The result of an experiment.

    Attributes:
        quantities: our numbers beside the source's.
        charts: the pictures.
        notes: how it was done, and what differs from the source; whole sentences.
    """

    quantities: tuple[Quantity, ...]
    charts: tuple[Picture, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Experiment:
    """One experiment of the source.

    Attributes:
        name: such as ``fig-3.4``.
        title: what it shows.
        section: where the source has it.
        module: in this package, whose function ``run(settings: RunSettings) -> Result`` measures,
            or raises BackendError or EpisodeError where the simulator cannot run it.
        learns: whether the robot learns in it. Then the module measures all experiments of its
            kind: ``run(settings: RunSettings, name: str) -> Result``, and raises JournalError where
            the folder of the settings holds other trials. ``series_of(name)`` are its series of
            trials, and ``gather(dexter: TrialRunner, settings: RunSettings, name: str)`` runs all
            that ``run`` needs, which then reads it from the folder.
        keeps: whether it keeps episodes in the folder of the settings without learning from them;
            ``trials`` then says how often it runs each program.
        backend: where it runs unless another one is chosen; empty where that is no choice.
    """

    name: str
    title: str
    section: str
    module: str
    learns: bool = False
    keeps: bool = False
    backend: str = ""

    def imported(self) -> ModuleType:
        """Its module; see ``load`` for what that may take."""
        return import_module(f"{__package__}.{self.module}")

    def load(self) -> Callable[[RunSettings], Result]:
        """The module that measures; its import may take a second and make the simulator print.

        Raises:
            ImportError: something is not installed that it needs.
        """
        run = self.imported().run
        measure: Callable[[RunSettings], Result] = (
            partial(run, name=self.name) if self.learns else run
        )
        return measure
