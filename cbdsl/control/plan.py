"""Plan: slots of all controllers of a program, in arrays that compiled code shares."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.conditions.condition_plan import ConditionPlan
from cbdsl.control.conditions.onset import ONSET, OnsetForm
from cbdsl.control.conditions.predicate import PREDICATE, ROOM, reset, room_of
from cbdsl.control.potential import Potential, address_of
from cbdsl.control.slot import SLOT, reset_slot
from cbdsl.numeric.arrays import Floats, Integers, Records


class PlanArrays(NamedTuple):
    """Slots of all controllers in the form of compiled code; see ``ControllerPlan``.

    Attributes:
        slots: Slots, shape (s,) of ``slot.SLOT``.
        parameters: Parameters of their potentials.
        before: Displacements of their task coordinates in the preceding tick.
        windows: Windows of their predicates.
        listed: Joints that searches observe.
        onsets: Load changes that slots wait for, shape (o,) of ``onset.ONSET``.
        conditions, operations, terms: Records of ``condition_plan.ConditionPlan``.
    """

    slots: Records
    parameters: Floats
    before: Floats
    windows: Floats
    listed: Integers
    onsets: Records
    conditions: Records
    operations: Records
    terms: Records


class SlotForm(NamedTuple):
    """Constants of a slot.

    Attributes:
        potential: Potential of the controller.
        bounds: Gain and bounds from ``rate.bounds_of``, shape (6,).
        settings: Settings of the predicate from ``predicate.settings_of``.
        feedback: Number of the row of its feedback.
        reference: Number of the row of its reference; -1 for none.
        funnel: Height, the lateral error within which it ends, m, and slope.
        search: Behaviour while its feedback is undefined, or ``None``.
        requires: True if another controller is required.
        anchor: Number of the row that stores the feedback at activation; -1 for none.
        offset: Number of the row of its displacement.
        turned: True if the displacement is a rotation.
        onset: Load change before which it is undefined, or ``None``.
        watches: True if it is defined although no joint displaces its feedback.
        carried: True for the position of an object that moves with the hands that hold it.
        spin: Axis of the tip, 0 to 2, about which the task lets it turn; -1 for none.
        tolerance: Largest error at rest, in the unit of the feedback.
        share: Largest error at rest as a share of the reference's norm.
        lags: True for a feedback that moves with the positions of joints, unlike a force.
    """

    potential: Potential
    bounds: Floats
    settings: Floats
    feedback: int
    reference: int
    funnel: Sequence[float] = (0.0, 0.0, 0.0)
    search: Search | None = None
    requires: bool = False
    anchor: int = -1
    offset: int = -1
    turned: bool = False
    onset: OnsetForm | None = None
    watches: bool = False
    carried: bool = False
    spin: int = -1
    tolerance: float = math.inf
    share: float = math.inf
    lags: bool = False

    @property
    def carrier(self) -> int:
        """Number of the row of the tip whose motion an onset observes; -1 for none."""
        return -1 if self.onset is None else self.onset.tip


class Search(NamedTuple):
    """Behaviour of a controller while its feedback is undefined.

    Attributes:
        follows: True if it waits for another controller.
        within: Largest error of that controller that starts the search, in the unit of its error.
        until: Position of all ``joints`` beyond which the search ends without success, rad or m.
        joints: Indices of the joints; empty for a search without end.
        closing: 1 if beyond is above, -1 if it is below.
    """

    follows: bool
    within: float
    until: float
    joints: Sequence[int]
    closing: float = 1.0


class ControllerPlan:
    """Slots of controllers, with constant numbers.

    Attributes:
        slots: Slots, shape (s,) of ``slot.SLOT``.
        parameters: Parameters of the potentials.
        before: Displacements of task coordinates in the preceding tick.
        windows: Windows of the predicates.
        listed: Joints that searches observe.
        onsets: Onsets, shape (o,) of ``onset.ONSET``.
        conditions: Conditions of the programs.
        version: Counter that changes with the arrays.
        notes, predicates, seeking: Views of ``slots``, shapes (s, 6), (s,) and (s,).
    """

    def __init__(self) -> None:
        self.onsets: NDArray[Any] = np.zeros(0, ONSET)
        self.slots: NDArray[Any] = np.zeros(0, SLOT)
        self.parameters, self.before, self.windows = np.zeros(0), np.zeros(0), np.zeros(0)
        self.listed: Integers = np.zeros(0, dtype=np.int64)
        self.conditions = ConditionPlan()
        self.version = 0
        self._take_parts()
        self._functions: list[Any] = []

    def add(self, form: SlotForm) -> int:
        """Add a slot for a controller; return its number.

        Raises:
            PotentialError: If the function is not a valid potential.
        """
        potential, number, room = form.potential, len(self.slots), room_of(form.settings)
        search = form.search or Search(False, math.nan, math.nan, ())
        slot = np.zeros(1, SLOT)
        slot["address"] = address_of(potential.function)
        slot["rule"], slot["identity"] = potential.rule, potential.identity
        slot["feedback"], slot["reference"] = form.feedback, form.reference
        slot["parameter"], slot["parameters"] = len(self.parameters), len(potential.parameters)
        slot["start"], slot["size"] = len(self.before), potential.size
        slot["phi"] = slot["error"] = math.nan
        slot["bounds"], slot["funnel"] = form.bounds, form.funnel
        slot["window"], slot["settings"] = len(self.windows), form.settings
        slot["notes"][0, ROOM] = room
        reset(slot["notes"][0])
        slot["seeks"], slot["follows"] = form.search is not None, search.follows
        slot["within"], slot["until"] = search.within, search.until
        slot["joint"], slot["joints"] = len(self.listed), len(search.joints)
        slot["closing"], slot["object"] = search.closing, -1
        slot["requires"] = form.requires
        slot["anchor"], slot["offset"] = form.anchor, form.offset
        slot["watches"] = form.watches
        slot["carried"], slot["spin"] = form.carried, form.spin
        slot["tolerance"], slot["share"] = form.tolerance, form.share
        slot["side"], slot["lags"] = potential.side, form.lags
        slot["turned"], slot["onset"] = form.turned, self._wait(form.onset)
        self.slots = np.concatenate((self.slots, slot))
        self.parameters = np.concatenate((self.parameters, potential.parameters))
        self.before = np.concatenate((self.before, np.zeros(potential.size)))
        self.windows = np.concatenate((self.windows, np.zeros(room)))
        self.listed = np.concatenate((self.listed, np.array(search.joints, dtype=np.int64)))
        # Machine code lives as long as its dispatcher.
        self._functions.append(potential.function)
        self.version += 1
        self._take_parts()
        return number

    def _take_parts(self) -> None:
        """Update the views of the slots that are read in every tick."""
        self.notes: Integers = self.slots["notes"]
        self.predicates: Integers = self.notes[:, PREDICATE]
        self.seeking: NDArray[np.bool_] = self.slots["seeking"]

    def reset(self, number: int) -> None:
        """Reset a slot when its controller becomes idle."""
        reset_slot(self.slots, number, self.before, self.onsets)

    @property
    def arrays(self) -> PlanArrays:
        """Arrays in the form of compiled code; valid for one version."""
        own = (self.slots, self.parameters, self.before, self.windows, self.listed, self.onsets)
        also = self.conditions
        return PlanArrays(*own, also.conditions, also.operations, also.terms)

    def _wait(self, form: OnsetForm | None) -> int:
        """Store a slot's load change; return its number, -1 for ``None``."""
        if form is None:
            return -1
        record = np.array([form.record()], ONSET)
        self.onsets = np.concatenate((self.onsets, record))
        return len(self.onsets) - 1
