"""Faults of worlds, sensors and drives, injected into simulated episodes between control ticks."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.kinematics.pose import Pose
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.explanation import named_runs
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.channels import Region
from cbdsl.sensing.observation import Observation

# Tick-wise injections act from this time on, s.
_LATER = 1.5


class WorldFault(EpisodeObserver):
    """Fault of the world or the backend, injected between two control ticks.

    Attributes:
        time: Time of the first injection, s; ``None`` before it.
        repeats: True if it is injected whenever it is due.
    """

    repeats = False

    def __init__(self, backend: SimulatedBackend[Any]) -> None:
        self.backend, self.engine = backend, backend.truth
        self.time: float | None = None

    def note_tick(self, tick: Tick) -> None:
        """Inject the fault when it is due."""
        if (self.time is None or self.repeats) and self.is_due(tick):
            self.time = tick.observation.time if self.time is None else self.time
            self.inject()

    def is_due(self, tick: Tick) -> bool:
        """Return whether the fault is due in a tick."""
        return tick.observation.time >= _LATER

    def inject(self) -> None:
        """Inject the fault."""
        raise NotImplementedError

    def take_away(self, distance: float) -> None:
        """Put the first object elsewhere on its level, by a distance, m."""
        name = self.engine.names()[-1]
        pose = self.engine.pose(name)
        self.engine.put_back(
            name, Pose(pose.position + np.array([0.0, distance, 0.0]), pose.rotation)
        )


class Removal(WorldFault):
    """Removal of the object during the approach."""

    def inject(self) -> None:
        self.engine.remove(self.engine.names()[-1])


class InjectedSlip(WorldFault):
    """Object that leaves the hand whenever the hand has moved it for half a second."""

    repeats, _held = True, 0

    def is_due(self, tick: Tick) -> bool:
        moves = ("up", "move", "carry")
        runs = named_runs(tick.run)
        is_moving = any(n.split(".")[-1] in moves and r.predicate == "0" for n, r in runs)
        self._held = self._held + 1 if is_moving else 0
        return self._held > 0.5 / self.backend.control_period

    def inject(self) -> None:
        self.take_away(0.25)


class FrozenJoint(WorldFault):
    """Drive of one joint of the arm that stops."""

    def inject(self) -> None:
        joints = [n for n, j in enumerate(self.backend._joints.names) if j.endswith(("_4", "4"))]
        joint, apply = joints[-1], self.backend.apply
        frozen = float(self.backend.observe().positions[joint])

        def applied(reference: Any) -> None:
            changed = np.array(reference, dtype=float)
            changed[joint] = frozen
            apply(changed)

        self.backend.apply = applied  # type: ignore[method-assign]


class Halt(WorldFault):
    """Sensor that gives no number any more."""

    def inject(self) -> None:
        observe = self.backend.observe

        def broken() -> Any:
            observation = observe()
            return replace(observation, positions=np.full_like(observation.positions, np.nan))

        self.backend.observe = broken  # type: ignore[method-assign]


class OneEye(WorldFault):
    """Camera that sees nothing from the beginning."""

    def __init__(self, backend: SimulatedBackend[Any]) -> None:
        super().__init__(backend)
        observe = self.backend.observe

        def half() -> Any:
            observation = observe()
            if not observation.regions:
                return observation
            blind = next(iter(observation.regions))
            return replace(observation, regions={**observation.regions, blind: {}})

        self.backend.observe = half  # type: ignore[method-assign]

    def is_due(self, tick: Tick) -> bool:
        return True

    def inject(self) -> None:
        """Leave the world as it is."""


class Distortion(WorldFault):
    """Sensors that read otherwise from the beginning."""

    def __init__(
        self, change: Callable[[Observation], Observation], backend: SimulatedBackend[Any]
    ) -> None:
        super().__init__(backend)
        observe = self.backend.observe
        self.backend.observe = lambda: change(observe())  # type: ignore[method-assign]

    def is_due(self, tick: Tick) -> bool:
        return True

    def inject(self) -> None:
        """Leave the world as it is."""


def scaled_loads(factor: float) -> Callable[[Observation], Observation]:
    return lambda seen: replace(seen, loads={c: factor * load for c, load in seen.loads.items()})


def drifting_loads(seen: Observation) -> Observation:
    drift = np.array([0.0, 0.0, 0.5 * seen.time, 0.0, 0.0, 0.0])
    return replace(seen, loads={cell: load + drift for cell, load in seen.loads.items()})


def offset_joint(seen: Observation) -> Observation:
    positions = seen.positions.copy()
    positions[1] += 0.1
    return replace(seen, positions=positions)


def shifted_rows(seen: Observation) -> Observation:
    """Shift the rows of one camera by 25 px, as if it had turned in its mount."""
    if not seen.regions:
        return seen
    camera, channels = next(iter(seen.regions.items()))
    moved = {n: tuple(r._replace(row=r.row + 25.0) for r in of) for n, of in channels.items()}
    return replace(seen, regions={**seen.regions, camera: moved})


class StaleImages:
    """Cameras that repeat their first images."""

    def __init__(self) -> None:
        self._first: Mapping[str, Any] = {}

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with the first regions in place of later ones."""
        if not seen.regions:
            return seen
        self._first = self._first or seen.regions
        return replace(seen, regions=self._first)


