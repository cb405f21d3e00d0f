"""Kind of sensor ``box_edges``: how a hand takes a seen object, and where parts of it are then.

It uses the regions of both cameras and the encoders alone. Its signals are named by colours:

- ``red``: the orientation of a hand that closes on the sides of a box; see ``box_fit``. The fingers
  close along a horizontal edge of the box: the shorter one if edges differ, or else the edge nearer
  to their direction now. Before the object was seen whole, and for a round object, the orientation
  keeps that direction.
- ``red_blue``: the orientation of a hand that closes across the line between two objects; undefined
  before both were seen.
- ``held_red``: the place of a part of a thing, which moves with the hand that holds the thing.
- ``beyond_red_blue``: the place, likewise, on the far part of a bar from another thing at its end.
- ``ahead_red``: the orientation of a hand that looks down and has such a part ahead, along x.
- ``to_left``, ``to_right``, ``down``: the orientation of a hand that looks along y, against it or
  down, and whose fingers close along x.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np

from cbdsl.extend.source import (
    ORIENTATION,
    POSITION,
    Reading,
    ResourceType,
    RobotDocument,
    Sensor,
    SensorSignal,
    Signals,
    SourceKind,
)
from cbdsl_reproduction.worlds.box_fit import Floats, fit_box

# Least ratio of horizontal edges that counts as unequal, and least contrast of a box.
_LONG, _EDGED = 1.3, 1.5
_COLOURS = ("red", "yellow", "green", "blue")
_HELD, _BEYOND, _AHEAD = "held_", "beyond_", "ahead_"
_DOWN = (0.0, 0.0, -1.0)
_LOOKS = {"to_left": (0.0, 1.0, 0.0), "to_right": (0.0, -1.0, 0.0), "down": _DOWN}
# Place on a bar as a share of the distance from the thing at its end to its middle.
_FAR = 0.6
# Largest step of a long turn, rad: the nearest way to it leads in the direction of the turn.
_STEP = 2.0
_MARGIN = 0.05  # rad


def signals_of(sensor: Sensor, robot: RobotDocument) -> Mapping[str, ResourceType]:
    """Return the orientations by colour and by pair of colours, and the places by colour."""
    del sensor, robot
    pairs = [f"{one}_{other}" for one, other in combinations(sorted(_COLOURS, reverse=True), 2)]
    ahead = [f"{_AHEAD}{colour}" for colour in _COLOURS]
    ways = dict.fromkeys([*_COLOURS, *pairs, *ahead, *_LOOKS], ORIENTATION)
    places = [f"{_HELD}{colour}" for colour in _COLOURS] + [f"{_BEYOND}{pair}" for pair in pairs]
    return ways | dict.fromkeys(places, POSITION)


class HandReader:
    """Parts that all readers of a hand share.

    Args:
        signal: Signal of the sensor.
        signals: Signals of the robot.
    """

    def __init__(self, signal: SensorSignal, signals: Signals) -> None:
        self._signals, self._part = signals, signal.part
        self._channels = [part for part in signal.part.split("_") if part in _COLOURS]
        self._hand = signals.robot.sensors[signal.sensor].hand or ""
        cells = signals.robot.load_cells[self._hand].values()
        self._pads = [cell.link for cell in cells]
        self._arm = _arm_of(signals, next(iter(cells)).joint)
        self._nothing = np.zeros((3, len(signals.joints)))
        signals.vision.look_for(self._channels)

    def _places(self) -> list[Floats] | None:
        """Return the places of the seen objects; ``None`` unless all are known."""
        memories = [self._signals.vision.memory(channel) for channel in self._channels]
        places = [m.position for m in memories if m is not None and m.position is not None]
        return places if len(places) == len(memories) else None

    def _closing(self) -> Floats:
        """Return the direction from the first pad to the others, world frame, shape (3,)."""
        first, *others = (self._signals.kinematics.frame(pad).position for pad in self._pads)
        direction: Floats = np.mean(others, axis=0) - first
        return direction

    def _facing_down(self, angle: float) -> Floats:
        """Return the orientation of a tip that looks down and closes along an angle, (3, 3)."""
        return self._looking(_DOWN, (math.cos(angle), math.sin(angle), 0.0))

    def _looking(self, way: Sequence[float], closing: Sequence[float]) -> Floats:
        """Return the orientation of a tip that looks along a way and closes across it, (3, 3)."""
        rotation = self._signals.tips.frame(self._arm).rotation
        x, y, _ = (rotation.T @ self._closing()).tolist()
        own = np.array([x, y, 0.0]) / math.hypot(x, y)
        before = np.column_stack([own, np.cross([0.0, 0.0, 1.0], own), [0.0, 0.0, 1.0]])
        after = np.column_stack([closing, np.cross(way, closing), way])
        turned: Floats = after @ before.T
        return turned


class EdgeReader(HandReader):
    """Reader of the orientation of a hand that closes on an object."""

    def __init__(self, signal: SensorSignal, signals: Signals) -> None:
        super().__init__(signal, signals)
        self._stamp, self._seen = -1, np.zeros(0)
        self._angle: float | None = None

    def __call__(self) -> Reading | None:
        """Return the orientation in this tick."""
        images = self._signals.vision.images
        if images < self._stamp:
            self._angle, self._seen = None, np.zeros(0)
        if images != self._stamp:
            self._stamp = images
            self._look()
        closing = self._closing()
        angle = math.atan2(closing[1], closing[0]) if self._angle is None else self._angle
        return Reading(self._facing_down(angle), self._nothing, self._signals.clock[0])

    def _look(self) -> None:
        """Fit a box to the object in the newest images if they show all of it."""
        vision, touch = self._signals.vision, self._signals.touch
        (channel,) = self._channels
        memory = vision.memory(channel)
        if memory is None or memory.position is None or touch.touching_anything():
            return
        if not memory.is_seen_whole:
            return
        rows, jacobians = [], []
        for name, camera in self._signals.robot.main_cameras.items():
            region, frame = vision.region(name, channel), vision.field.frames.get(name)
            if region is None or region.clipped or frame is None:
                return
            scale, (columns, mixed, down) = camera.focal_length**-2, region.moments
            rows.append([region.area * scale, columns * scale, mixed * scale, down * scale])
            jacobians.append(image_jacobian(frame.rotation, memory.position - frame.position))
        silhouettes = np.array(rows)
        # Images of an object at rest before still cameras are equal.
        if not np.array_equal(silhouettes, self._seen):
            self._seen = silhouettes
            self._angle = self._across(np.array(jacobians), silhouettes)

    def _across(self, jacobians: Floats, silhouettes: Floats) -> float | None:
        """Return the direction in which fingers close, rad; ``None`` for a round object."""
        box = fit_box(jacobians, silhouettes)
        if box.contrast < _EDGED:
            return self._angle
        first, second, _ = box.edges.tolist()
        turns = range(4)
        if max(first, second) > _LONG * min(first, second):
            turns = range(0, 4, 2) if first < second else range(1, 4, 2)
        return self._nearest(box.heading + turn * math.pi / 2 for turn in turns)

    def _nearest(self, angles: Iterable[float]) -> float:
        """Return the angle that is nearest to the direction of the fingers, rad."""
        closing = self._closing()
        now = math.atan2(closing[1], closing[0]) if self._angle is None else self._angle
        return min(angles, key=lambda angle: 1.0 - math.cos(angle - now))


class LineReader(EdgeReader):
    """Reader of the orientation of a hand that closes across the line between two objects."""

    def __call__(self) -> Reading | None:
        """Return the orientation in this tick; ``None`` before both objects were seen."""
        turned = super().__call__()
        return None if self._angle is None else turned

    def _look(self) -> None:
        places = self._places()
        if places is None or self._signals.touch.touching_anything():
            return
        x, y, _ = (places[1] - places[0]).tolist()
        along = math.atan2(y, x)
        self._angle = self._nearest([along + math.pi / 2, along - math.pi / 2])


class LookReader(HandReader):
    """Reader of the orientation of a hand that looks along an axis and closes along x."""

    def __call__(self) -> Reading:
        """Return the orientation in this tick, with the nearer of two turns."""
        closing = (math.copysign(1.0, float(self._closing()[0])), 0.0, 0.0)
        turned = self._looking(_LOOKS[self._part], closing)
        return Reading(turned, self._nothing, self._signals.clock[0])


class HeldPart(HandReader):
    """Reader of the place of a part of a thing, which moves with the hand that holds the thing."""

    def __init__(self, signal: SensorSignal, signals: Signals) -> None:
        super().__init__(signal, signals)
        self._own: Floats | None = None

    def __call__(self) -> Reading | None:
        """Return the place in this tick; ``None`` before the part was seen."""
        signals = self._signals
        tip, away = signals.tips.point(self._arm), self._away()
        if away is None:
            return None
        x, y, z = away
        # With the lever r and the angular velocity w, the part moves by w x r = -r x w.
        across = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        jacobian = tip.jacobian[:3] + across @ tip.jacobian[3:]
        return Reading(tip.position + away, jacobian, signals.clock[0])

    def _away(self) -> Floats | None:
        """Return the place of the part from the tip, m, world axes, shape (3,)."""
        signals = self._signals
        start, end = signals.touch.span(self._hand)
        rotation = signals.tips.frame(self._arm).rotation
        if not signals.touch.feeling[start:end].all() or self._own is None:
            seen, tip = self._places(), signals.tips.point(self._arm).position
            self._own = None if seen is None else rotation.T @ (_place(*seen) - tip)
        return None if self._own is None else rotation @ self._own


class AheadReader(HeldPart):
    """Reader of the orientation of a hand that looks down and has a part ahead."""

    def __call__(self) -> Reading | None:
        """Return the orientation in this tick; ``None`` before the part was seen."""
        away = self._away()
        if away is None:
            return None
        turn = self._possible(-math.atan2(away[1], away[0]))
        closing = self._closing()
        angle = math.atan2(closing[1], closing[0]) + float(np.clip(turn, -_STEP, _STEP))
        return Reading(self._facing_down(angle), self._nothing, self._signals.clock[0])

    def _possible(self, turn: float) -> float:
        """Return the turn of a hand that the limits of its last joint allow, rad."""
        signals = self._signals
        kinematics = signals.kinematics
        last = signals.joints.of(self._arm)[-1]
        sign = math.copysign(1.0, signals.tips.point(self._arm).jacobian[5, last])
        turns = sorted((turn, turn - math.tau, turn + math.tau), key=abs)
        ends = [kinematics.positions[last] + sign * each for each in turns]
        lower, upper = kinematics.lower[last] + _MARGIN, kinematics.upper[last] - _MARGIN
        fits = [each for each, end in zip(turns, ends, strict=True) if lower < end < upper]
        return fits[0] if fits else turn


def _place(bar: Floats, end: Floats | None = None) -> Floats:
    """Return the place of a thing, or that on the far part of a bar from the thing at its end."""
    return bar if end is None else bar + _FAR * (bar - end)


def _arm_of(signals: Signals, joint: str) -> str:
    """Return the effector with a tip that carries a joint."""
    above = signals.kinematics.above(joint)
    robot = signals.robot
    arms = [name for name, each in robot.effectors.items() if each.tip and each.joints]
    return max(arms, key=lambda name: len(above & set(robot.effectors[name].joints)))


def image_jacobian(rotation: Floats, away: Floats) -> Floats:
    """Return the change of image coordinates, to the right and down, at focal length 1, (2, 3).

    Args:
        rotation: Orientation of the camera, which looks along x with z up, shape (3, 3).
        away: Place of the object from the camera, m, world axes, shape (3,).
    """
    x, y, z = (rotation.T @ away).tolist()
    local = np.array([[-y / x, 1.0, 0.0], [-z / x, 0.0, 1.0]]) / -x
    jacobian: Floats = local @ rotation.T
    return jacobian


def reader(signal: SensorSignal, signals: Signals) -> Callable[[], Reading | None]:
    """Return the reader of a signal."""
    if signal.part.startswith(_AHEAD):
        return AheadReader(signal, signals)
    if signal.part.startswith((_HELD, _BEYOND)):
        return HeldPart(signal, signals)
    if signal.part in _LOOKS:
        return LookReader(signal, signals)
    return (LineReader if "_" in signal.part else EdgeReader)(signal, signals)


EDGES = SourceKind(
    "box_edges",
    "orientation of a hand that takes a seen box or bar, and places of parts of a held thing",
    signals_of,
    "cbdsl_reproduction.worlds.edge_sensor:reader",
    needs=("hand",),
)
