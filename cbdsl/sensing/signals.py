"""Signals: the value and Jacobian of every resource, from what was observed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.program.controller import Standoff
from cbdsl.sensing.blob_signals import BlobSignals
from cbdsl.sensing.chain import require_executed
from cbdsl.sensing.declared_sensor import sensor_reader
from cbdsl.sensing.density import DensitySampler, Sampler
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.novelty import Novelty
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.reading import Reading, shaped
from cbdsl.sensing.refresh import (
    CONFIGURATION,
    DISPLACED,
    MANIPULATOR,
    MIXTURE,
    NORMAL_FORCES,
    TIP,
    WRITTEN,
    refresh,
)
from cbdsl.sensing.sensor_faults import require_finite
from cbdsl.sensing.strain import Strain
from cbdsl.sensing.surface import SurfaceSampler
from cbdsl.sensing.surfaces import Surfaces
from cbdsl.sensing.table import Form, RowPart, SignalTable
from cbdsl.sensing.tips import Tips
from cbdsl.sensing.touch import Touch
from cbdsl.sensing.uniform import UniformSampler
from cbdsl.sensing.vision import Vision
from cbdsl.sensing.visual_signals import VisualSignals
from cbdsl.types.casts import Chain, chains_of
from cbdsl.types.resource import (
    RELATIVE,
    VISUAL,
    AffordanceProbability,
    BlobSignal,
    Centroid,
    ConstellationSignal,
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    GaussianSample,
    Heading,
    Headings,
    InstanceCount,
    KernelSample,
    NetForces,
    NetLoad,
    NovelHeading,
    Posture,
    Resource,
    SensorSignal,
    Separation,
    StereoOffset,
    StereoPosition,
    StereoSignal,
    SurfacePoint,
    Tip,
    UniformSample,
)
from cbdsl.types.resource_type import POSITION

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Reader = Callable[[], Reading | None]


class Selection(NamedTuple):
    """Rows that are kept up to date together.

    Attributes:
        compiled: those that ``refresh`` writes, those that others are made of first, shape (r,).
        read: those that Python reads, and how.
    """

    compiled: Integers
    read: tuple[tuple[int, Reader], ...]


class Signals:
    """Resources as rows of a signal table, from what was observed tick by tick.

    A row is undefined where there is nothing to read: a channel without a region, a hand without
    contact.

    Args:
        robot: what can be sensed.
        kinematics: of the same robot.
        resources: whose channels the cameras look for.

    Attributes:
        robot: the robot's document.
        table: the rows.
        positions: of the actuated joints, rad, shape (n,); each observation writes over them.
        clock: counts the postures, shape (1,).
        time: of the newest observation, s.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, resources: Iterable[Resource]
    ) -> None:
        self.robot = robot
        self.kinematics = kinematics
        self.joints = kinematics.joints
        self.positions = kinematics.positions
        self.table = SignalTable(len(self.joints))
        self._rows: dict[tuple[object, ...], int] = {}
        self._readers: dict[int, Reader] = {}
        self._made_of: dict[int, tuple[int, ...]] = {}
        resources = tuple(_with_features(resources))
        channels = [channel for resource in resources for channel in _channels_of(resource)]
        self.vision = Vision(robot, kinematics, channels)
        self.tips = Tips(robot, kinematics)
        self.clock = self.tips.clock
        self.touch = Touch(robot, kinematics, self.tips)
        self.strain = Strain(robot.joint_torques, kinematics)
        self.sight = VisualSignals(robot, kinematics, self.vision, self.tips, self.touch)
        self.surfaces = Surfaces(robot, self.vision, resources)
        self.blobs = BlobSignals(robot, self.vision, self.sight, resources)
        self.novelty = Novelty(robot, kinematics, self.vision, resources)
        self._binders: dict[type, Callable[[Any], int]] = {
            EffectorConfiguration: self._bind_configuration,
            Posture: self._bind_posture,
            Tip: self._bind_tip,
            Centroid: self._bind_centroid,
            Separation: self._bind_separation,
        }
        self._read_by: dict[type, Callable[[Any], Reading | None]] = {
            FingerLoad: self.touch.finger_load,
            NetLoad: self.touch.net_load,
            NetForces: self.touch.net_forces,
            FingerForces: self.touch.finger_forces,
            BlobSignal: self.blobs.blob,
            StereoSignal: self.blobs.feature,
            NovelHeading: self.novelty.heading,
            ConstellationSignal: self.blobs.constellation,
            StereoOffset: self.blobs.offset,
            InstanceCount: self.blobs.count,
            AffordanceProbability: self._affordance,
        }
        self._seen_by: dict[type, Callable[[Any, tuple[Chain, ...]], Reading | None]] = {
            Heading: self.sight.heading,
            Headings: self.sight.headings,
            StereoPosition: self.sight.position,
        }
        self.reset()

    def reset(self) -> None:
        """Forget the episode before."""
        self.touch.reset()
        self._forget()

    def resume(self, before: Signals) -> None:
        """Begin an episode where another one ended; see ``Touch.resume``.

        Args:
            before: signals of that one; they may be these.
        """
        self.touch.resume(before.touch)
        self._forget()

    def _forget(self) -> None:
        self.strain.reset()
        self.vision.reset()
        self.sight.reset()
        self.blobs.reset()
        self.surfaces.reset()
        self.novelty.reset()
        self.clock[0] = 0

    def update(self, observation: Observation) -> None:
        """Take in one tick's observation.

        Raises:
            SensorError: a joint or load cell is not finite.
        """
        wrenches = self.touch.gathered(observation.loads)
        require_finite(observation, wrenches, self.robot, self.joints.names)
        self.clock[0] += 1
        self.time = observation.time
        self.kinematics.update(observation.positions)
        self.strain.update(observation)
        if self.robot.load_cells:
            self.touch.update(wrenches, observation.time)
            self.sight.update()
        if self.robot.cameras:
            self.vision.update(observation)
            self.blobs.update(observation)
            self.surfaces.update(observation)
            self.novelty.update(observation)
            if self.touch.touching_anything():
                self.vision.touched()
            else:
                self.vision.untouched()

    def bind(self, resource: Resource, chains: tuple[Chain, ...] | None = None) -> int:
        """The number of a resource's row, which it gets the first time.

        Args:
            resource: the resource.
            chains: of casts, that its Jacobian is compiled from; all that lead to joints without.

        Raises:
            CastError: no row of such a source executes one of them.
        """
        key = type(resource.source), resource.source
        if chains is None or chains == chains_of(resource):
            return self._bound(key, lambda: self._bind(resource, chains_of(resource)))
        return self._bound((*key, chains), lambda: self._bind(resource, chains))

    def bind_written(self, size: int) -> int:
        """A row of one's own, to be written with ``table.write``."""
        return self.table.bind(Form(WRITTEN, size, size))

    def bind_tip(
        self, source: Tip, facing: int, standoff: tuple[float, float, float] | Standoff
    ) -> int:
        """The row of a tip whose control point stands off along its z axis.

        Args:
            source: an effector's tip.
            facing: number of the row whose radius it stands off from.
            standoff: clearance beyond that radius, and the least and most distance, m.
        """
        key = "tip", source, facing, standoff
        return self._bound(key, lambda: self._bind_point(source, facing, standoff))

    def bind_joints(self, effector: str) -> int:
        """The row of an effector's joint positions, rad."""
        source = EffectorConfiguration(effector)
        return self._bound((type(source), source), lambda: self._bind_configuration(source))

    def bind_links(self, links: Sequence[str]) -> int:
        """The row of the mean position of some links' frames, m, world frame."""
        key = ("links", *links)
        return self._bound(key, lambda: self._bind_links(links))

    def _bind_links(self, links: Sequence[str]) -> int:
        if len(links) > 1:
            rows = [self.bind_links([link]) for link in links]
            parts = [RowPart(source=row, weight=1.0 / len(rows)) for row in rows]
            number = self.table.bind(Form(MIXTURE, 3, 3, parts))
            self._made_of[number] = tuple(rows)
            return number
        link = self.kinematics.link(links[0])
        part = RowPart(link.frame, link.position, link.rotation.ravel(), link.support)
        return self.table.bind(Form(TIP, 3, 3, (part,)))

    def bind_manipulator(self, effector: str, part: str, joints: Sequence[str]) -> int:
        """The row of the Jacobian of an effector's tip, or of all of a group's, by some joints.

        Its own Jacobian is the curvature (Eq 3.5).

        Args:
            part: ``position`` for three rows a tip, ``pose`` for six.
            joints: whose columns it has, n of them.
        """
        columns = self.joints.pick(joints).tolist()
        tips = [self.tips.part(member) for member in self.robot.members(effector)]
        size = len(tips) * (3 if part == "position" else 6) * len(columns)
        form = Form(MANIPULATOR, size, size, tips, columns, angular=part != "position")
        return self._bound(("manipulator", effector, part, *joints), lambda: self.table.bind(form))

    def bind_displaced(self, resource: Resource, offset: Floats) -> int:
        """The row of a resource that is displaced in the world frame.

        Args:
            resource: the resource.
            offset: in the form of its rows: for an orientation a rotation, row by row.
        """
        base, constant = self.bind(resource), self.bind_written(len(offset))
        self.table.write(constant, Reading(offset, None, 0))
        is_turned = resource.type.name in ("orientation", "pose")
        parts = [RowPart(source=base), RowPart(source=constant)]
        number = self.table.bind(Form(DISPLACED, len(offset), 0, parts, angular=is_turned))
        self._made_of[number] = (*self._made_of.get(base, ()), base, constant)
        return number

    def bind_normal_forces(self, source: FingerForces | NetForces) -> int:
        """The row of forces along normals, N, which can be read without contact, too."""
        return self._bound(
            ("normal", type(source), source), lambda: self._bind_normal_forces(source)
        )

    def release(self, number: int) -> None:
        """Take back a row, which nothing else may be made of."""
        self.table.unbind(number)
        self._readers.pop(number, None)
        self._made_of.pop(number, None)
        self._rows = {key: row for key, row in self._rows.items() if row != number}

    def select(self, rows: Iterable[int]) -> Selection:
        """Rows, and those that they are made of, as ``refresh`` wants them."""
        ordered: dict[int, None] = {}
        for number in rows:
            ordered.update(dict.fromkeys((*self._made_of.get(number, ()), number)))
        compiled = [n for n in ordered if self.table.records["kind"][n] != WRITTEN]
        read = tuple((n, self._readers[n]) for n in ordered if n in self._readers)
        return Selection(np.array(compiled, dtype=np.int64), read)

    def refresh(self, selection: Selection) -> None:
        """Bring rows up to date."""
        self.refresh_read(selection)
        self.kinematics.place()
        if len(selection.compiled):
            refresh(selection.compiled, self.tips.stamp, *self.arrays)

    def refresh_read(self, selection: Selection) -> None:
        """Bring those rows up to date that Python reads."""
        for number, read in selection.read:
            reading = read()
            if reading is None:
                self.table.forget(number)
            else:
                self.table.write(number, reading)

    @property
    def arrays(self) -> tuple[Any, ...]:
        """Arrays that ``refresh`` reads and writes, behind the stamp."""
        table, touch, kinematics = self.table, self.touch, self.kinematics
        return (
            self.positions, touch.loads, touch.feeling,
            table.records, table.parts, table.support, table.value, table.jacobian,
            kinematics.tree, kinematics.frames, kinematics.axes,
        )  # fmt: skip

    def read(self, resource: Resource) -> Reading | None:
        """The resource's value now, or ``None`` while it is undefined; it stays as it is."""
        return self.reading(self.bind(resource), resource.type.name)

    def reading(self, number: int, kind: str = "") -> Reading | None:
        """A row's value now, in the form of a type, or ``None`` while it is undefined."""
        self.refresh(self.select([number]))
        if not self.table.is_defined(number):
            return None
        record = self.table.records[number]
        value, jacobian = self.table.values(number), self.table.rows(number).copy()
        return Reading(shaped(value, kind), jacobian, int(record["stamp"]), float(record["radius"]))

    def _bound(self, key: tuple[object, ...], bind: Callable[[], int]) -> int:
        """The row that is known by a key."""
        number = self._rows.get(key)
        if number is None:
            number = self._rows[key] = bind()
        return number

    def _bind(self, resource: Resource, chains: tuple[Chain, ...]) -> int:
        source = resource.source
        require_executed(resource, chains)
        if isinstance(source, SensorSignal):
            size = resource.type.size
            return self._bind_read(size, sensor_reader(source, size, len(self.joints), self))
        binder = self._binders.get(type(source))
        if binder is not None:
            return binder(source)
        see = self._seen_by.get(type(source))
        if see is not None:
            return self._bind_read(resource.type.size, lambda: see(source, chains))
        read = self._read_by[type(source)]
        return self._bind_read(resource.type.size, lambda: read(source))

    def _affordance(self, source: AffordanceProbability) -> Reading | None:
        """Pr(reward | f, a) by the features now; undefined while one of them is."""
        values = []
        for feature in source.features:
            reading = self.read(feature)
            if reading is None:
                return None
            values.append(reading.value.ravel())
        probability = source.model.reward_given(np.concatenate([*values, np.zeros(0)]))
        return Reading(np.array([probability]), None, int(self.clock[0]))

    def _bind_read(self, size: int, reader: Reader) -> int:
        number = self.bind_written(size)
        self._readers[number] = reader
        return number

    def _bind_configuration(self, source: EffectorConfiguration) -> int:
        columns = self.joints.of(source.effector).tolist()
        number = self.table.bind(Form(CONFIGURATION, len(columns), len(columns), (), columns))
        self.table.rows(number)[np.arange(len(columns)), columns] = 1.0
        return number

    def _bind_posture(self, source: Posture) -> int:
        angles = [
            angle
            for member in self.robot.members(source.effector)
            for angle in self.robot.effectors[member].postures[source.posture]
        ]
        number = self.bind_written(len(angles))
        self.table.write(number, Reading(np.array(angles), None, 0))
        return number

    def _bind_tip(self, source: Tip) -> int:
        members = self.robot.members(source.effector)
        if members == (source.effector,):
            return self._bind_point(source, -1, (0.0, 0.0, 0.0))
        return self._bind_mixture(members, [1.0] * len(members), 3)

    def _bind_point(
        self, source: Tip, facing: int, standoff: tuple[float, float, float] | Standoff
    ) -> int:
        linear, angular = source.part != "orientation", source.part != "position"
        form = Form(
            TIP, 3 * linear + 9 * angular, 3 * linear + 3 * angular,
            (self.tips.part(source.effector),), (), linear, angular, facing, standoff,
        )  # fmt: skip
        number = self.table.bind(form)
        self._made_of[number] = () if facing < 0 else (*self._made_of.get(facing, ()), facing)
        return number

    def _bind_centroid(self, source: Centroid) -> int:
        members = self.robot.members(source.group)
        return self._bind_mixture(members, [1.0 / len(members)] * len(members), 0)

    def _bind_separation(self, source: Separation) -> int:
        return self._bind_mixture(self.robot.members(source.group), [-1.0, 1.0], 0)

    def _bind_mixture(self, members: Sequence[str], weights: Sequence[float], shift: int) -> int:
        """A row of weighted positions of tips, each ``shift`` components behind the one before."""
        tips = [
            self._bound((Tip, Tip(m, "position")), partial(self._bind_tip, Tip(m, "position")))
            for m in members
        ]
        parts = [
            RowPart(source=tip, weight=weight, shift=shift * place)
            for place, (tip, weight) in enumerate(zip(tips, weights, strict=True))
        ]
        size = 3 + shift * (len(members) - 1)
        number = self.table.bind(Form(MIXTURE, size, size, parts))
        self._made_of[number] = tuple(tips)
        return number

    def _bind_normal_forces(self, source: FingerForces | NetForces) -> int:
        if isinstance(source, NetForces):
            hands = len(self.touch.hands(source.group))
            return self._bind_read(hands, lambda: self.touch.palm_forces(source))
        parts, flexion = self.touch.pads(source.hand)
        number = self.table.bind(Form(NORMAL_FORCES, len(parts), len(parts), parts))
        self.table.rows(number)[:] = flexion
        return number

    def sampler(self, resource: Resource, rng: np.random.Generator) -> Sampler:
        """Draws from an internal model or a surface."""
        source = resource.source
        if isinstance(source, SurfacePoint):
            return SurfaceSampler(self.surfaces.by_channel[source.channel], rng)
        assert isinstance(source, (UniformSample, GaussianSample, KernelSample))
        own = self.joints.of(source.effector)
        limits = self.kinematics.lower[own], self.kinematics.upper[own]
        if resource.type == POSITION:
            limits = np.full(3, -np.inf), np.full(3, np.inf)
        if isinstance(source, UniformSample):
            return UniformSampler(*limits, rng)
        return DensitySampler(source, *limits, rng)


def _channels_of(resource: Resource) -> tuple[str, ...]:
    """Channels that the cameras have to look for, of a resource."""
    source = resource.source
    if isinstance(source, RELATIVE):
        return source.channel, source.other
    return (source.channel,) if isinstance(source, VISUAL) else ()


def _with_features(resources: Iterable[Resource]) -> Iterator[Resource]:
    """Resources, and those that probabilities among them are made of."""
    for resource in resources:
        yield resource
        if isinstance(resource.source, AffordanceProbability):
            yield from resource.source.features
