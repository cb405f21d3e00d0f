"""Manipulation: motion of objects by hands, and the contacts of their fingertips."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.backends.kinematic.grasp import STIFFNESS, Grasp
from cbdsl.backends.kinematic.hands import FingertipContact, Hands
from cbdsl.backends.kinematic.kinematic_object import KinematicObject
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.scenario import GRAVITY
from cbdsl.numeric.arrays import Booleans, Floats
from cbdsl.numeric.compiled import compiled_once

# Depth of a fingertip beyond which the joints of its finger are held back, m.
_DEEPEST = 0.02
# Share of a joint's way in a tick; a joint that is held back below it does not move.
_LEAST_SHARE = 0.1


class Manipulation:
    """Hands and movable objects in one episode.

    Attributes:
        contacts: Contacts of all fingertips, as of the last step.
    """

    def __init__(self, world: World, hands: Hands) -> None:
        self._world = world
        self._hands = hands
        self._grasps: dict[str, Grasp] = {}
        self._touching = self._holding = False
        self._names: tuple[str, ...] = ()
        self._solids = world.solids
        # Results of ``Hands.touch``, now and a tick ago.
        self._contacts, self._before = np.zeros((2, len(hands.cells), 0, 7))
        self._wrenches, self._nothing = np.zeros((2, len(hands.cells), 6))

    @property
    def contacts(self) -> list[FingertipContact]:
        """Contacts of all fingertips, as of the last step."""
        things = list(self._world.things.values())
        return [
            self._hands.contact(tip, things[which], self._contacts[tip, which].tolist())
            for tip, which in np.argwhere(self._contacts[:, :, 0] > 0.0)
        ]

    def touches(self, name: str) -> bool:
        """Return whether a fingertip touches an object, as of the last step."""
        touched = self._touching and name in self._names
        return touched and bool((self._contacts[:, self._names.index(name), 0] > 0.0).any())

    def move(self, period: float) -> None:
        """Move objects with the hands that hold them, or by themselves, for ``period``, s."""
        if self._solids is not self._world.solids:
            self._match()
        self._contacts, self._before = self._before, self._contacts
        for grasp in self._grasps.values():
            if grasp.is_at_rest:
                continue
            with self._world.taking_along(grasp.thing):
                self._move(grasp, period)

    def _move(self, grasp: Grasp, period: float) -> None:
        thing = grasp.thing
        if thing.gripped:
            thing.shift(period * thing.velocity)
        elif grasp.holders:
            thing.velocity[:] = 0.0
            grasp.follow()
            self._world.land(thing)
        else:
            self._world.let_go(thing, period)

    def touch(self) -> bool:
        """Find the contacts at the current poses.

        Returns:
            Whether there are any.
        """
        self._touching = self._hands.touch(self._world, self._contacts)
        return self._touching

    def _match(self) -> None:
        """Match contacts and grasps to a changed set of objects; the others have not moved."""
        names = tuple(self._world.things)
        kept = [name for name in names if name in self._names]
        old = [self._names.index(name) for name in kept]
        new = [names.index(name) for name in kept]
        for which in ("_contacts", "_before"):
            depths = np.zeros((len(self._hands.cells), len(names), 7))
            depths[:, new] = getattr(self, which)[:, old]
            setattr(self, which, depths)
        self._grasps = {
            name: self._grasps[name] if name in self._grasps else Grasp(thing, self._hands)
            for name, thing in self._world.things.items()
            if thing.mass
        }
        self._names, self._solids = names, self._world.solids

    def hold_back(self, share: Floats) -> bool:
        """Shorten the way of joints whose fingertips are too deep and go deeper.

        Args:
            share: Share of its way that each joint goes; halved if it is held back, shape (n,).

        Returns:
            Whether any joint goes less far than before.
        """
        return _held_back(self._contacts, self._before, self._hands.moving, share)

    def press(self) -> Floats:
        """Let the fingertips press on the objects in contact.

        Returns:
            Force, N, and torque about the fingertip's origin, N m, that each exerts on the world,
            world frame, shape (cells, 6); valid until the next step.
        """
        if not self._touching and not self._holding:
            return self._nothing
        wrenches, grasps = self._wrenches, self._grasps.values()
        wrenches.fill(0.0)
        if self._touching:
            _press(self._contacts, STIFFNESS, wrenches)
        for grasp in grasps:
            own = self._of(grasp.thing) if self._touching else []
            if own and not grasp.thing.gripped:
                self._push(own, grasp)
            if own or grasp.holders:
                grasp.update(own)
                self._bear(grasp, own, wrenches)
        self._holding = any(grasp.holders for grasp in grasps)
        return wrenches

    def _of(self, thing: KinematicObject) -> list[FingertipContact]:
        """Return the contacts with an object; none if it has been taken away."""
        if thing.name not in self._names:
            return []
        contacts = self._contacts[:, self._names.index(thing.name)].tolist()
        return [
            self._hands.contact(tip, thing, contact)
            for tip, contact in enumerate(contacts)
            if contact[0] > 0.0
        ]

    def _push(self, contacts: list[FingertipContact], grasp: Grasp) -> None:
        """Move an object sideways until friction can balance the fingertips' forces."""
        thing = grasp.thing
        x = y = 0.0
        # Quasi-static model: each fingertip is a spring along its normal n with the force k e. The
        # object moves along the sum of the level forces until friction of floor and fingers
        # balances it. A shift s in that direction u lessens the sum by k s sum((n . u)^2).
        for each in contacts:
            force = STIFFNESS * each.depth
            x, y = x + force * each.normal[0], y + force * each.normal[1]
        size = math.hypot(x, y)
        floor = self._world.floor(thing)
        rest = 0.0 if floor is None else thing.mass * thing.resistance(floor)
        excess = size - rest - grasp.stick(contacts)
        if excess <= 0.0:
            return
        x, y = x / size, y / size
        along = sum([(each.normal[0] * x + each.normal[1] * y) ** 2 for each in contacts])
        way = excess / (STIFFNESS * along)
        with self._world.taking_along(thing):
            thing.shift(np.array((way * x, way * y, 0.0)))

    def _bear(self, grasp: Grasp, contacts: list[FingertipContact], wrenches: Floats) -> None:
        """Add the friction of the fingertips that hold an object.

        In the air nothing but the fingertips acts on the object. They share its weight evenly, and
        friction across their normals balances the forces along these. The vertical part of this
        friction remains when the object is set down.
        """
        thing = grasp.thing
        if thing.gripped or not grasp.holders:
            return
        holding = [contact for contact in contacts if contact.hand in grasp.holders]
        if self._world.floor(thing) is None:
            forces = _frictions(contacts, holding)
            grasp.rub = float(sum(force[2] for force in forces))
            forces = forces + np.array((0.0, 0.0, thing.mass * GRAVITY / len(holding)))
        else:
            forces = np.tile((0.0, 0.0, grasp.rub / len(holding)), (len(holding), 1))
        for contact, force in zip(holding, forces, strict=True):
            wrench = wrenches[contact.fingertip.cell]
            wrench[:3] += force
            # The force acts at the end of this lever.
            wrench[3:] += contact.fingertip.radius * np.cross(contact.normal, force)


