"""Faults of worlds, sensors and drives for the held-out judgement of ``cb why``.

Their mechanisms are others than those of ``injected_faults``, which served the development.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from injected_faults import ChangedModel, Distortion, WorldFault

from cbdsl.backends.backend import BackendError
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.channels import Region
from cbdsl.sensing.observation import Observation

Backend = SimulatedBackend[Any]
Reading = Callable[[Observation], Observation]
# Width and height of the images of all shipped robots, px.
_WIDTH, _HEIGHT = 320.0, 240.0
# Height above its first place at which an object counts as lifted, m.
_LIFTED = 0.03


class TimedFault(WorldFault):
    """Fault that begins at a given time.

    Args:
        begin: Time of the injection, s.
        backend: Backend of the episode.
    """

    def __init__(self, begin: float, backend: Backend) -> None:
        super().__init__(backend)
        self.onset = begin

    def is_due(self, tick: Tick) -> bool:
        return tick.observation.time >= self.onset


class TimedRemoval(TimedFault):
    """Removal of an object.

    Args:
        begin: Time of the removal, s.
        name: Name of the object in its context.
        backend: Backend of the episode.
    """

    def __init__(self, begin: float, name: str, backend: Backend) -> None:
        super().__init__(begin, backend)
        self._name = name

    def inject(self) -> None:
        self.engine.remove(self._name)


class Kick(TimedFault):
    """Blow that throws the last object away.

    Args:
        begin: Time of the blow, s.
        velocity: Velocity of the object after it, m/s.
        backend: Backend of the episode.
    """

    def __init__(self, begin: float, velocity: Sequence[float], backend: Backend) -> None:
        super().__init__(begin, backend)
        self._velocity = np.array(velocity)

    def inject(self) -> None:
        self.engine.launch(self.engine.names()[-1], self._velocity)


class Pull(WorldFault):
    """Force that pulls an object down whenever a hand has lifted it.

    Args:
        strength: Force, N.
        backend: Backend of the episode.
    """

    repeats = True

    def __init__(self, strength: float, backend: Backend) -> None:
        super().__init__(backend)
        self._strength, self._low = strength, np.nan

    def note_tick(self, tick: Tick) -> None:
        name = self.engine.names()[-1]
        height = float(self.engine.pose(name).position[2])
        self._low = height if np.isnan(self._low) else min(self._low, height)
        is_held = height > self._low + _LIFTED and bool(self.engine.touching(name))
        if is_held and self.time is None:
            self.time = tick.observation.time
        body = self.engine._world.body(name).number
        self.engine._world.data.xfrc_applied[body, 2] = -self._strength if is_held else 0.0


class Jam(TimedFault):
    """Drive that keeps its position under all commands.

    Args:
        begin: Time of the first lost command, s.
        joint: Name of the joint.
        backend: Backend of the episode.
    """

    def __init__(self, begin: float, joint: str, backend: Backend) -> None:
        super().__init__(begin, backend)
        self._joint = backend._joints.names.index(joint)

    def inject(self) -> None:
        joint, apply = self._joint, self.backend.apply
        frozen = float(self.backend.observe().positions[joint])

        def applied(reference: Any) -> None:
            changed = np.array(reference, dtype=float)
            changed[joint] = frozen
            apply(changed)

        self.backend.apply = applied  # type: ignore[method-assign]


class Limp(TimedFault):
    """Servos that lose their power.

    Args:
        begin: Time of the loss, s.
        part: Part of the names of their joints.
        backend: Backend of the episode.
    """

    def __init__(self, begin: float, part: str, backend: Backend) -> None:
        super().__init__(begin, backend)
        self._part = part

    def inject(self) -> None:
        model = self.engine._world.model
        for servo in range(model.nu):
            if self._part in model.actuator(servo).name:
                model.actuator_gainprm[servo] = 0.0
                model.actuator_biasprm[servo] = 0.0


class Unplugged(TimedFault):
    """Link to the robot that breaks."""

    def inject(self) -> None:
        def broken() -> Any:
            raise BackendError("the robot's driver does not answer: connection reset by peer")

        self.backend.observe = broken  # type: ignore[method-assign]


class LaterDistortion(TimedFault):
    """Sensors that read otherwise from a time on.

    Args:
        begin: Time of the first changed reading, s.
        change: Change of an observation.
        backend: Backend of the episode.
    """

    def __init__(self, begin: float, change: Reading, backend: Backend) -> None:
        super().__init__(begin, backend)
        self._change = change

    def inject(self) -> None:
        observe, change = self.backend.observe, self._change
        self.backend.observe = lambda: change(observe())  # type: ignore[method-assign]


def broken_loads(seen: Observation) -> Observation:
    """Let a load cell give no number."""
    return replace(seen, loads={cell: np.full(6, np.nan) for cell in seen.loads})


class HiddenFrom:
    """Channel that one camera does not see.

    Args:
        camera: Name of the camera.
        channel: Name of the channel; empty for all channels.
    """

    def __init__(self, camera: str, channel: str = "") -> None:
        self._camera, self._channel = camera, channel

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation without the regions that are hidden."""
        if not seen.regions:
            return seen
        channels = seen.regions.get(self._camera, {})
        kept = {n: r for n, r in channels.items() if self._channel and n != self._channel}
        return replace(seen, regions={**seen.regions, self._camera: kept})


