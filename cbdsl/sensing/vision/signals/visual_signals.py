"""Visual signals: headings to objects and their positions (Eq 3.10, 3.14 and 3.15)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.table.chain import MANIPULATOR, carry
from cbdsl.sensing.table.reading import CameraHeading, Reading, mean, stacked
from cbdsl.sensing.table.table import RowPart, records_of
from cbdsl.sensing.table.tips import Tips
from cbdsl.sensing.touch.touch import Touch
from cbdsl.sensing.vision.association.stereo import Ray, triangulate
from cbdsl.sensing.vision.memory.hold import Content, Hold, find_hold, held_jacobian
from cbdsl.sensing.vision.memory.memory import PositionMemory
from cbdsl.sensing.vision.regions.camera import (
    direction,
    heading,
    heading_jacobian,
    sighting_jacobian,
    within_view,
)
from cbdsl.sensing.vision.vision import SeenHeading, Vision
from cbdsl.types.casts import CAMERA, RIGID_HOLD, SIGHTING, TRIANGULATION, Chain
from cbdsl.types.resource import CYCLOPEAN, Heading, Headings, ObjectDistance, StereoPosition

Step = Callable[[Any], Any]
Thing = tuple[str, int]
"""Channel, and number of an object in it."""
Carried = tuple[PositionMemory, Floats]
"""Memory of an object, and its displacement with the hands that hold it, m, shape (3,)."""


class VisualSignals:
    """Reader of headings and positions; held objects move with the hand, others stand still.

    A seen object counts as held if it lies between the touching fingertips at the start of a hold.
    A hold starts when all fingers of a hand, or several hands, come into contact, and lasts as long
    as they stay so. The object then moves as if fixed to the one hand, or by the common
    displacement of the tips of several hands (Eq 3.42 and 3.43).
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, vision: Vision, tips: Tips, touch: Touch
    ) -> None:
        self._robot = robot
        self._kinematics = kinematics
        self._vision = vision
        self._tips = tips
        self._touch = touch
        self._still = np.zeros((3, len(kinematics.joints)))
        # The main cameras come first, as in the rows of headings of both.
        self._cameras = {**robot.main_cameras, **robot.cameras}
        self._places = {name: place for place, name in enumerate(self._cameras)}
        self._carriers = tuple(touch.carriers.values())
        self._tip_parts = records_of([tips.part(carrier) for carrier in self._carriers])
        self._fingertips = [[*robot.load_cells[hand].values()] for hand in touch.carriers]
        self._cells = np.array([touch.span(hand) for hand in touch.carriers]).reshape(-1, 2)
        self.reset()

    def reset(self) -> None:
        """Forget the previous episode."""
        self._hold: Hold | None = None
        self._begun: Hold | None = None
        self._content = Content(self._find_middle)

    def carried(self, memories: Sequence[PositionMemory]) -> Iterator[Carried]:
        """Yield memories of held objects with their displacements since the last tick, m.

        Tips and touch must be up to date.

        Args:
            memories: Memories of all objects.
        """
        before, self._hold = self._hold, self._find_hold()
        if self._hold is None:
            return
        if self._begun is None or before is None or before.hands != self._hold.hands:
            self._begun = self._hold
            self._content.begin(memories)
            return
        for memory in memories:
            if memory.position is not None and self._holds(memory):
                yield memory, self._hold.displace(self._begun, before, memory.position)

    def _find_hold(self) -> Hold | None:
        if not self._touch.touching_anything():
            return None
        self._kinematics.place()
        position, rotation = np.empty(3), np.empty((3, 3))
        feeling, frames = self._touch.feeling, self._kinematics.frames
        hands = find_hold(frames, self._tip_parts, self._cells, feeling, position, rotation)
        if not hands:
            return None
        is_alone = hands & (hands - 1) == 0
        tips = position[None] if is_alone else self._tips_of(hands)
        return Hold(hands, position, rotation, tips)

    def _tips_of(self, hands: int) -> Floats:
        """Return tips of the hands in a bit mask, m, world frame, shape (k, 3)."""
        holding = [arm for i, arm in enumerate(self._carriers) if hands >> i & 1]
        return np.array([self._tips.point(arm).position for arm in holding])

    def _find_middle(self) -> Floats:
        """Return the middle between touching fingertips, or the mean over hands, m, shape (3,)."""
        assert self._hold is not None
        middles = []
        for hand, (start, _) in enumerate(self._cells.tolist()):
            if self._hold.hands >> hand & 1:
                placed = enumerate(self._fingertips[hand], start)
                touching = [cell for number, cell in placed if self._touch.feeling[number]]
                places = [self._kinematics.point(c.link, c.pad).position for c in touching]
                middles.append(np.mean(places, axis=0))
        return np.asarray(np.mean(middles, axis=0))

    def heading(self, source: Heading, chains: tuple[Chain, ...]) -> Reading | None:
        """Return the heading in one camera, or the mean over the cameras that see the object.

        Args:
            source: Source of the heading.
            chains: Chains of casts with Jacobians that are summed; none for the value alone.
        """
        names = self._robot.main_cameras if source.camera == CYCLOPEAN else (source.camera,)
        number = self._vision.number(source.channel, source.instance)
        if number is None:
            return None
        thing, seen = (source.channel, number), []
        for name in names:
            seen_heading = self._vision.heading(name, *thing)
            if seen_heading is not None:
                seen.append(self._moving_heading(name, thing, seen_heading, chains))
        return mean(seen) if seen else None

    def camera_parts(self, shift: int) -> list[RowPart]:
        """Return the cameras as parts of a row of headings, which lie ``shift`` rows apart."""
        cameras = self._robot.main_cameras if shift else self._cameras
        links = [self._kinematics.link(camera.link) for camera in cameras.values()]
        return [
            RowPart(
                link.frame, rotation=link.rotation.ravel(), support=link.support, shift=shift * i
            )
            for i, link in enumerate(links)
        ]

    def headings(self, source: Headings, chains: tuple[Chain, ...]) -> Reading | None:
        """Return the headings in both cameras, or ``None`` unless both see the object whole.

        If the arm that holds an object occludes it, the heading leads to the held position.

        Args:
            source: Source of the headings.
            chains: Chains of casts with Jacobians that are summed; none for the values alone.
        """
        number = self._vision.number(source.channel, source.instance)
        if number is None:
            return None
        thing, headings = (source.channel, number), []
        for camera in self._robot.main_cameras:
            region = self._vision.region(camera, *thing)
            seen = self._vision.heading(camera, *thing)
            if seen is None:
                seen = self._hidden_heading(camera, thing)
            if seen is None or (region is not None and region.clipped):
                return None
            headings.append(self._moving_heading(camera, thing, seen, chains))
        return stacked(headings) if self._meet(headings) else None

    def position(self, source: StereoPosition, chains: tuple[Chain, ...]) -> Reading | None:
        """Return the remembered position of an object.

        Args:
            source: Source of the position.
            chains: Chains of casts with Jacobians that are summed; none for the value alone.
        """
        number = self._vision.number(source.channel, source.instance)
        memory = None if number is None else self._vision.memory(source.channel, number)
        if memory is None or memory.position is None:
            return None
        jacobian = self._still
        if self._holds(memory):
            steps = self._hold_steps(memory.position)
            jacobian = sum([carry(chain, steps) for chain in chains], jacobian)
        return Reading(memory.position, jacobian, self._vision.images, memory.radius)

    def cameras(self) -> tuple[Frame, ...]:
        """Return the main cameras' frames relative to the first camera's frame."""
        cameras = self._robot.main_cameras.values()
        frames = [self._kinematics.frame(camera.link) for camera in cameras]
        first = frames[0]
        return tuple(
            Frame(
                first.rotation.T.dot(frame.position - first.position),
                first.rotation.T.dot(frame.rotation),
            )
            for frame in frames
        )

    def _meet(self, headings: Sequence[Reading]) -> bool:
        """Return whether the lines of sight meet in front of the cameras."""
        left, right = (
            Ray(frame.position, frame.rotation.dot(direction(reading.value)))
            for frame, reading in zip(self.cameras(), headings, strict=True)
        )
        return triangulate(left, right) is not None

    def _hidden_heading(self, camera: str, thing: Thing) -> SeenHeading | None:
        """Return the heading to a held object that a camera would see without occlusion."""
        memory = self._vision.memory(*thing)
        if memory is None or memory.position is None or not self._holds(memory):
            return None
        eye = self._robot.cameras[camera]
        frame = self._kinematics.frame(eye.link)
        point = frame.rotation.T.dot(memory.position - frame.position)
        if not within_view(eye, point, memory.radius):
            return None
        return SeenHeading(heading(point), self._vision.images)

    def _moving_heading(
        self, camera: str, thing: Thing, seen: SeenHeading, chains: tuple[Chain, ...]
    ) -> Reading:
        """Return a heading and its Jacobian by the head and by hands that hold the object."""
        link, memory = self._robot.cameras[camera].link, self._vision.memory(*thing)
        steps: dict[str, Step] = {
            CAMERA.name: lambda _: heading_jacobian(seen.angles).dot(
                self._kinematics.own_turning(link)
            )
        }
        if memory is not None and memory.position is not None and self._holds(memory):
            steps |= self._hold_steps(memory.position)
            steps[SIGHTING.name] = steps[TRIANGULATION.name] = self._sight(link, memory.position)
        own = [carry(chain, steps) for chain in chains if chain[-1].name in steps]
        jacobian = sum(own[1:], own[0]) if own else self._still[:2]
        cameras = (CameraHeading(self._places[camera], 1.0, seen.angles),)
        return Reading(seen.angles, jacobian, seen.stamp, cameras=cameras)

    def _sight(self, link: str, position: Floats) -> Step:
        """Return the step from an object's motion to that of its heading."""
        frame = self._kinematics.frame(link)
        point = frame.rotation.T.dot(position - frame.position)
        return lambda motion: sighting_jacobian(point).dot(frame.rotation.T.dot(motion))

    def _hold_steps(self, position: Floats) -> dict[str, Step]:
        """Return the steps from joints to tips of hands and from tips to a held object."""
        assert self._hold is not None
        holding = [arm for i, arm in enumerate(self._carriers) if self._hold.hands >> i & 1]
        return {
            RIGID_HOLD.name: lambda tips: held_jacobian(tips, position),
            MANIPULATOR: lambda _: [self._tips.point(arm) for arm in holding],
        }

    def motion(self, memory: PositionMemory) -> Floats | None:
        """Return a held object's displacement per joint, shape (3, n), ``None`` if not held."""
        if memory.position is None or not self._holds(memory):
            return None
        steps = self._hold_steps(memory.position)
        motion: Floats = steps[RIGID_HOLD.name](steps[MANIPULATOR](None))
        return motion

    def _holds(self, memory: PositionMemory) -> bool:
        """Return whether the touching hands hold a remembered object."""
        return self._hold is not None and self._content.holds(memory)


