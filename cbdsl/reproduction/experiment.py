"""What an experiment is: a name, a place in the source, and a module that measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from cbdsl.reproduction.chart import Chart
from cbdsl.reproduction.quantity import Quantity

Progress = Callable[[int, int], None]
"""Told how many of how many parts of about the same length are done."""


def _silent(done: int, total: int) -> None:
    """Nobody watches."""


@dataclass(frozen=True)
class Settings:
    """How to run an experiment.

    Attributes:
        seed: of everything random; the same seed gives the same outcome.
        quick: a smaller variant that shows that it works; its numbers prove nothing.
        progress: told while it runs.
    """

    seed: int = 0
    quick: bool = False
    progress: Progress = _silent


@dataclass(frozen=True)
class Outcome:
    """What an experiment found.

    Attributes:
        quantities: our numbers beside the source's.
        charts: the curves.
        notes: how it was done, and what differs from the source; whole sentences.
    """

    quantities: tuple[Quantity, ...]
    charts: tuple[Chart, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Experiment:
    """One experiment of the source.

    Attributes:
        name: such as ``fig-3.4``.
        title: what it shows.
        section: where the source has it.
        module: in this package, whose function ``run(settings: Settings) -> Outcome`` measures,
            or raises BackendError or SensorError where the simulator cannot run it.
    """

    name: str
    title: str
    section: str
    module: str

    def load(self) -> Callable[[Settings], Outcome]:
        """What measures; importing it may take a second, and make the simulator print.

        Raises:
            ImportError: something is not installed that it needs.
        """
        run: Callable[[Settings], Outcome] = import_module(f"{__package__}.{self.module}").run
        return run