def each_region(change: Callable[[Region], Region], camera: str = "") -> Reading:
    """Return a change of all regions of one camera, or of all cameras."""

    def changed(seen: Observation) -> Observation:
        regions = {
            own: channels
            if camera not in ("", own)
            else {name: tuple(map(change, of)) for name, of in channels.items()}
            for own, channels in seen.regions.items()
        }
        return replace(seen, regions=regions)

    return changed


def mirrored(region: Region) -> Region:
    """Mirror a region at the vertical axis of its image."""
    return region._replace(column=_WIDTH - region.column)


def flipped(region: Region) -> Region:
    """Turn a region by half a turn about the centre of its image."""
    return region._replace(column=_WIDTH - region.column, row=_HEIGHT - region.row)


def zoomed(factor: float, region: Region) -> Region:
    """Scale a region's place about the centre of its image, as another lens would."""
    column, row = _WIDTH / 2, _HEIGHT / 2
    return region._replace(
        column=column + factor * (region.column - column), row=row + factor * (region.row - row)
    )


def squeezed(region: Region) -> Region:
    """Scale columns as if pixels were not square."""
    return region._replace(column=_WIDTH / 2 + 1.25 * (region.column - _WIDTH / 2))


def coarse(region: Region) -> Region:
    """Round a region's place to a grid of 24 px, as if images were thumbnails."""
    return region._replace(
        column=24.0 * round(region.column / 24.0), row=24.0 * round(region.row / 24.0)
    )


def swapped_cameras(seen: Observation) -> Observation:
    """Exchange the images of both cameras."""
    if len(seen.regions) != 2:
        return seen
    one, other = seen.regions
    return replace(seen, regions={one: seen.regions[other], other: seen.regions[one]})


class NoisyRegions:
    """Places of regions with noise, as of a poor image.

    Args:
        deviation: Standard deviation, px.
    """

    def __init__(self, deviation: float) -> None:
        self._deviation, self._rng = deviation, np.random.default_rng(7)

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with displaced regions."""
        return each_region(self._displaced)(seen)

    def _displaced(self, region: Region) -> Region:
        column, row = self._deviation * self._rng.standard_normal(2)
        return region._replace(column=region.column + column, row=region.row + row)


class DroppedFrames:
    """Images of which most are lost on their way.

    Args:
        kept: Number of images of which one arrives.
    """

    def __init__(self, kept: int) -> None:
        self._kept, self._count = kept, 0

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with or without its images."""
        if not seen.regions:
            return seen
        self._count += 1
        return seen if self._count % self._kept == 1 else replace(seen, regions={})


