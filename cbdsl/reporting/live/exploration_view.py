"""Live view of an exploration: its episodes, and the growing catalog (Chapter 6)."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

from cbdsl.learning.catalogs.action_outcome import NOOP
from cbdsl.learning.catalogs.affordance import Affordance
from cbdsl.learning.catalogs.exploration import Exploration, ExplorationObserver
from cbdsl.numeric.proportion import exact_interval
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.reporting.drawing.catalog_icon import Layer, catalog_icon
from cbdsl.reporting.live.feed import message
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick

# Number of actions in the drawn course.
_DRAWN = 1000


class ExplorationView(ExplorationObserver):
    """Watcher of an exploration for a live page.

    Args:
        view: View of its episodes.
        name: Name of the catalog.
        feature: Channel by which the object is recognized.
        total: Number of requested actions.
    """

    def __init__(self, view: LiveView, name: str, feature: str, total: int) -> None:
        self._view = view
        self._name, self._feature, self._total = name, feature, total
        self._chosen = ""
        self._over = 0
        self._catalog: dict[str, Any] = {}
        # For each past action, the knowledge of each affordance at that time.
        self._course: list[dict[str, tuple[int, float, float | None]]] = []

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """Begin an episode; see ``EpisodeObserver.begin``."""
        self._view.begin(program, stage, seed)

    def note_transition(self, transition: Transition) -> None:
        """Note a transition; see ``EpisodeObserver.note_transition``."""
        self._view.note_transition(transition)

    def note_tick(self, tick: Tick) -> None:
        """Note a tick; see ``EpisodeObserver.note_tick``."""
        self._view.note_tick(tick)

    def note_end(self, result: EpisodeResult) -> None:
        """Note the end of an episode; see ``EpisodeObserver.note_end``."""
        self._view.note_end(result)

    def note_choice(self, name: str) -> None:
        """Note the chosen action; see ``ExplorationObserver.note_choice``."""
        self._chosen = name
        self._tell()

    def note_step(self, exploration: Exploration) -> None:
        """Note a finished action; see ``ExplorationObserver.note_step``."""
        self._chosen, self._over = "", len(exploration.steps)
        known = exploration.affordances
        self._course.append({name: _course(name, exploration) for name in known})
        self._course = self._course[-_DRAWN:]
        layers = [Layer(name, each.tried, each.successes) for name, each in known.items()]
        self._catalog = {
            "icon": catalog_icon(self._name, self._feature, layers),
            "affordances": [_affordance(name, exploration) for name in known],
            "noop": Counter(step.action for step in exploration.steps)[NOOP],
            "course": self._columns(exploration),
        }
        self._tell()

    def _columns(self, exploration: Exploration) -> dict[str, object]:
        """Return the course of the exploration by affordance; null before one was known."""
        course, steps = self._course, exploration.steps[-_DRAWN:]
        columns = {
            name: [each.get(name, (None, None, None)) for each in course]
            for name in exploration.affordances
        }
        return {
            "first": len(exploration.steps) - len(steps) + 1,
            "action": [step.action for step in steps],
            "reward": [_number(step.reward) for step in steps],
            "tried": {name: [tried for tried, _, _ in own] for name, own in columns.items()},
            "probability": {name: [p for _, p, _ in own] for name, own in columns.items()},
            "change": {name: [change for _, _, change in own] for name, own in columns.items()},
        }

    def _tell(self) -> None:
        head = {"name": self._name, "feature": self._feature, "chosen": self._chosen}
        counts = {"over": self._over, "total": self._total}
        self._view.keep(message("catalog", {**head, **counts, **self._catalog}))


def _course(name: str, exploration: Exploration) -> tuple[int, float, float | None]:
    """Return an affordance's trials, its current Pr(reward), and the change of its model."""
    own = exploration.affordances[name]
    change = exploration.change_of(name)
    probability = float(f"{own.reward_probability():.6g}")
    return own.tried, probability, None if change is None else _number(change)


def _affordance(name: str, exploration: Exploration) -> dict[str, object]:
    own = exploration.affordances[name]
    tried, probability, change = _course(name, exploration)
    values = getattr(exploration, "values", {})
    return {
        "name": name,
        "tried": tried,
        "rewarded": own.successes,
        "interval": None
        if not tried
        else [_number(e) for e in exact_interval(own.successes, tried)],
        "probability": probability,
        "ahead": bool(own.ahead),
        "value": _number(values.get(name, 0.0)),
        "change": change,
        "model": _state(own, exploration.is_habituated(name)),
    }


def _state(affordance: Affordance, habituated: bool) -> str:
    if affordance.failed:
        return "left out"
    if affordance.model is None:
        return "none"
    return "habituated" if habituated else "changing"


def _number(value: float) -> float | None:
    # JSON has neither NaN nor infinity. Six digits suffice on a page.
    return float(f"{value:.6g}") if math.isfinite(value) else None
