"""The resources that a robot document gives rise to: everything that programs can name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from cbdsl.documents.robot import Channels, LoadCell, RobotDocument
from cbdsl.robot.channel_names import channel_names
from cbdsl.types.resource import (
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    Heading,
    NetLoad,
    Origin,
    Posture,
    Resource,
    StereoPosition,
    Tip,
    UniformSample,
)
from cbdsl.types.resource_type import (
    FORCE,
    HEADING,
    ORIENTATION,
    POSE,
    POSITION,
    TORQUE,
    WRENCH,
    configuration,
)

CYCLOPEAN = "cyclopean"
STEREO = "stereo"

_TIP_PARTS = {"position": POSITION, "orientation": ORIENTATION, "pose": POSE}
_LOAD_PARTS = {"force": FORCE, "torque": TORQUE, "wrench": WRENCH}


def resources(robot: RobotDocument) -> dict[str, Resource]:
    """All resources of a robot by name (Eq 3.8 to 3.16).

    ========================================  ===================  ==============
    name                                      type                 origin
    ========================================  ===================  ==============
    ``effector``                              configuration[n]     proprioception
    ``effector.position/orientation/pose``    of its tip           kinematics
    ``hand.finger.force/torque/wrench``       load of one finger   environment
    ``hand.net.force/torque/wrench``          sum over fingers     environment
    ``hand.finger_forces``                    force x fingers      environment
    ``camera.channel, cyclopean.channel``     heading              environment
    ``stereo.channel``                        position             triangulation
    ``effector.posture``                      configuration[n]     constant
    ``effector.uniform``                      configuration[n]     internal model
    ========================================  ===================  ==============
    """
    found: dict[str, Resource] = {}
    for group in (_effectors(robot), _loads(robot), _vision(robot)):
        found.update((resource.name, resource) for resource in group)
    return found


def _effectors(robot: RobotDocument) -> Iterator[Resource]:
    for name, effector in robot.effectors.items():
        joints = configuration(len(effector.joints))
        source = EffectorConfiguration(name)
        yield Resource(name, joints, Origin.PROPRIOCEPTION, source, movable=True)
        yield Resource(f"{name}.uniform", joints, Origin.MODEL, UniformSample(name))
        for posture in effector.postures:
            yield Resource(f"{name}.{posture}", joints, Origin.CONSTANT, Posture(name, posture))
        if effector.tip is not None:
            for part, kind in _TIP_PARTS.items():
                tip = Tip(name, part)
                yield Resource(f"{name}.{part}", kind, Origin.KINEMATICS, tip, movable=True)


def _loads(robot: RobotDocument) -> Iterator[Resource]:
    for hand, cells in robot.load_cells.items():
        yield from _hand_loads(hand, cells)


def _hand_loads(hand: str, cells: Mapping[str, LoadCell]) -> Iterator[Resource]:
    world = Origin.ENVIRONMENT
    for part, kind in _LOAD_PARTS.items():
        for finger in cells:
            yield Resource(f"{hand}.{finger}.{part}", kind, world, FingerLoad(hand, finger, part))
        yield Resource(f"{hand}.net.{part}", kind, world, NetLoad(hand, part))
    forces = FORCE.times(len(cells))
    yield Resource(f"{hand}.finger_forces", forces, world, FingerForces(hand))


def _vision(robot: RobotDocument) -> Iterator[Resource]:
    if not robot.cameras:
        return
    for name, channel in _named_channels(robot.vision.channels):
        for camera in (*robot.cameras, CYCLOPEAN):
            source = Heading(camera, channel)
            yield Resource(f"{camera}.{name}", HEADING, Origin.ENVIRONMENT, source)
        if len(robot.cameras) == 2:
            position = StereoPosition(channel)
            yield Resource(f"{STEREO}.{name}", POSITION, Origin.TRIANGULATION, position)


def _named_channels(channels: Channels) -> Iterator[tuple[str, str]]:
    """Names that programs may use, and the channels they mean."""
    names = list(channel_names(channels))
    yield from zip(names, names, strict=True)
    yield from ((alias, name) for alias, name in channels.aliases.items() if name in names)
