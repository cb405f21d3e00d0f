"""Preparation of a controller before the tick: samples, changed references, solved fields."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module

import numpy as np

from cbdsl.control.potential import Potential
from cbdsl.control.potentials.field import NoPathError
from cbdsl.control.signal import require_finite
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Ball, Controller, Modifier, Relative
from cbdsl.runtime.controllers.controller_rows import ControllerRows
from cbdsl.sensing.density import Sampler
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.resource import Resource

Change = Callable[[Floats, Floats, float, Mapping[str, float]], Floats]


class Preparation:
    """Preparation of one controller's rows and parameters in Python, before the compiled tick.

    Attributes:
        samples: True if the reference is drawn from an internal model or a surface.
        computes: True if a preparation uses the signals of this tick.
        is_needed: True if there is anything to prepare.
        no_path: Reason why no free path leads to the reference; empty if one does.
        moves: True if the potential states that the controller is not at rest in this tick.
    """

    def __init__(
        self, controller: Controller, signals: Signals, rows: ControllerRows, potential: Potential
    ) -> None:
        reference = controller.reference
        self._controller, self._signals, self._rows = controller, signals, rows
        self._solve = potential.prepare
        self._changes = [
            (each, change_of(each))
            for each in controller.modifiers
            if MODIFIERS.get(each.name).implementation
        ]
        self.samples = controller.is_drawn
        is_anchored = isinstance(reference, Relative) and reference.base is None
        # References drawn or stored at each activation.
        self._is_renewed = self.samples or is_anchored
        self.computes = bool(self._changes) or self._solve is not None
        self.is_needed = self.samples or self.computes
        self.no_path, self.moves = "", False

    def begin(self, rng: np.random.Generator) -> None:
        """Begin an episode with ``rng`` as the source of all samples."""
        self._rng = rng
        self._sampler: Sampler | None = None

    def forget(self) -> None:
        """Forget the sample, the value at activation and the path after deactivation."""
        self.no_path = ""
        if self._is_renewed:
            self._signals.table.forget(self._rows.declared)

    def draw(self) -> None:
        """Draw the reference if it is a sample and not drawn yet."""
        if not self.samples or self._signals.table.is_defined(self._rows.declared):
            return
        drawn = self._sample()
        if drawn is not None:
            self._signals.table.write(self._rows.declared, Reading(drawn, None, 0))

    def prepare(self, parameters: Floats) -> bool:
        """Change the reference and solve the field, once the rows are of this tick.

        Args:
            parameters: Parameters of the controller's potential; a field writes to them.

        Returns:
            True if the controller can act.

        Raises:
            SignalError: If the reference is not finite; the message names it.
        """
        table, rows, self.moves = self._signals.table, self._rows, False
        if self._changes:
            self._change_reference()
        if self._solve is None or not all(map(table.is_defined, (rows.feedback, rows.reference))):
            return True
        try:
            value, goal = self._ends()
            self.moves = bool(self._solve(value, goal, tuple(self._obstacles(goal)), parameters))
        # Without a path the controller is undefined in this tick, and the next tick tries again.
        except NoPathError as failure:
            self.no_path = str(failure)
            return False
        self.no_path = ""
        return True

    def _sample(self) -> Floats | None:
        resource = self._controller.reference
        assert isinstance(resource, Resource)
        if self._sampler is None:
            self._sampler = self._signals.sampler(resource, self._rng)
        return self._sampler.draw()

    def _change_reference(self) -> None:
        """Write the reference as changed by the modifiers."""
        table, signals, rows = self._signals.table, self._signals, self._rows
        if not table.is_defined(rows.declared):
            table.forget(rows.reference)
            return
        record, feedback = table.records[rows.declared], table.values(rows.feedback).copy()
        value = table.values(rows.declared).copy()
        for modifier, change in self._changes:
            try:
                changed = change(value, feedback, signals.time, dict(modifier.options))
                value = np.broadcast_to(changed, value.shape)
            except Exception as error:
                raise _fault(modifier, error) from error
        # A reference that may move in every tick has the time stamp of the posture.
        table.write(rows.reference, Reading(value, None, signals.tips.stamp, record["radius"]))

    def _ends(self) -> tuple[Floats, Floats]:
        """Return start and goal of a path."""
        name, table = self._controller.feedback.name, self._signals.table
        value, goal = table.values(self._rows.feedback), table.values(self._rows.reference)
        require_finite(goal, f"the reference of {name}")
        require_finite(value, f"the value of {name}")
        return value, goal

    def _obstacles(self, goal: Floats) -> Iterator[Obstacle]:
        """Yield the current obstacles; an unseen and untouched obstacle is absent."""
        field = self._controller.field
        if field is None:
            return
        for obstacle in field.obstacles:
            if not isinstance(obstacle, Ball):
                lower, upper = np.array(obstacle.lower), np.array(obstacle.upper)
                box = Obstacle(obstacle.name, lower, upper)
                if obstacle.shaft is None:
                    yield box
                else:
                    yield from box.around(goal, obstacle.shaft + field.clearance)
                continue
            reading = self._signals.read(obstacle.resource)
            if reading is not None:
                require_finite(reading.value, f"the obstacle {obstacle.resource.name}")
                radius = reading.radius if obstacle.radius is None else obstacle.radius
                yield Obstacle.sphere(obstacle.resource.name, reading.value, radius)


def change_of(modifier: Modifier) -> Change:
    """Return the function that changes a reference.

    Raises:
        PluginError: If the modifier's package does not have it.
    """
    module, function = MODIFIERS.get(modifier.name).implementation.split(":")
    try:
        change: Change = getattr(import_module(module), function)
    except Exception as error:
        raise _fault(modifier, error) from error
    return change


def _fault(modifier: Modifier, error: Exception) -> Exception:
    return MODIFIERS.fault(modifier.name, f"{type(error).__name__}: {error}")
