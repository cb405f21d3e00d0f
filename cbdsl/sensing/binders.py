"""Binders: functions that bind the rows of the signal table, one for each type of source."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from cbdsl.sensing.link_distances import LinkDistances
from cbdsl.sensing.predicted_signals import PredictedSignals
from cbdsl.sensing.sensor_readers import SensorReaders
from cbdsl.sensing.table.chain import require_executed
from cbdsl.sensing.table.kinematic_rows import KinematicRows
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.table.refresh import CONTACT, HEADING, WRITTEN
from cbdsl.sensing.table.signal_rows import Reader, SignalRows
from cbdsl.sensing.table.table import Form, RowPart
from cbdsl.types import resource as sources
from cbdsl.types.casts import Chain
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import ORIENTATION

Binder = Callable[[Resource, tuple[Chain, ...]], int]
"""Function that binds a row of a resource with chains of its Jacobian, and returns its number."""


class Binders:
    """Binders of rows by the type of their sources.

    Args:
        rows: Rows of the signal table.
        kinematic_rows: Factory of the rows that follow from joint positions alone.
        sensors: Readers of the sensors.
        predicted: Reader of predicted signals.
        distances: Reader of the distances of links.
        declared: Function of a resource of another package that returns its reader.
    """

    def __init__(
        self,
        rows: SignalRows,
        kinematic_rows: KinematicRows,
        sensors: SensorReaders,
        predicted: PredictedSignals,
        distances: LinkDistances,
        declared: Callable[[Any], Reader],
    ) -> None:
        self._rows, self._sight = rows, sensors.sight
        touch, sight, blobs = sensors.touch, sensors.sight, sensors.blobs
        self._by_type: Mapping[type, Binder] = {
            sources.EffectorConfiguration: _compiled(kinematic_rows.configuration),
            sources.Posture: _compiled(kinematic_rows.posture),
            sources.Turned: _compiled(kinematic_rows.turned),
            sources.Tip: _compiled(kinematic_rows.tip),
            sources.Centroid: _compiled(kinematic_rows.centroid),
            sources.Separation: _compiled(kinematic_rows.separation),
            sources.GraspCentre: _compiled(kinematic_rows.grasp_centre),
            sources.Opening: _compiled(kinematic_rows.opening),
            sources.LinkDistance: self._read_by(distances.read),
            sources.FingerLoad: self._load(touch.finger_load, touch.finger_parts),
            sources.NetLoad: self._load(touch.net_load, touch.hand_parts),
            sources.NetForces: self._load(touch.net_forces, touch.group_parts),
            sources.FingerForces: self._read_by(touch.finger_forces),
            sources.Heading: self._seen_by(sight.heading, self._heading()),
            sources.Headings: self._seen_by(sight.headings, self._heading(shift=2)),
            sources.StereoPosition: self._seen_by(sight.position),
            sources.BlobSignal: self._read_by(blobs.blob),
            sources.StereoSignal: self._read_by(blobs.feature),
            sources.ObjectDistance: self._read_by(sensors.distances.read),
            sources.NovelHeading: self._read_by(sensors.novelty.heading, self._heading()),
            sources.MarkHeading: self._read_by(sensors.marks.heading, self._heading()),
            sources.ConstellationSignal: self._read_by(blobs.constellation),
            sources.StereoOffset: self._read_by(blobs.offset),
            sources.SolidSignal: self._read_by(sensors.solids.read),
            sources.InstanceCount: self._read_by(blobs.count),
            sources.AffordanceProbability: self._read_by(predicted.affordance),
            sources.PairLikeness: self._read_by(predicted.likeness),
            sources.SensorSignal: self._declared(declared),
            sources.ModelSignal: self._declared(declared),
        }

    def bind(self, resource: Resource, chains: tuple[Chain, ...]) -> int:
        """Bind a row of a resource with chains of its Jacobian; return the row's number.

        Raises:
            CastError: No row of such a source executes one of the chains.
        """
        require_executed(resource, chains)
        return self._by_type[type(resource.source)](resource, chains)

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

    def _load(
        self, read: Callable[[Any], Reading | None], parts_of: Callable[[Any], list[RowPart]]
    ) -> Binder:
        """Return a binder of rows of contact loads, whose forces are compiled from fingertips."""

        def bind(resource: Resource, chains: tuple[Chain, ...]) -> int:
            source, size = resource.source, _size_of(resource)
            parts = parts_of(source)
            form = Form(CONTACT if parts else WRITTEN, size, size, parts)
            return self._rows.bind_read(size, lambda: read(source), form)

        return bind

    def _declared(self, reader_of: Callable[[Any], Reader]) -> Binder:
        return lambda one, chains: self._rows.bind_read(
            _size_of(one), reader_of(one), Form(WRITTEN, _size_of(one), one.type.size)
        )

    def _heading(self, shift: int = 0) -> Callable[[int], Form]:
        return lambda size: Form(HEADING, size, size, self._sight.camera_parts(shift))


def _compiled(bind: Callable[[Any], int]) -> Binder:
    """Return a binder of rows that are compiled from their parts."""
    return lambda resource, chains: bind(resource.source)


def _size_of(resource: Resource) -> int:
    """Return the number of components of a row; an orientation is a matrix."""
    return 9 if resource.type == ORIENTATION else resource.type.size
