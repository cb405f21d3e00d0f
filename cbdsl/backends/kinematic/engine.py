"""Engine without physics: joints are moved, and the world yields."""

from __future__ import annotations

import numpy as np

from cbdsl.backends.kinematic.hands import FingertipContact, Hands
from cbdsl.backends.kinematic.manipulation import Manipulation
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.engine import ROOM, Engine
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.forward import place_joints
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled_once
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel
from cbdsl.sensing.observation import Cell


class Servos:
    """Servos of all actuated joints.

    Args:
        joints: Actuated joints.
        model: URDF model with their limits.
        tree: Tree of the links that they move.
        period: Period of a control tick, s.
    """

    def __init__(self, joints: Joints, model: UrdfModel, tree: LinkTree, period: float) -> None:
        self._period = period
        self._chain = tree.chain
        limits = [model.joints[name] for name in joints.names]
        self._limits = np.array([(period * j.velocity, j.lower, j.upper) for j in limits]).T.copy()

    def follow(self, positions: Floats, reference: Floats) -> tuple[Floats, Floats]:
        """Move the joints by one tick, and place the links.

        Args:
            positions: Positions of the joints now, rad, shape (n,).
            reference: References of the joints, rad, shape (n,).

        Returns:
            Reached positions, rad, and mean velocities during the tick, rad/s, shape (n,) each.
        """
        reached, velocities = np.empty((2, len(positions)))
        _follow(positions, reference, self._limits, self._period, reached, velocities, *self._chain)
        return reached, velocities


@compiled_once
def _follow(
    positions: Floats,
    reference: Floats,
    limits: Floats,
    period: float,
    reached: Floats,
    velocities: Floats,
    moving: Integers,
    joints: Records,
    frames: Floats,
    axes: Floats,
) -> None:
    """Write reached positions and velocities, and place the links.

    ``limits`` are the largest step, the lower and the upper limit, shape (3, n); the arguments
    after ``velocities`` are a tree's chain.
    """
    for joint in range(len(positions)):
        step, lower, upper = limits[0, joint], limits[1, joint], limits[2, joint]
        least, most = positions[joint] - step, positions[joint] + step
        # Position limits come last: they hold even for a joint that starts outside of them.
        wanted = min(max(reference[joint], least), most)
        reached[joint] = min(max(wanted, lower), upper)
        velocities[joint] = (reached[joint] - positions[joint]) / period
    place_joints(reached, moving, joints, frames, axes)


class KinematicEngine(Engine):
    """Kinematic robot in a world that yields; see ``Engine``.

    Args:
        robot: Robot document.
        model: URDF model of the robot.
        period: Period of a step, s.
    """

    def __init__(self, robot: RobotDocument, model: UrdfModel, period: float) -> None:
        joints = Joints(robot)
        self._period = period
        self._tree = LinkTree(model, joints, robot.base)
        self._servos = Servos(joints, model, self._tree, period)
        self._hands = Hands(robot, model, joints, self._tree)
        self.rows, self.cells = self._tree.rows, self._hands.cells

    def begin(self, positions: Floats) -> None:
        self._positions, self._velocities = positions, np.zeros_like(positions)
        self._tree.update(positions)
        self._world = World()
        self.objects = self._world.objects
        self._manipulation = Manipulation(self._world, self._hands)

    def step(self, targets: Floats) -> None:
        before = self._positions
        # Order: the hands move first and take held objects along. Then contacts are found at the
        # new poses, and fingers that are too deep go back before forces are computed.
        self._positions, self._velocities = self._servos.follow(before, targets)
        self._manipulation.move(self._period)
        if self._manipulation.touch():
            self._hold_back(before)
        self._wrenches = self._manipulation.press()

    def _hold_back(self, before: Floats) -> None:
        """Hold back the joints of fingertips that push objects that do not yield.

        The joints go half of their way, or half of that. If a joint that several fingertips share
        is held back, another fingertip may go deeper. So all are checked again until none changes.
        """
        wanted, share = self._positions, np.ones(len(before))
        # The loop ends, because each round lessens a share, and five reductions take a share to 0.
        while self._manipulation.hold_back(share):
            self._positions = before + share * (wanted - before)
            self._velocities = (self._positions - before) / self._period
            self._tree.update(self._positions)
            self._manipulation.touch()

    def read(self) -> tuple[Floats, Floats]:
        return self._positions, self._velocities

    def wrenches(self) -> Floats:
        return self._wrenches

    def efforts(self) -> None:
        """Return ``None``: joints are at their references, without forces."""

    def close(self) -> None:
        """Do nothing: there are no resources to free."""

    @property
    def solids(self) -> Floats:
        return self._world.solids

    @property
    def placements(self) -> Floats:
        return self._tree.placements

    @property
    def contacts(self) -> list[FingertipContact]:
        """Contacts of all fingertips, as of the last step."""
        return self._manipulation.contacts

    def pose(self, name: str) -> Pose:
        return self._world.things[name].pose

    def velocity(self, name: str) -> Floats:
        return self._world.things[name].velocity.copy()

    def touched(self, name: str) -> bool:
        """Return whether any fingertip touches an object, as of the last step."""
        return self._manipulation.touches(name)

    def touching(self, name: str) -> frozenset[Cell]:
        contacts = [each for each in self.contacts if each.thing.name == name]
        return frozenset(self.cells[each.fingertip.cell] for each in contacts)

    def add(self, item: SceneObject) -> None:
        self._world.add(item)

    def remove(self, name: str) -> None:
        self._world.remove(name)

    def attach(self, name: str) -> None:
        self._world.things[name].gripped = True

    def lead(self, name: str, position: Floats, velocity: Floats) -> None:
        """Lead an object by its velocity in the next step; see ``Engine``."""
        self._world.things[name].launch(velocity)

    def release(self, name: str) -> None:
        self._world.things[name].gripped = False
        self.launch(name, np.zeros(3))

    def launch(self, name: str, velocity: Floats) -> None:
        self._world.things[name].launch(velocity)

    def put_back(self, name: str, pose: Pose) -> None:
        """Put an object back; of the robot, only fingertips can be in its way. See ``Engine``."""
        thing, before = self._world.things[name], self._world.things[name].pose
        was_resting = thing.resting
        thing.put(pose)
        # Distances are measured in place, so the object is moved there first.
        if self._hands.near(self._world, name, ROOM):
            thing.put(before)
            thing.resting = was_resting
            return
        thing.launch(np.zeros(3))
        thing.rolling[:] = 0.0