def inverted_loads(seen: Observation) -> Observation:
    """Change the sign of all loads."""
    return replace(seen, loads={cell: -load for cell, load in seen.loads.items()})


def crossed_fingers(seen: Observation) -> Observation:
    """Give each finger the load of the next one, as crossed cables do."""
    cells = list(seen.loads)
    loads = [seen.loads[cell] for cell in cells]
    return replace(seen, loads=dict(zip(cells, [*loads[1:], loads[0]], strict=True)))


class TurnedCells:
    """Load cells that are mounted a quarter turn askew, by an axis of the world."""

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with turned loads."""
        turned = np.array([2, 0, 1, 5, 3, 4])
        return replace(seen, loads={cell: load[turned] for cell, load in seen.loads.items()})


class Tared:
    """Load cells that were tared under a load, which appears after a moment.

    Args:
        bias: Wrench that is added, N and N m.
        begin: Time from which it is added, s.
    """

    def __init__(self, bias: Sequence[float], begin: float) -> None:
        self._bias, self._begin = np.array(bias), begin

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with a bias of all loads."""
        if seen.time < self._begin:
            return seen
        return replace(seen, loads={cell: load + self._bias for cell, load in seen.loads.items()})


class NoisyLoads:
    """Loads with electric noise.

    Args:
        deviation: Standard deviation, N.
    """

    def __init__(self, deviation: float) -> None:
        self._deviation, self._rng = deviation, np.random.default_rng(11)

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with noisy loads."""
        loads = {
            cell: load + self._deviation * self._rng.standard_normal(6)
            for cell, load in seen.loads.items()
        }
        return replace(seen, loads=loads)


def coarse_loads(seen: Observation) -> Observation:
    """Round each force to 4 N, as if a converter had lost its low bits."""
    return replace(seen, loads={c: 4.0 * np.round(load / 4.0) for c, load in seen.loads.items()})


def changed_joint(joint: int, change: Callable[[float], float]) -> Reading:
    """Return a change of the reading of one encoder."""

    def changed(seen: Observation) -> Observation:
        positions = seen.positions.copy()
        positions[joint] = change(float(positions[joint]))
        return replace(seen, positions=positions)

    return changed


def coarse_encoders(seen: Observation) -> Observation:
    """Round the readings of all encoders to 0.08 rad or m / 8."""
    return replace(seen, positions=0.08 * np.round(seen.positions / 0.08))


def swapped_encoders(one: int, other: int) -> Reading:
    """Return a change that exchanges two encoders."""

    def changed(seen: Observation) -> Observation:
        positions = seen.positions.copy()
        positions[[one, other]] = positions[[other, one]]
        return replace(seen, positions=positions)

    return changed


class SlippingEncoder:
    """Encoder whose wheel slips: it loses a share of each motion.

    Args:
        joint: Index of the joint.
        share: Share of each motion that it reads.
    """

    def __init__(self, joint: int, share: float) -> None:
        self._joint, self._share = joint, share
        self._before, self._read = np.nan, np.nan

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with the lagging reading."""
        true = float(seen.positions[self._joint])
        step = 0.0 if np.isnan(self._before) else true - self._before
        self._read = true if np.isnan(self._before) else self._read + self._share * step
        self._before = true
        return changed_joint(self._joint, lambda _: self._read)(seen)