def _frictions(contacts: list[FingertipContact], holding: list[FingertipContact]) -> Floats:
    """Return the friction of the holding contacts that balances all normal forces, N, (m, 3)."""
    pressed = np.zeros(3)
    for each in contacts:
        pressed += STIFFNESS * each.depth * np.array(each.normal)
    normals = np.array([each.normal for each in holding])
    # P = 1 - n n' projects onto the plane across a normal. All fingertips share a vector f with
    # sum(P) f = pressed, and each adds the friction -P f. The sum is singular for opposed normals,
    # hence least squares.
    across = np.eye(3) - normals[:, :, None] * normals[:, None]
    needed = np.linalg.lstsq(across.sum(axis=0), pressed, rcond=1e-6)[0]
    frictions: Floats = -across @ needed
    return frictions


@compiled_once
def _held_back(contacts: Floats, before: Floats, moving: Booleans, share: Floats) -> bool:
    """Lessen the shares, shape (n,), of joints whose fingertips are too deep and go deeper.

    Args:
        contacts: Depths of fingertips in objects, m, first of each row, shape (tips, things, 7).
        before: Depths a tick ago, likewise.
        moving: Joints that move each fingertip, shape (tips, n).
        share: Shares, as in ``Manipulation.hold_back``.
    """
    blocked = np.zeros(len(share), np.bool_)
    for tip in range(contacts.shape[0]):
        for thing in range(contacts.shape[1]):
            # A finger that is too deep may still withdraw.
            if contacts[tip, thing, 0] > max(_DEEPEST, before[tip, thing, 0]):
                blocked |= moving[tip]
    less = False
    for joint in range(len(share)):
        if blocked[joint] and share[joint] > 0.0:
            less = True
            # Halving keeps joints moving that need to yield only a little.
            share[joint] = 0.5 * share[joint] if share[joint] > _LEAST_SHARE else 0.0
    return less


@compiled_once
def _press(contacts: Floats, stiffness: float, wrenches: Floats) -> None:
    """Add the force, N, of each fingertip on all objects in contact, shape (tips, 6).

    Args:
        contacts: Depth, point and inward normal by fingertip and object, shape (tips, things, 7).
        stiffness: Stiffness of the fingertips, N/m.
        wrenches: Output: sums of the forces.
    """
    for tip in range(contacts.shape[0]):
        for thing in range(contacts.shape[1]):
            depth = contacts[tip, thing, 0]
            if depth > 0.0:
                for i in range(3):
                    wrenches[tip, i] += stiffness * depth * contacts[tip, thing, 4 + i]