class DelayedReadings:
    """One kind of readings that arrives later than the others.

    Args:
        key: Field of ``Observation``.
        ticks: Delay in control ticks; images count exposures.
    """

    def __init__(self, key: str, ticks: int) -> None:
        self._key, self._ticks = key, ticks
        self._queue: deque[Any] = deque()

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with an earlier reading, or the first one."""
        value = getattr(seen, self._key)
        if self._key == "regions" and not value:
            return seen
        self._queue.append(value.copy() if isinstance(value, np.ndarray) else value)
        while len(self._queue) > self._ticks + 1:
            self._queue.popleft()
        return replace(seen, **{self._key: self._queue[0]})


class NoisyReadings:
    """Readings with noise of their own.

    Args:
        key: Field of ``Observation``.
        deviation: Standard deviation, in the unit of the field.
    """

    def __init__(self, key: str, deviation: float) -> None:
        self._key, self._deviation = key, deviation
        self._rng = np.random.default_rng(0)

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with noise."""
        value = np.asarray(getattr(seen, self._key), dtype=float)
        noisy = value + self._deviation * self._rng.standard_normal(value.shape)
        changed: Any = {self._key: noisy if noisy.shape else float(noisy)}
        return replace(seen, **changed)


def scaled_joint(seen: Observation) -> Observation:
    """Scale the reading of the fourth joint, as if its encoder had other lines."""
    positions = seen.positions.copy()
    positions[3] *= 0.9
    return replace(seen, positions=positions)


def cropped_loads(seen: Observation) -> Observation:
    """Limit each force, as if the amplifier saturated."""
    loads = {cell: np.clip(load, -0.6, 0.6) for cell, load in seen.loads.items()}
    return replace(seen, loads=loads)


def rolled_camera(seen: Observation) -> Observation:
    """Turn the images of one camera by 12 deg about their centre."""
    if not seen.regions:
        return seen
    camera, channels = next(iter(seen.regions.items()))
    rolled = {name: tuple(map(_rolled, regions)) for name, regions in channels.items()}
    return replace(seen, regions={**seen.regions, camera: rolled})


def _rolled(region: Region) -> Region:
    (u, v), (c, s) = (region.column - 160.0, region.row - 120.0), (0.978, 0.208)
    return region._replace(column=160.0 + c * u - s * v, row=120.0 + s * u + c * v)


def stuck_fingers(seen: Observation) -> Observation:
    """Let the last joint read its opened position."""
    positions = seen.positions.copy()
    positions[-1] = 0.039
    return replace(seen, positions=positions)


class LateCommands(WorldFault):
    """References that reach the drives later than they were sent."""

    def __init__(self, ticks: int, backend: SimulatedBackend[Any]) -> None:
        super().__init__(backend)
        apply, queue = backend.apply, deque[Any]()

        def delayed(reference: Any) -> None:
            queue.append(np.array(reference, dtype=float))
            apply(queue.popleft() if len(queue) > ticks else queue[0])

        backend.apply = delayed  # type: ignore[method-assign]

    def inject(self) -> None:
        """Leave the world as it is."""


class ChangedModel(WorldFault):
    """Physics of MuJoCo that differs from the beginning.

    Args:
        change: Change of the compiled model.
        backend: Backend of the episode.
    """

    def __init__(self, change: Callable[[Any], None], backend: SimulatedBackend[Any]) -> None:
        super().__init__(backend)
        self._change = change

    def is_due(self, tick: Tick) -> bool:
        return True

    def inject(self) -> None:
        """Change the model once the world is complete."""
        self._change(self.engine._world.model)


def heavy_world(model: Any) -> None:
    """Let gravity pull four times as much."""
    model.opt.gravity[:] *= 4.0


def sideways_world(model: Any) -> None:
    """Let gravity pull along the table as well, as if the robot stood askew."""
    model.opt.gravity[:] = [0.0, 6.0, -7.8]


def tough_joint(model: Any) -> None:
    """Add dry friction to the robot's second joint."""
    model.dof_frictionloss[1] = 60.0


def weak_drives(model: Any) -> None:
    """Reduce the stiffness of all servos to a fiftieth, with their damping."""
    model.actuator_gainprm[:, 0] *= 0.02
    model.actuator_biasprm[:, 1:3] *= 0.02


class Drift(WorldFault):
    """Object that a hidden belt carries along its level, 12 cm/s, from the approach on."""

    repeats = True

    def inject(self) -> None:
        self.take_away(0.12 * self.backend.control_period)


class Wind(WorldFault):
    """Force that pushes the object all the time."""

    repeats = True

    def is_due(self, tick: Tick) -> bool:
        return True

    def inject(self) -> None:
        """Push the object along the table."""
        body = self.engine._world.body(self.engine.names()[-1]).number
        self.engine._world.data.xfrc_applied[body, 1] = 0.7