class ShuffledTicks:
    """Readings of positions that arrive in another order.

    Args:
        ticks: Number of readings that are delivered in reverse order.
    """

    def __init__(self, ticks: int) -> None:
        self._ticks, self._queue = ticks, deque[Any]()
        self._last: deque[Any] = deque(maxlen=ticks)

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with a reading from the reversed queue."""
        self._last.append(seen.positions.copy())
        if not self._queue:
            self._queue.extend(reversed(self._last))
        return replace(seen, positions=self._queue.popleft())


def _displaced_body(part: str, offset: Sequence[float], model: Any) -> None:
    for body in range(model.nbody):
        if model.body(body).name.endswith(part):
            model.body_pos[body] += np.array(offset)


def displaced_body(part: str, offset: Sequence[float]) -> Callable[[Backend], WorldFault]:
    """Return a fault by which a link is mounted elsewhere than in the robot's model.

    Args:
        part: End of the name of the link.
        offset: Displacement in the frame of its parent, m.
    """
    return partial(ChangedModel, partial(_displaced_body, part, offset))


def springy(model: Any) -> None:
    """Let contacts bounce."""
    for table in (model.geom_solref, model.pair_solref):
        table[:] = [-2000.0, -1.0]


def spongy(model: Any) -> None:
    """Let contacts give way like foam."""
    for table in (model.geom_solref, model.pair_solref):
        table[:] = [0.25, 1.0]


def viscous(model: Any) -> None:
    """Fill the room with syrup."""
    model.opt.density, model.opt.viscosity = 1200.0, 300.0


class ObjectForce(WorldFault):
    """Force on the last object that depends on its place, in all ticks.

    Args:
        force: Force, N, of displacement from the first place, m, and time, s.
        backend: Backend of the episode.
    """

    repeats = True

    def __init__(
        self, force: Callable[[np.ndarray, float], Sequence[float]], backend: Backend
    ) -> None:
        super().__init__(backend)
        self._force = force
        self._first: Any = None
        self._now = 0.0

    def is_due(self, tick: Tick) -> bool:
        self._now = tick.observation.time
        return True

    def inject(self) -> None:
        """Apply the force to the object's centre."""
        name = self.engine.names()[-1]
        position = np.array(self.engine.pose(name).position)
        self._first = position if self._first is None else self._first
        body = self.engine._world.body(name).number
        force = self._force(position - self._first, self._now)
        self.engine._world.data.xfrc_applied[body, :3] = force


def glue(moved: np.ndarray, _: float) -> Sequence[float]:
    """Hold an object to its place by glue that never lets go within 12 cm."""
    return (-800.0 * moved).tolist() if np.linalg.norm(moved) < 0.12 else [0.0, 0.0, 0.0]


def magnet(moved: np.ndarray, _: float) -> Sequence[float]:
    """Pull an object down by a magnet in the table."""
    return [0.0, 0.0, -35.0 / (1.0 + (max(moved[2], 0.0) / 0.05) ** 3)]


def tether(moved: np.ndarray, _: float) -> Sequence[float]:
    """Pull an object back by a rubber band that is tight beyond 5 cm."""
    distance = float(np.linalg.norm(moved))
    pull: list[float] = (-90.0 * max(distance - 0.05, 0.0) / max(distance, 1e-6) * moved).tolist()
    return pull


def shaking(_: np.ndarray, now: float) -> Sequence[float]:
    """Shake an object along the table."""
    return [0.0, 4.0 * float(np.sin(40.0 * now)), 0.0]


def balloon(_: np.ndarray, now: float) -> Sequence[float]:
    """Pull an object up by a balloon, stronger than its weight."""
    return [0.0, 0.0, 1.2 if now > 1.0 else 0.0]


class TiltingTable(WorldFault):
    """Floor that tilts slowly from the beginning, with all that stands on it.

    Args:
        rate: Rate of the tilt, rad/s.
        backend: Backend of the episode.
    """

    repeats = True

    def __init__(self, rate: float, backend: Backend) -> None:
        super().__init__(backend)
        self._rate, self._now = rate, 0.0

    def is_due(self, tick: Tick) -> bool:
        self._now = tick.observation.time
        return True

    def inject(self) -> None:
        """Turn gravity."""
        angle = self._rate * self._now
        gravity = 9.81 * np.array([0.0, np.sin(angle), -np.cos(angle)])
        self.engine._world.model.opt.gravity[:] = gravity


def distorted(change: Reading) -> Callable[[Backend], WorldFault]:
    """Return a fault of readings without state of their own."""
    return partial(Distortion, change)


def stateful(make: Callable[..., Reading], *words: Any) -> Callable[[Backend], WorldFault]:
    """Return a fault of readings that is made again for each episode."""
    return lambda backend: Distortion(make(*words), backend)
