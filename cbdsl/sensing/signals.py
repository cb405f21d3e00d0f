"""Signals: value and Jacobian of every resource, from the observations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

import numpy as np

from cbdsl.documents.robot import HullSection, RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.handle import Handle, hold
from cbdsl.sensing.binders import Binders
from cbdsl.sensing.declared_signal import declared_reader
from cbdsl.sensing.density import Sampler, joint_sampler
from cbdsl.sensing.link_distances import LinkDistances
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.predicted_signals import PredictedSignals
from cbdsl.sensing.sensor_faults import require_finite
from cbdsl.sensing.sensor_readers import SensorReaders
from cbdsl.sensing.signal_arrays import SensedArrays, SignalArrays, TableArrays, TreeArrays
from cbdsl.sensing.table.kinematic_rows import KinematicRows
from cbdsl.sensing.table.reading import Reading, shaped
from cbdsl.sensing.table.refresh import CONTACT, DISPLACED, NORMAL_FORCES, refresh
from cbdsl.sensing.table.signal_rows import Selection, SignalRows
from cbdsl.sensing.table.table import Form, RowPart
from cbdsl.sensing.table.tips import Tips
from cbdsl.sensing.vision.shapes.surface import SurfaceSampler
from cbdsl.types.casts import Chain
from cbdsl.types.resource import NetForces, Origin, Resource, Source
from cbdsl.types.resource_type import POSITION
from cbdsl.types.source_record import (
    Normals,
    chains_of,
    channel_of,
    features_of,
    key_of,
    owner_of,
    record_of,
)


class Signals:
    """Resources as rows of a signal table, updated by an observation a tick.

    A row is undefined if it has no measurement, such as for a channel without a region or a hand
    without contact.

    Args:
        robot: Robot document with the sensors.
        kinematics: Kinematics of the same robot.
        resources: Resources with the channels that the cameras look for.
        hulls: Hulls around the fixtures of the stage to which distances are measured, by name.

    Attributes:
        robot: Robot document.
        table: Table of the rows.
        kinematic_rows: Factory of the rows that follow from joint positions alone.
        distances: Reader of the distances of links.
        positions: Positions of the actuated joints, rad, shape (n,); each observation overwrites
            them.
        clock: Count of the postures, shape (1,).
        time: Time of the newest observation, s.
        is_awaited: True if the world waits for the tick, as simulations do; see
            ``Backend.deadline``.
        observers: Functions called with each observation, such as by readers of images.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        resources: Iterable[Resource],
        hulls: Mapping[str, HullSection] = MappingProxyType({}),
    ) -> None:
        self.robot, self.is_awaited = robot, True
        self.observers: list[Callable[[Observation], None]] = []
        self.kinematics = kinematics
        self.joints = kinematics.joints
        self.positions = kinematics.positions
        self._rows = SignalRows(len(self.joints))
        self.table = self._rows.table
        self._held: tuple[int, Handle | None] = 0, None
        self.tips = Tips(robot, kinematics)
        self.clock = self.tips.clock
        self.kinematic_rows = KinematicRows(robot, kinematics, self.tips, self._rows)
        self.sensors = SensorReaders(robot, kinematics, self.tips)
        self.touch, self.strain = self.sensors.touch, self.sensors.strain
        self.vision, self.sight = self.sensors.vision, self.sensors.sight
        predicted = PredictedSignals(self.read, self.clock, self.vision)
        self.distances = LinkDistances(robot, kinematics, self.read, self.clock, hulls)
        self._binders = Binders(
            self._rows,
            self.kinematic_rows,
            self.sensors,
            predicted,
            self.distances,
            lambda each: declared_reader(each.source, each.type, len(self.joints), self),
        )
        self.follow(resources)
        self.reset()

    def follow(self, resources: Iterable[Resource]) -> None:
        """Sense more resources from now on; the memories of the others stay."""
        # Some resources are computed from features, which are sensed, too.
        more = tuple(each for one in resources for each in (one, *features_of(one.source)))
        self.sensors.follow(more)

    def reset(self) -> None:
        """Forget the previous episode."""
        self.sensors.reset()
        self.clock[0], self.time = 0, 0.0

    def resume(self, before: Signals) -> None:
        """Begin an episode at the end of another one; see ``Touch.resume``.

        Args:
            before: Signals of that episode; may be this object.
        """
        self.sensors.resume(before.sensors)
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
        self.sensors.update(observation, wrenches)
        for notify in self.observers:
            notify(observation)

    def bind(self, resource: Resource, chains: tuple[Chain, ...] | None = None) -> int:
        """Return the number of a resource's row; bind the row at the first call.

        Args:
            resource: Resource of the row.
            chains: Chains of casts that give its Jacobian; by default, all that lead to joints.

        Raises:
            CastError: No row of such a source executes one of the chains.
        """
        key = key_of(resource.source)
        if chains is None or chains == chains_of(resource):
            return self._rows.bound(key, lambda: self._binders.bind(resource, chains_of(resource)))
        return self._rows.bound((*key, chains), lambda: self._binders.bind(resource, chains))

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

    def bind_normal_forces(self, source: Source) -> int:
        """Return the row of forces along normals, N, which is readable without contact, too."""
        key = record_of(source).normals, owner_of(source)
        return self._rows.bound(("normal", *key), lambda: self._bind_normal_forces(*key))

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

    def _bind_normal_forces(self, normals: Normals | None, owner: str) -> int:
        if normals is Normals.PALMS:
            hands, source = len(self.touch.hands(owner)), NetForces(owner)
            form = Form(CONTACT, hands, hands, self.touch.palm_parts(source))
            return self._rows.bind_read(hands, lambda: self.touch.palm_forces(source), form)
        parts, flexion = self.touch.pads(owner)
        number = self._rows.bind(Form(NORMAL_FORCES, len(parts), len(parts), parts))
        self.table.rows(number)[:] = flexion
        return number

    def sampler(self, resource: Resource, rng: np.random.Generator) -> Sampler:
        """Return a sampler of an internal model or a surface."""
        source = resource.source
        if resource.origin is Origin.SURFACE:
            surface = self.sensors.surfaces.by_channel[channel_of(source)]
            return SurfaceSampler(surface, rng)
        own = self.joints.of(owner_of(source))
        limits = self.kinematics.lower[own], self.kinematics.upper[own]
        if resource.type == POSITION:
            limits = np.full(3, -np.inf), np.full(3, np.inf)
        return joint_sampler(source, *limits, rng)
