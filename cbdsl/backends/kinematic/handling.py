"""What the hands do with the thing on show, and what their fingertips feel."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.grasp import STIFFNESS, Grasp
from cbdsl.backends.kinematic.hands import Contact, Hands
from cbdsl.backends.kinematic.thing import Thing
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.presentation import GRAVITY

Floats = NDArray[np.float64]

# A fingertip that is pressed in further holds back the joints of its finger, m.
_DEEPEST = 0.02


class Handling:
    """Hands and the one thing that can be moved, in one episode.

    Attributes:
        contacts: of all fingertips, as of the last step.
    """

    def __init__(self, world: World, hands: Hands, thing: Thing | None) -> None:
        self._world = world
        self._hands = hands
        self._thing = thing
        self._grasp = None if thing is None else Grasp(thing, hands)
        self.contacts: list[Contact] = []
        self._before: dict[tuple[int, str], float] = {}

    @property
    def touched(self) -> bool:
        """Whether a fingertip touches the thing."""
        return any(contact.thing is self._thing for contact in self.contacts)

    def move(self, period: float) -> None:
        """Let the thing go along with whoever holds it, or by itself, for ``period``, s."""
        thing, grasp = self._thing, self._grasp
        if thing is None or grasp is None or thing.name not in self._world.things:
            return
        if thing.gripped:
            thing.shift(period * thing.velocity)
        elif grasp.holders:
            thing.velocity[:] = 0.0
            grasp.follow()
            self._world.land(thing)
        else:
            self._world.let_go(thing, period)

    def touch(self) -> list[int]:
        """Find the contacts of where everything is now.

        Returns:
            The joints of fingertips that are too deep and going deeper.
        """
        self.contacts = self._hands.contacts(self._world)
        return [
            joint
            for contact in self.contacts
            if contact.depth > max(_DEEPEST, self._before.get(_key(contact), 0.0))
            for joint in contact.fingertip.joints.tolist()
        ]

    def press(self) -> Floats:
        """Let the fingertips press on what they touch.

        Returns:
            Force, N, and torque about the fingertip's origin, N m, that each exerts on the world,
            world frame, shape (cells, 6).
        """
        self._before = {_key(contact): contact.depth for contact in self.contacts}
        wrenches = np.zeros((len(self._hands.cells), 6))
        for contact in self.contacts:
            wrenches[contact.fingertip.cell, :3] += STIFFNESS * contact.depth * contact.normal
        thing, grasp = self._thing, self._grasp
        if thing is not None and grasp is not None:
            own = [contact for contact in self.contacts if contact.thing is thing]
            if own and not thing.gripped:
                self._push(thing, own, grasp)
            if own or grasp.holders:
                grasp.update(own)
            self._bear(thing, grasp, own, wrenches)
        return wrenches

    def _push(self, thing: Thing, contacts: list[Contact], grasp: Grasp) -> None:
        """Move the thing sidewise until the fingertips' forces are what friction can balance."""
        force = sum((STIFFNESS * each.depth * each.normal for each in contacts), np.zeros(3))
        force[2] = 0.0
        size = math.hypot(*force.tolist())
        floor = self._world.floor(thing)
        rest = 0.0 if floor is None else thing.mass * thing.resistance(floor)
        excess = size - rest - grasp.stick(contacts)
        if excess <= 0.0:
            return
        along = force / size
        stiffness = STIFFNESS * sum(float(each.normal @ along) ** 2 for each in contacts)
        thing.shift(excess / stiffness * along)

    def _bear(self, thing: Thing, grasp: Grasp, contacts: list[Contact], wrenches: Floats) -> None:
        """Add the weight of what is held in the air, shared evenly by the fingertips."""
        if thing.gripped or not grasp.holders or self._world.floor(thing) is not None:
            return
        holding = [contact for contact in contacts if contact.hand in grasp.holders]
        share = thing.mass * GRAVITY / len(holding)
        for contact in holding:
            x, y, _ = (contact.fingertip.radius * contact.normal).tolist()
            wrenches[contact.fingertip.cell, 2] += share
            # The vertical force acts at the end of this lever.
            wrenches[contact.fingertip.cell, 3] += y * share
            wrenches[contact.fingertip.cell, 4] -= x * share


def _key(contact: Contact) -> tuple[int, str]:
    return contact.fingertip.cell, contact.thing.name
