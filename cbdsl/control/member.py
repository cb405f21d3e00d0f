"""One controller as the compiled tick knows it: its plan, its signals and what it made of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.composition import Integers
from cbdsl.control.kernel import DUTY, IS_POSTURE, RAISED, REST, STAMP
from cbdsl.control.potential import ALIGNMENT, MANIPULABILITY, Potential
from cbdsl.control.predicate import QuiescenceMonitor
from cbdsl.control.task import Task
from cbdsl.sensing.reading import Reading


class Member:
    """What one controller acts by, and what came of it, in arrays.

    Its arrays are its own until ``gather`` keeps them together with those of others.

    Args:
        potential: of the controller.
        task: of the controller.
        monitor: of the controller.
        joints: how many actuated joints there are.

    Attributes:
        plan: see ``cbdsl.control.kernel``, shape (7,).
        constants: of the potential, shape (r, m).
        sources: which joint each component of a configuration is, shape (m,).
        value: of the feedback, shape (m,); a rotation row by row, shape (9,).
        reference: what the value shall become, shape (m,).
        jacobian: of the feedback by all joints, shape (rows, joints).
        outcome: see ``cbdsl.control.kernel``, shape (3,); NaN while undefined.
        task, monitor: as above.
        arrays: of all members that were gathered, as ``act_all`` takes them.
        row: which of theirs are this member's.
    """

    arrays: tuple[NDArray[Any], ...]
    row: int

    def __init__(
        self, potential: Potential, task: Task, monitor: QuiescenceMonitor, joints: int
    ) -> None:
        self.task, self.monitor = task, monitor
        compiled = potential.compiled
        # A curvature has too many numbers to be copied.
        self.is_compiled = compiled is not None and compiled.kind != MANIPULABILITY
        kind, components, rows, self.constants = 0, 0, 0, np.zeros((0, 0))
        if compiled is not None and self.is_compiled:
            kind, self.constants = compiled
            components, rows = (9, 3) if kind == ALIGNMENT else (potential.size, potential.size)
        self.plan = np.array((kind, potential.size, components, rows, 0, REST, 0))
        self.sources: Integers = np.zeros(components, dtype=np.int64)
        self.value, self.reference = np.zeros(components), np.zeros(components)
        self.jacobian = np.zeros((rows, joints))
        self.outcome = np.array((math.nan, math.nan, 0.0))
        self._duty = REST

    def aim(self, reference: Reading) -> bool:
        """Take in a reference; returns whether its shape fits."""
        fits = self.is_compiled and reference.value.size == self.value.size
        if fits:
            self.reference[:] = reference.value.ravel()
        return fits

    def follow_joints(self, sources: Integers) -> None:
        """Have joints, shape (m,), as feedback, which is then read tick by tick.

        Args:
            sources: their indices among all actuated ones, shape (m,).
        """
        self.sources[:] = sources
        self.jacobian[np.arange(len(sources)), sources] = 1.0
        self.plan[IS_POSTURE] = 1

    def feel(self, feedback: Reading, stamp: int, raised: float) -> bool:
        """Take in a feedback; returns whether its shape fits.

        Args:
            feedback: with its Jacobian by all joints.
            stamp: of the newest measurement, of the feedback's and of the reference's.
            raised: how far above its reference a position is sent to, m.
        """
        value, jacobian = feedback.value, feedback.jacobian
        if value.size != self.value.size or jacobian.shape != self.jacobian.shape:
            return False
        self.value[:] = value.ravel()
        self.jacobian[:] = jacobian
        self.plan[STAMP] = stamp
        self.outcome[RAISED] = raised
        return True

    @property
    def duty(self) -> int:
        """``REST``, ``FOLLOW``, ``SEEK`` or ``DONE``."""
        return self._duty

    @duty.setter
    def duty(self, duty: int) -> None:
        if duty != self._duty:
            self._duty = self.plan[DUTY] = duty

    def forget(self) -> None:
        """Have no potential, as while the feedback is undefined."""
        self.outcome[:RAISED] = math.nan
