"""Sensor readers: touch and vision of one robot, updated in the order of their dependence."""

from __future__ import annotations

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.table.tips import Tips
from cbdsl.sensing.touch.touch import Strain, Touch
from cbdsl.sensing.vision.shapes.solid_signals import SolidSignals
from cbdsl.sensing.vision.shapes.surface import Surfaces
from cbdsl.sensing.vision.signals.blob_signals import BlobSignals
from cbdsl.sensing.vision.signals.marks import Marks
from cbdsl.sensing.vision.signals.novelty import Novelty
from cbdsl.sensing.vision.signals.visual_signals import Distances, VisualSignals
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import channels_of


class SensorReaders:
    """Readers of one robot's sensors, with the memories of its objects.

    Args:
        robot: Robot document with the sensors.
        kinematics: Kinematics of the same robot.
        tips: Tips of the effectors.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics, tips: Tips) -> None:
        self._robot = robot
        self.touch = Touch(robot, kinematics, tips)
        self.strain = Strain(robot.joint_torques, kinematics)
        self.vision = Vision(robot, kinematics)
        self.sight = VisualSignals(robot, kinematics, self.vision, tips, self.touch)
        self.distances = Distances(robot, kinematics, self.sight)
        self.blobs = BlobSignals(robot, self.vision, self.sight)
        self.surfaces = Surfaces(robot, self.vision)
        self.solids = SolidSignals(robot, kinematics, self.vision, self.touch)
        self.novelty = Novelty(robot, kinematics, self.vision)
        self.marks = Marks(robot, kinematics, self.vision)
        # These readers follow the objects that vision has matched.
        self._followers = (self.blobs, self.surfaces, self.solids, self.novelty, self.marks)

    def follow(self, resources: tuple[Resource, ...]) -> None:
        """Follow more resources from now on; the memories of the others stay."""
        self.vision.look_for(channel for each in resources for channel in channels_of(each.source))
        for reader in self._followers:
            reader.follow(resources)

    def reset(self) -> None:
        """Forget the previous episode."""
        self.touch.reset()
        self._forget()

    def resume(self, before: SensorReaders) -> None:
        """Begin an episode at the end of another one; see ``Touch.resume``.

        Args:
            before: Readers of that episode; may be this object.
        """
        self.touch.resume(before.touch)
        self._forget()

    def _forget(self) -> None:
        for reader in (self.strain, self.vision, self.sight, *self._followers):
            reader.reset()

    def update(self, observation: Observation, wrenches: Floats) -> None:
        """Update all readers from one tick's observation; the kinematics must have its posture.

        Contacts come first. Then held objects move with the hands, before the images are matched
        with remembered places. The other readers follow the matched places. Contact sets velocities
        to zero at the end, so that an image of the same tick cannot restore them.

        Args:
            observation: Observation of the tick.
            wrenches: Loads from ``Touch.gathered``, N and N m, world frame, shape (cells, 6).
        """
        self.strain.update(observation)
        if self._robot.load_cells:
            self.touch.update(wrenches, observation.time)
            self.vision.carry(self.sight.carried(self.vision.all_memories))
        if not self._robot.cameras:
            return
        self.vision.update(observation)
        for reader in self._followers:
            reader.update(observation)
        if self.touch.touching_anything():
            self.vision.touched()
        else:
            self.vision.untouched()
