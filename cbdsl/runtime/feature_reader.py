"""Reader of the features of an action when it begins to act on them (Section 6.2.2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.tick import Tick
from cbdsl.types.resource import Resource

# Images come at most every fourth tick, and visual signals do not change in between.
_EVERY = 4


class FeatureReader(EpisodeObserver):
    """Reader of features, once, at the first moment of an episode when all are defined.

    If there is no such moment, it reads them when most of them are defined. A feature that is
    drawn, such as a point of a surface, is the sample of the controller that goes there.

    Args:
        features: Resources by name.
        watched: Resources of which only the defined time is recorded, by name.

    Attributes:
        values: Components of the defined features, in SI, by name.
        seconds: Time for which each of ``watched`` was defined, s, by name.
    """

    def __init__(
        self, features: Mapping[str, Resource], watched: Mapping[str, Resource] | None = None
    ) -> None:
        self._features, self._watched = features, watched or {}
        self.values: dict[str, tuple[float, ...]] = {}
        self.seconds = dict.fromkeys(self._watched, 0.0)
        self._ticks, self._time = 0, 0.0

    def note_tick(self, tick: Tick) -> None:
        """Read the features that are still to be read."""
        self._ticks += 1
        if self._ticks % _EVERY:
            return
        passed, self._time = tick.observation.time - self._time, tick.observation.time
        for name, resource in self._watched.items():
            if tick.signals.read(resource) is not None:
                self.seconds[name] += passed
        if len(self.values) < len(self._features):
            now = dict(self._defined(tick))
            # A later moment replaces an earlier one only if more features are defined.
            if len(now) > len(self.values):
                self.values = now

    def _defined(self, tick: Tick) -> Iterator[tuple[str, tuple[float, ...]]]:
        for name, resource in self._features.items():
            if resource.is_drawn:
                value = next(_draws(tick, tick.run, resource), None)
            else:
                reading = tick.signals.read(resource)
                value = None if reading is None else tuple(reading.value.ravel().tolist())
            if value is not None:
                yield name, value


def _draws(tick: Tick, run: ProgramRun, resource: Resource) -> Iterator[tuple[float, ...]]:
    """Yield the points that controllers of a program have drawn as references."""
    table = tick.signals.table
    for controller in run.runs:
        own = controller.rows.declared
        if controller.controller.reference == resource and table.is_defined(own):
            yield tuple(table.values(own).tolist())
    for child in run.children.values():
        yield from _draws(tick, child, resource)
