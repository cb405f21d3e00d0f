"""Experiment: a name, a place in the source, and a module that measures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Protocol

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.quantity import Quantity

Progress = Callable[[int, int], None]
"""Callback for the numbers of finished and of all parts, which take about the same time."""


def _silent(done: int, total: int) -> None:
    """Ignore the progress."""


@dataclass(frozen=True)
class RunSettings:
    """Settings of the run of an experiment.

    Attributes:
        seed: Seed of all random numbers; the same seed gives the same outcome.
        quick: True for a smaller variant that only demonstrates the procedure.
        progress: Callback for the progress of the run.
        backend: Backend that embodies the robot, in experiments with a choice of backends.
        trials: Number of times that it learns from zero, or runs each program; ``None`` for a
            number that suits the speed of the backend, see ``trial_runner``.
        folder: Folder in which trials and episodes are stored and resumed, episode by episode.
        cameras: Kind of the backend's cameras; ``None`` for the backend's default.
        only: Number of the only trial to run, if other processes run the others.
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
    """Picture of an experiment, such as a chart.

    Attributes:
        name: Name of its file, without suffix.
        title: Title of the picture.
    """

    @property
    def name(self) -> str: ...

    @property
    def title(self) -> str: ...

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        ...

    def data(self) -> dict[str, object]:
        """Return the data of the picture, for scripts."""
        ...


@dataclass(frozen=True)
class Result:
    """Result of an experiment.

    Attributes:
        quantities: Our numbers beside the numbers of the source.
        charts: Pictures.
        notes: Method, and differences from the source, in whole sentences.
    """

    quantities: tuple[Quantity, ...]
    charts: tuple[Picture, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Experiment:
    """Experiment of the source.

    Attributes:
        name: Name, such as ``fig-3.4``.
        title: Subject of the experiment.
        section: Section of the source.
        module: Module in this package, whose ``CLAIMS`` has the claims by experiment. Its function
            ``run(settings: RunSettings) -> Result`` measures, or raises BackendError or
            EpisodeError if the simulator cannot run it.
        learns: True if the robot learns. The module then measures all experiments of its kind:
            ``run(settings: RunSettings, name: str) -> Result``. It raises JournalError if the
            folder of the settings holds other trials. ``series_of(name)`` returns its series of
            trials. ``gather(dexter: TrialRunner, settings: RunSettings, name: str)`` runs all
            episodes that ``run`` needs, which then reads them from the folder.
        keeps: True if it stores episodes in the folder of the settings without learning from
            them; ``trials`` is then the number of runs of each program.
        backend: Default backend; empty if the backend cannot be chosen.
    """

    name: str
    title: str
    section: str
    module: str
    learns: bool = False
    keeps: bool = False
    backend: str = ""

    def imported(self) -> ModuleType:
        """Import the module of the experiment; see ``load`` for the cost."""
        return import_module(f"{__package__}.{self.module}")

    def claims(self) -> Sequence[Claim]:
        """Return the reports of the source that it measures; imports the module."""
        claims: Sequence[Claim] = self.imported().CLAIMS[self.name]
        return claims

    def load(self) -> Callable[[RunSettings], Result]:
        """Return the function that measures; the import may take a second and print messages.

        Raises:
            ImportError: A package that it needs is not installed.
        """
        run = self.imported().run
        measure: Callable[[RunSettings], Result] = (
            partial(run, name=self.name) if self.learns else run
        )
        return measure
