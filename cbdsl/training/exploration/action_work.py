"""Exploration under way: the choice of an action, its outcome and its evaluation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple, Protocol

import numpy as np

from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.learning.catalogs.exploration import Exploration, ExplorationStep

# Stream of an action's seed for choices, beside the world (0) and the program's draws (1).
_CHOICE = 2


class FinishedAction(NamedTuple):
    """Finished action of an exploration.

    Attributes:
        outcome: Outcome of the action.
        step: Evaluation of the outcome.
    """

    outcome: ActionOutcome
    step: ExplorationStep


class Course(Protocol):
    """Course of an exploration: its seeds and its end.

    Attributes:
        seed: Seed of all random numbers.
        number: Number of this exploration among several with this seed.
        count: Largest number of actions.
        until_habituated: True if it ends early when all models have habituated.
    """

    @property
    def seed(self) -> int: ...
    @property
    def number(self) -> int: ...
    @property
    def count(self) -> int: ...
    @property
    def until_habituated(self) -> bool: ...


class ActionWork(ABC):
    """Exploration under way.

    Args:
        exploration: Exploration before its first action.
        course: Seeds and end of the exploration.
        renderer: Name of the renderer of the images.

    Attributes:
        exploration: Exploration with its present knowledge.
        renderer: Name of the renderer of the images.
        finished: Finished actions.
    """

    def __init__(self, exploration: Exploration, course: Course, renderer: str) -> None:
        self.exploration, self._course, self.renderer = exploration, course, renderer
        self.finished: list[FinishedAction] = []

    @property
    def number(self) -> int:
        """Number of this exploration among several with its seed."""
        return self._course.number

    @property
    def outcomes(self) -> list[ActionOutcome]:
        """Outcomes of the finished actions."""
        return [action.outcome for action in self.finished]

    @property
    def is_over(self) -> bool:
        """True if no action is left."""
        is_done = self._course.until_habituated and self.exploration.is_over
        return is_done or len(self.finished) >= self._course.count

    def run_next(self) -> ActionOutcome:
        """Choose and run an action."""
        # The place of the action in its exploration determines the seed, so a resumed exploration
        # goes on with the same seeds.
        entropy = [self._course.seed, self._course.number, len(self.finished)]
        seed = int(np.random.SeedSequence(entropy).generate_state(1)[0])
        name = self.exploration.choose(np.random.default_rng([seed, _CHOICE]))
        return self.act(name, seed)

    @abstractmethod
    def act(self, name: str, seed: int) -> ActionOutcome:
        """Run an action, which reports its own errors in its outcome.

        Args:
            name: Name of the action.
            seed: Seed of all its random numbers.
        """

    def note(self, row: ActionOutcome) -> FinishedAction:
        """Learn from an outcome."""
        action = FinishedAction(row, self.exploration.note(row))
        self.finished.append(action)
        return action