class Distances:
    """Reader of distances between objects and the first joints of effectors.

    The reach of an arm is about a ball around its first joint. A limit of reach is therefore one
    threshold of this distance, but a staircase of thresholds of the coordinates.

    Args:
        robot: Robot document with effectors and groups.
        kinematics: Kinematics of the same robot.
        sight: Visual signals with the positions of objects.
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics, sight: VisualSignals) -> None:
        self._robot, self._kinematics, self._sight = robot, kinematics, sight

    def read(self, source: ObjectDistance) -> Reading | None:
        """Return the distance, m, from the nearest base; ``None`` without a position."""
        seen = self._sight.position(StereoPosition(source.channel, source.instance), ())
        if seen is None:
            return None
        bases = self._kinematics.origins(self._first_joints(source.effector), ())
        distances = np.linalg.norm(bases - seen.value, axis=1)
        return Reading(distances.min(keepdims=True), None, seen.stamp)

    def _first_joints(self, effector: str) -> tuple[str, ...]:
        """Return the joint of each member that moves all its other joints."""
        moving = {
            member: {joint: len(self._kinematics.above(joint)) for joint in joints}
            for member in self._robot.members(effector)
            if (joints := self._robot.joints(member))
        }
        return tuple(min(above, key=above.__getitem__) for above in moving.values())
