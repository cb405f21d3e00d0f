"""Resources of a robot document: everything that programs can name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import chain

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import Channels, LoadCell, RobotDocument
from cbdsl.robot.channel_names import channel_names, color_of, hue_names
from cbdsl.robot.source_kind import SOURCES
from cbdsl.robot.urdf import UrdfModel
from cbdsl.types import resource as sources
from cbdsl.types.resource import CYCLOPEAN, Origin, Resource
from cbdsl.types.resource_type import (
    ANGLE_OR_LENGTH,
    AXIS,
    COUNT,
    DISTANCE,
    EXTENT,
    FORCE,
    HEADING,
    HEADING_RATE,
    LENGTH,
    ORIENTATION,
    POSE,
    POSITION,
    TORQUE,
    VELOCITY,
    VOLUME,
    WRENCH,
    ResourceType,
    configuration,
)

CAMERAS = "cameras"
STEREO = "stereo"
SURFACE = "surface"
COUNTED = "count"
#: Word between an object and the effector from whose base its distance is measured.
FROM = "from"
#: Least distance between the links of an effector and all others.
CLEARANCE = "clearance"
#: Derived posture that has turned a held object; a declared posture of the name takes its place.
TURNED = "turned"
#: Prefix of the names of headings to regions that a background model does not expect.
NOVEL = "novel"
#: Prefix of the names of headings to marks: regions of another hue on an object.
MARK = "mark"

_TIP_PARTS = {"position": POSITION, "orientation": ORIENTATION, "pose": POSE}
_BLOB_PARTS = {"velocity": HEADING_RATE, "extent": EXTENT, "orientation": AXIS}
_STEREO_PARTS = {"velocity": VELOCITY, "volume": VOLUME}
#: Signals of an object that stands on the level of another one, as in ``pair_names``.
SOLID_PARTS = {
    "length": LENGTH,
    "width": LENGTH,
    "height": LENGTH,
    "bulk": LENGTH,
    "top": POSITION,
    "placed": POSITION,
    "above": ORIENTATION,
}
#: Signals of such an object that depend on an effector with a tip, whose name follows.
APPROACH_PARTS = {"beside": ORIENTATION}
_LOAD_PARTS = {"force": FORCE, "torque": TORQUE, "wrench": WRENCH}


def configuration_of(joints: Sequence[str], model: UrdfModel | None) -> ResourceType:
    """Return the type of the configuration of some joints.

    Args:
        joints: Names of the joints.
        model: Model of the robot, with the kinds of its joints; ``None`` if unknown.
    """
    known = {} if model is None else model.joints
    units = [known[each].unit if each in known else ANGLE_OR_LENGTH for each in joints]
    return configuration(len(joints), units or [ANGLE_OR_LENGTH])


def resources(robot: RobotDocument, model: UrdfModel | None = None) -> dict[str, Resource]:
    """Return all resources of a robot by name (Eq 3.8 to 3.16).

    Args:
        robot: Document of the robot.
        model: Model of the robot, with the kinds of its joints; ``None`` if unknown.

    ========================================  ===================  ==============
    name                                      type                 origin
    ========================================  ===================  ==============
    ``effector``                              configuration[n]     proprioception
    ``effector.position/orientation/pose``    of its tip           kinematics
    ``hand.finger.force/torque/wrench``       load of one finger   environment
    ``hand.net.force/torque/wrench``          sum over fingers     environment
    ``hand.finger_forces``                    force x fingers      environment
    ``hand.opening``                          length               kinematics
    ``hand.centre``                           position             kinematics
    ``camera.channel, cyclopean.channel``     heading              environment
    ``camera.channel.velocity``               heading_rate         environment
    ``camera.channel.extent``                 extent               environment
    ``camera.channel.orientation``            axis                 environment
    ``cameras.channel``                       heading x 2          environment
    ``stereo.channel``                        position             triangulation
    ``stereo.channel.velocity``               velocity             triangulation
    ``stereo.channel.volume``                 volume               triangulation
    ``stereo.channel.from.arm``               distance             triangulation
    ``mark.channel``                          heading              environment
    ``count.channel``                         count                triangulation
    ``surface.channel``                       position             visible surface
    ``effector.posture``                      configuration[n]     constant
    ``effector.turned``                       configuration[n]     constant
    ``effector.uniform``                      configuration[n]     internal model
    ``group``, ``group.posture/uniform``      configuration[n]     as of effectors
    ``group.position``                        position x members   kinematics
    ``group.centroid, group.separation``      position             kinematics
    ``group.net_forces``                      force x members      environment
    ========================================  ===================  ==============

    Resources of a channel belong to the attended object. Instances of a channel have names of their
    own, such as ``stereo.red.2``, and so have marks of one hue, such as ``mark.red.blue``. They are
    not listed: see ``instance_names`` and ``mark_names``. Nor are distances of links, such as
    ``arm.clearance`` and ``arm.from.table``.
    """
    named = chain(
        _effectors(robot, model),
        _loads(robot),
        _vision(robot),
        _groups(robot, model),
        _sensors(robot),
    )
    return {resource.name: resource for resource in named}


def _effectors(robot: RobotDocument, model: UrdfModel | None) -> Iterator[Resource]:
    for name, effector in robot.effectors.items():
        kind = configuration_of(robot.joints(name), model)
        yield from _configurations(name, kind, effector.postures)
        if effector.tip is not None:
            if robot.cameras and TURNED not in effector.postures:
                yield Resource(f"{name}.{TURNED}", kind, Origin.CONSTANT, sources.Turned(name))
            for part, kind in _TIP_PARTS.items():
                tip = sources.Tip(name, part)
                yield Resource(f"{name}.{part}", kind, Origin.KINEMATICS, tip, movable=True)


def _configurations(name: str, kind: ResourceType, postures: Iterable[str]) -> Iterator[Resource]:
    source = sources.EffectorConfiguration(name)
    yield Resource(name, kind, Origin.PROPRIOCEPTION, source, movable=True)
    yield Resource(f"{name}.uniform", kind, Origin.MODEL, sources.UniformSample(name))
    for posture in postures:
        yield Resource(f"{name}.{posture}", kind, Origin.CONSTANT, sources.Posture(name, posture))


def _groups(robot: RobotDocument, model: UrdfModel | None) -> Iterator[Resource]:
    for name, group in robot.groups.items():
        # A group with a missing member has been reported, and has no resources.
        members = [robot.effectors[m] for m in group.members if m in robot.effectors]
        if len(members) < len(group.members):
            continue
        shared = [p for p in members[0].postures if all(p in m.postures for m in members)]
        yield from _configurations(name, configuration_of(robot.joints(name), model), shared)
        if all(member.tip is not None for member in members):
            yield from _tips(name, len(members))
        if all(member in robot.load_cells for member in group.members):
            forces = FORCE.times(len(members))
            yield Resource(
                f"{name}.net_forces", forces, Origin.ENVIRONMENT, sources.NetForces(name)
            )


def _tips(group: str, members: int) -> Iterator[Resource]:
    known, tips = Origin.KINEMATICS, sources.Tip(group, "position")
    yield Resource(f"{group}.position", POSITION.times(members), known, tips, movable=True)
    yield Resource(f"{group}.centroid", POSITION, known, sources.Centroid(group), movable=True)
    if members == 2:
        yield Resource(
            f"{group}.separation", POSITION, known, sources.Separation(group), movable=True
        )


def _loads(robot: RobotDocument) -> Iterator[Resource]:
    for hand, cells in robot.load_cells.items():
        yield from _hand_loads(hand, cells)


def _hand_loads(hand: str, cells: Mapping[str, LoadCell]) -> Iterator[Resource]:
    world = Origin.ENVIRONMENT
    for part, kind in _LOAD_PARTS.items():
        for finger in cells:
            yield Resource(
                f"{hand}.{finger}.{part}", kind, world, sources.FingerLoad(hand, finger, part)
            )
        yield Resource(f"{hand}.net.{part}", kind, world, sources.NetLoad(hand, part))
    forces = FORCE.times(len(cells))
    yield Resource(f"{hand}.finger_forces", forces, world, sources.FingerForces(hand))
    if len(cells) > 1:
        known = Origin.KINEMATICS
        yield Resource(f"{hand}.opening", LENGTH, known, sources.Opening(hand))
        yield Resource(f"{hand}.centre", POSITION, known, sources.GraspCentre(hand))


def _sensors(robot: RobotDocument) -> Iterator[Resource]:
    """Yield resources of custom sensor kinds; an unusable kind has none."""
    for name, sensor in robot.sensors.items():
        with suppress(UsageError):
            yield from SOURCES.get(sensor.kind).resources(name, sensor, robot)


def _vision(robot: RobotDocument) -> Iterator[Resource]:
    if not robot.cameras:
        return
    channels = robot.vision.channels
    for name, channel in _named_channels(channels):
        own = color_of(channel, channels)
        hues = tuple(hue for hue in hue_names(channels) if color_of(hue, channels) != own)
        if hues:
            mark = sources.MarkHeading(channel, hues)
            yield Resource(f"{MARK}.{name}", HEADING, Origin.ENVIRONMENT, mark)
        for camera in (*robot.cameras, CYCLOPEAN):
            source = sources.Heading(camera, channel)
            yield Resource(f"{camera}.{name}", HEADING, Origin.ENVIRONMENT, source)
        if robot.has_stereo:
            pair = HEADING.times(2)
            yield Resource(f"{CAMERAS}.{name}", pair, Origin.ENVIRONMENT, sources.Headings(channel))
            position = sources.StereoPosition(channel)
            yield Resource(f"{STEREO}.{name}", POSITION, Origin.TRIANGULATION, position)
        yield from _features(robot, name, channel)


def _features(robot: RobotDocument, name: str, channel: str) -> Iterator[Resource]:
    """Yield features of the blobs of a channel, and of the objects that they belong to."""
    for camera in robot.cameras:
        for part, kind in _BLOB_PARTS.items():
            blob = sources.BlobSignal(camera, channel, part)
            yield Resource(f"{camera}.{name}.{part}", kind, Origin.ENVIRONMENT, blob)
    if robot.has_stereo:
        for part, kind in _STEREO_PARTS.items():
            seen = sources.StereoSignal(channel, part)
            yield Resource(f"{STEREO}.{name}.{part}", kind, Origin.TRIANGULATION, seen)
        for effector in _with_tips(robot):
            far = sources.ObjectDistance(channel, effector)
            distance = f"{STEREO}.{name}.{FROM}.{effector}"
            yield Resource(distance, DISTANCE, Origin.TRIANGULATION, far)
        count = sources.InstanceCount(channel)
        yield Resource(f"{COUNTED}.{name}", COUNT, Origin.TRIANGULATION, count)
        point = sources.SurfacePoint(channel)
        yield Resource(f"{SURFACE}.{name}", POSITION, Origin.SURFACE, point)


def _with_tips(robot: RobotDocument) -> Iterator[str]:
    """Yield the effectors with a tip, and the groups of such effectors."""
    tipped = {name for name, effector in robot.effectors.items() if effector.tip is not None}
    yield from (name for name in robot.effectors if name in tipped)
    yield from (name for name, group in robot.groups.items() if tipped.issuperset(group.members))


def _named_channels(channels: Channels) -> Iterator[tuple[str, str]]:
    """Yield the names that programs may use, with their channels."""
    names = list(channel_names(channels))
    yield from zip(names, names, strict=True)
    yield from ((alias, name) for alias, name in channels.aliases.items() if name in names)
