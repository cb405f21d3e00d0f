"""Signals: value and Jacobian of every resource, from the observations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.handle import Handle, hold
from cbdsl.sensing.declared_sensor import sensor_reader
from cbdsl.sensing.density import DensitySampler, Sampler
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.sensor_faults import require_finite
from cbdsl.sensing.signal_arrays import SensedArrays, SignalArrays, TableArrays, TreeArrays
from cbdsl.sensing.table.chain import require_executed
from cbdsl.sensing.table.kinematic_rows import KinematicRows
from cbdsl.sensing.table.reading import Reading, shaped
from cbdsl.sensing.table.refresh import (
    CONTACT,
    DISPLACED,
    HEADING,
    NORMAL_FORCES,
    WRITTEN,
    refresh,
)
from cbdsl.sensing.table.signal_rows import Selection, SignalRows
from cbdsl.sensing.table.table import Form, RowPart
from cbdsl.sensing.table.tips import Tips
from cbdsl.sensing.touch.strain import Strain
from cbdsl.sensing.touch.touch import Touch
from cbdsl.sensing.uniform import UniformSampler
from cbdsl.sensing.vision.blob_signals import BlobSignals
from cbdsl.sensing.vision.distances import Distances
from cbdsl.sensing.vision.marks import Marks
from cbdsl.sensing.vision.novelty import Novelty
from cbdsl.sensing.vision.solid_signals import SolidSignals
from cbdsl.sensing.vision.surface import SurfaceSampler
from cbdsl.sensing.vision.surfaces import Surfaces
from cbdsl.sensing.vision.vision import Vision
from cbdsl.sensing.vision.visual_signals import VisualSignals
from cbdsl.types.casts import Chain
from cbdsl.types.resource import (
    DERIVED,
    AffordanceProbability,
    BlobSignal,
    Centroid,
    ConstellationSignal,
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    GaussianSample,
    GraspCentre,
    Heading,
    Headings,
    InstanceCount,
    KernelSample,
    MarkHeading,
    NetForces,
    NetLoad,
    NovelHeading,
    ObjectDistance,
    Opening,
    PairLikeness,
    Posture,
    Resource,
    SensorSignal,
    Separation,
    SolidSignal,
    StereoOffset,
    StereoPosition,
    StereoSignal,
    SurfacePoint,
    Tip,
    UniformSample,
)
from cbdsl.types.resource_type import ORIENTATION, POSITION
from cbdsl.types.source_record import chains_of, channels_of

Binder = Callable[[Resource, tuple[Chain, ...]], int]
"""Function that binds a row of a resource with chains of its Jacobian, and returns its number."""


class Signals:
    """Resources as rows of a signal table, updated by an observation a tick.

    A row is undefined if it has no measurement, such as for a channel without a region or a hand
    without contact.

    Args:
        robot: Robot document with the sensors.
        kinematics: Kinematics of the same robot.
        resources: Resources with the channels that the cameras look for.

    Attributes:
        robot: Robot document.
        table: Table of the rows.
        kinematic_rows: Factory of the rows that follow from joint positions alone.
        positions: Positions of the actuated joints, rad, shape (n,); each observation overwrites
            them.
        clock: Count of the postures, shape (1,).
        time: Time of the newest observation, s.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, resources: Iterable[Resource]
    ) -> None:
        self.robot = robot
        self.kinematics = kinematics
        self.joints = kinematics.joints
        self.positions = kinematics.positions
        self._rows = SignalRows(len(self.joints))
        self.table = self._rows.table
        self._held: tuple[int, Handle | None] = 0, None
        resources = tuple(_with_features(resources))
        channels = [channel for each in resources for channel in channels_of(each.source)]
        self.vision = Vision(robot, kinematics, channels)
        self.tips = Tips(robot, kinematics)
        self.clock = self.tips.clock
        self.kinematic_rows = KinematicRows(robot, kinematics, self.tips, self._rows)
        self.touch = Touch(robot, kinematics, self.tips)
        self.strain = Strain(robot.joint_torques, kinematics)
        self.sight = VisualSignals(robot, kinematics, self.vision, self.tips, self.touch)
        self.surfaces = Surfaces(robot, self.vision, resources)
        self.blobs = BlobSignals(robot, self.vision, self.sight, resources)
        self.distances = Distances(robot, kinematics, self.sight)
        self.solids = SolidSignals(robot, self.vision, self.touch, resources)
        self.novelty = Novelty(robot, kinematics, self.vision, resources)
        self.marks = Marks(robot, kinematics, self.vision, resources)
        self._binders = self._make_binders()
        self.reset()

    def reset(self) -> None:
        """Forget the previous episode."""
        self.touch.reset()
        self._forget()

    def resume(self, before: Signals) -> None:
        """Begin an episode at the end of another one; see ``Touch.resume``.

        Args:
            before: Signals of that episode; may be this object.
        """
        self.touch.resume(before.touch)
        self._forget()

    def _forget(self) -> None:
        self.strain.reset()
        self.vision.reset()
        self.sight.reset()
        self.blobs.reset()
        self.surfaces.reset()
        self.solids.reset()
        self.novelty.reset()
        self.marks.reset()
        self.clock[0] = 0

    def update(self, observation: Observation) -> None:
        """Update all sensors from one tick's observation.

        Raises:
            SensorError: A joint or load cell value is not finite.
        """
        wrenches = self.touch.gathered(observation.loads)
        require_finite(observation, wrenches, self.robot, self.joints.names)
        self.clock[0] += 1
        self.time = observation.time
        self.kinematics.update(observation.positions)
        self.strain.update(observation)
        if self.robot.load_cells:
            self.touch.update(wrenches, observation.time)
        self._remember(observation)

    def _remember(self, observation: Observation) -> None:
        """Write all memories of objects, in the order in which they depend on each other.

        Held objects move with the hands before the images are matched with remembered places.
        The other readers follow the matched places. Contact sets velocities to zero at the end, so
        that an image of the same tick cannot restore them.
        """
        if self.robot.load_cells:
            self.vision.carry(self.sight.carried(self.vision.all_memories))
        if not self.robot.cameras:
            return
        self.vision.update(observation)
        for reader in (self.blobs, self.surfaces, self.solids, self.novelty, self.marks):
            reader.update(observation)
        if self.touch.touching_anything():
            self.vision.touched()
        else:
            self.vision.untouched()

    def bind(self, resource: Resource, chains: tuple[Chain, ...] | None = None) -> int:
        """Return the number of a resource's row; bind the row at the first call.

        Args:
            resource: Resource of the row.
            chains: Chains of casts that give its Jacobian; by default, all that lead to joints.

        Raises:
            CastError: No row of such a source executes one of the chains.
        """
        key = type(resource.source), resource.source
        if chains is None or chains == chains_of(resource):
            return self._rows.bound(key, lambda: self._bind(resource, chains_of(resource)))
        return self._rows.bound((*key, chains), lambda: self._bind(resource, chains))

    def bind_written(self, size: int) -> int:
        """Bind a row that the caller writes with ``table.write``; return its number."""
        return self._rows.bind_written(size)

    def bind_displaced(self, resource: Resource, offset: Floats) -> int:
        """Bind a row of a resource that is displaced in the world frame; return its number.

        Args:
            resource: Resource to displace.
            offset: Displacement in the form of its rows; for an orientation, a rotation row by row.
        """
        base, constant = self.bind(resource), self.bind_written(len(offset))
        self.table.write(constant, Reading(offset, None, 0))
        is_turned = resource.type.name in ("orientation", "pose")
        parts = [RowPart(source=base), RowPart(source=constant)]
        form = Form(DISPLACED, len(offset), 0, parts, angular=is_turned)
        return self._rows.bind(form, (base, constant))

    def bind_normal_forces(self, source: FingerForces | NetForces) -> int:
        """Return the row of forces along normals, N, which is readable without contact, too."""
        return self._rows.bound(
            ("normal", type(source), source), lambda: self._bind_normal_forces(source)
        )

    def release(self, number: int) -> None:
        """Free a row; no other row may depend on it."""
        self._rows.release(number)

    def select(self, rows: Iterable[int]) -> Selection:
        """Return rows and their dependencies, in the order for ``refresh``."""
        return self._rows.select(rows)

    def refresh(self, selection: Selection) -> None:
        """Refresh the rows of a selection."""
        self._rows.refresh_read(selection)
        self.kinematics.place()
        if len(selection.compiled):
            refresh(self._handle(), selection.compiled, self.tips.stamp)

    def refresh_read(self, selection: Selection) -> None:
        """Refresh the rows that Python reads."""
        self._rows.refresh_read(selection)

    @property
    def arrays(self) -> SignalArrays:
        """Arrays of measurements, table and joint tree; valid for one version of the table."""
        table, touch, kinematics = self.table, self.touch, self.kinematics
        return SignalArrays(
            SensedArrays(self.positions, touch.loads, touch.feeling),
            TableArrays(table.records, table.parts, table.support, table.value, table.jacobian),
            TreeArrays(kinematics.tree, kinematics.frames, kinematics.axes),
        )

    def _handle(self) -> Handle:
        """Return a handle of the current arrays."""
        version, handle = self._held
        if handle is None or version != self.table.version:
            handle = hold(self.arrays)
            self._held = self.table.version, handle
        return handle

    def read(self, resource: Resource) -> Reading | None:
        """Return a copy of the resource's current reading, or ``None`` while it is undefined."""
        return self.reading(self.bind(resource), resource.type.name)

    def reading(self, number: int, kind: str = "") -> Reading | None:
        """Return a row's current reading in the form of a type, ``None`` while it is undefined."""
        self.refresh(self.select([number]))
        if not self.table.is_defined(number):
            return None
        record = self.table.records[number]
        value, jacobian = self.table.values(number), self.table.rows(number).copy()
        return Reading(shaped(value, kind), jacobian, int(record["stamp"]), float(record["radius"]))

    def _make_binders(self) -> Mapping[type, Binder]:
        """Return the functions that bind a row of each type of source."""
        rows, touch, sight, blobs = self.kinematic_rows, self.touch, self.sight, self.blobs
        return {
            EffectorConfiguration: _compiled(rows.configuration),
            Posture: _compiled(rows.posture),
            Tip: _compiled(rows.tip),
            Centroid: _compiled(rows.centroid),
            Separation: _compiled(rows.separation),
            GraspCentre: _compiled(rows.grasp_centre),
            Opening: _compiled(rows.opening),
            FingerLoad: self._load(touch.finger_load),
            NetLoad: self._load(touch.net_load),
            NetForces: self._load(touch.net_forces),
            FingerForces: self._read_by(touch.finger_forces),
            Heading: self._seen_by(sight.heading, self._heading_form()),
            Headings: self._seen_by(sight.headings, self._heading_form(shift=2)),
            StereoPosition: self._seen_by(sight.position),
            BlobSignal: self._read_by(blobs.blob),
            StereoSignal: self._read_by(blobs.feature),
            ObjectDistance: self._read_by(self.distances.read),
            NovelHeading: self._read_by(self.novelty.heading, self._heading_form()),
            MarkHeading: self._read_by(self.marks.heading, self._heading_form()),
            ConstellationSignal: self._read_by(blobs.constellation),
            StereoOffset: self._read_by(blobs.offset),
            SolidSignal: self._read_by(self.solids.read),
            InstanceCount: self._read_by(blobs.count),
            AffordanceProbability: self._read_by(self._affordance),
            PairLikeness: self._read_by(self._likeness),
            SensorSignal: self._sensor,
        }

    def _bind(self, resource: Resource, chains: tuple[Chain, ...]) -> int:
        require_executed(resource, chains)
        return self._binders[type(resource.source)](resource, chains)

    def _read_by(
        self, read: Callable[[Any], Reading | None], form: Callable[[int], Form] | None = None
    ) -> Binder:
        """Return a binder of rows that Python reads; without chains, by ``_seen_by``."""
        return self._seen_by(lambda source, _: read(source), form)

    def _seen_by(
        self,
        read: Callable[[Any, tuple[Chain, ...]], Reading | None],
        form: Callable[[int], Form] | None = None,
    ) -> Binder:
        """Return a binder of rows that Python reads.

        Args:
            read: Function of a source and of the chains of its Jacobian.
            form: Function of a row's size, for a row whose Jacobian bends.
        """

        def bind(resource: Resource, chains: tuple[Chain, ...]) -> int:
            source, size = resource.source, _size_of(resource)
            return self._rows.bind_read(
                size, lambda: read(source, chains), None if form is None else form(size)
            )

        return bind

    def _load(self, read: Callable[[Any], Reading | None]) -> Binder:
        """Return a binder of rows of contact loads."""

        def bind(resource: Resource, chains: tuple[Chain, ...]) -> int:
            source: Any = resource.source
            size, parts = _size_of(resource), self.touch.contact_parts(source)
            form = Form(CONTACT if parts else WRITTEN, size, size, parts)
            return self._rows.bind_read(size, lambda: read(source), form)

        return bind

    def _heading_form(self, shift: int = 0) -> Callable[[int], Form]:
        return lambda size: Form(HEADING, size, size, self.sight.camera_parts(shift))

    def _sensor(self, resource: Resource, chains: tuple[Chain, ...]) -> int:
        """Bind a row of a sensor whose kind another package adds."""
        source: Any = resource.source
        size = resource.type.size
        return self._rows.bind_read(size, sensor_reader(source, size, len(self.joints), self))

    def _affordance(self, source: AffordanceProbability) -> Reading | None:
        """Return Pr(reward | f, a) for the current features.

        It is ``None`` while a feature is undefined, or unlike all that were tried.
        """
        features = self._features(source.features)
        if features is None or not source.model.knows(features):
            return None
        probability = source.model.reward_given(features)
        return Reading(np.array([probability]), None, int(self.clock[0]))

    def _likeness(self, source: PairLikeness) -> Reading | None:
        """Return the likeness of two objects to a pair, ``None`` while a feature is undefined."""
        features = self._features(source.features)
        if features is None:
            return None
        return Reading(np.array([source.model.likeness(features)]), None, self.vision.images)

    def _features(self, resources: Iterable[Resource]) -> Floats | None:
        """Return the components of some resources, ``None`` while one is undefined."""
        readings = [self.read(resource) for resource in resources]
        values = [reading.value.ravel() for reading in readings if reading is not None]
        return np.concatenate([*values, np.zeros(0)]) if len(values) == len(readings) else None

    def _bind_normal_forces(self, source: FingerForces | NetForces) -> int:
        if isinstance(source, NetForces):
            hands = len(self.touch.hands(source.group))
            form = Form(CONTACT, hands, hands, self.touch.palm_parts(source))
            return self._rows.bind_read(hands, lambda: self.touch.palm_forces(source), form)
        parts, flexion = self.touch.pads(source.hand)
        number = self._rows.bind(Form(NORMAL_FORCES, len(parts), len(parts), parts))
        self.table.rows(number)[:] = flexion
        return number

    def sampler(self, resource: Resource, rng: np.random.Generator) -> Sampler:
        """Return a sampler of an internal model or a surface."""
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


def _compiled(bind: Callable[[Any], int]) -> Binder:
    """Return a binder of rows that are compiled from their parts."""
    return lambda resource, chains: bind(resource.source)


def _size_of(resource: Resource) -> int:
    """Return the number of components of a row; an orientation is a matrix."""
    return 9 if resource.type == ORIENTATION else resource.type.size


def _with_features(resources: Iterable[Resource]) -> Iterator[Resource]:
    """Yield resources, and the features from which some of them are computed."""
    for resource in resources:
        yield resource
        if isinstance(resource.source, DERIVED):
            yield from resource.source.features
