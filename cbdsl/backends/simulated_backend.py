"""Backend of a simulated robot: all code that engines share."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from cbdsl.backends.backend import BackendError, embody
from cbdsl.backends.cameras.camera_system import CameraSystem, Chance, Exposure
from cbdsl.backends.cameras.rendered import RenderedCameras
from cbdsl.backends.staging.cell_offsets import CellOffsets
from cbdsl.backends.staging.encoders import Encoders
from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.episode_start import draw_start
from cbdsl.backends.staging.experimenter import Experimenter
from cbdsl.backends.staging.load_cells import LoadCells
from cbdsl.backends.staging.sampler import ScenarioSampler
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel
from cbdsl.sensing.observation import Loads, Observation


class Shutter:
    """Shutter that opens at the cameras' rate, which need not divide the control rate.

    Args:
        rate: Image rate, Hz.
        period: Control period, s.
    """

    def __init__(self, rate: float, period: float) -> None:
        self._per_tick = rate * period

    def opens(self, tick: int) -> bool:
        """Return whether an image became due within the last tick; the first is due at tick 0."""
        # Number of images due by then; a small share keeps rounding from delaying one.
        due = tick * self._per_tick + 1e-6
        return tick == 0 or int(due) > int(due - self._per_tick)


SomeEngine = TypeVar("SomeEngine", bound=Engine)

# Number of ticks for which load cell noise is drawn at a time, if it has its own generator.
_AHEAD = 64
_NOTHING = Exposure()


class SimulatedBackend(Generic[SomeEngine]):
    """Robot in an engine; see ``Backend``.

    Args:
        robot: Robot document.
        model: URDF model of the robot.
        engine: Engine that moves the robot.
        cameras: Cameras of the robot.
        rate: Control rate, Hz.
        substeps: Number of engine steps per control period.

    Attributes:
        renderer: Source of the images, for people.
        control_period: Simulated time of one step, s.
        deadline: ``None``, as a simulated world waits.
        truth: State that only the engine knows, for the experimenter, recordings and tests.
    """

    deadline: float | None = None

    def __init__(
        self,
        robot: RobotDocument,
        model: UrdfModel,
        engine: SomeEngine,
        cameras: CameraSystem,
        rate: float,
        substeps: int = 1,
    ) -> None:
        self._robot, self.truth, self._cameras = robot, engine, cameras
        self._model = model
        self._joints = Joints(robot)
        limits = [model.joints[name] for name in self._joints.names]
        self._nearest_to_zero = np.array([min(max(0.0, j.lower), j.upper) for j in limits])
        self._substeps = substeps
        self.control_period = 1 / rate
        self.renderer = cameras.renderer
        self._shutter = Shutter(robot.vision.rate, self.control_period)
        self._encoders = Encoders(robot, self.control_period)
        # Latency is in whole ticks, because observations exist at ticks only.
        self._latency = round(robot.vision.latency * rate)
        # Stage and context of the world.
        self._world: tuple[StageDocument, str] | None = None
        self._reference: Floats = self._nearest_to_zero

    @property
    def cameras(self) -> RenderedCameras:
        """Cameras that make images.

        Raises:
            BackendError: The cameras are ideal and make none.
        """
        if not isinstance(self._cameras, RenderedCameras):
            raise BackendError("ideal cameras make no images; 'rendered' ones do")
        return self._cameras

    def look_for(self, channels: Collection[str]) -> None:
        """Look for regions of other channels from now on."""
        self._cameras.look_for(channels)

    def colors_in_view(self) -> tuple[str, ...]:
        """Return the named colours that any camera sees now, without noise."""
        return () if self._is_dark() else self._cameras.colors()

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode; see ``Backend.reset``."""
        return self._set_up(stage, context, rng, channels)

    def set_up_around(
        self, stage: StageDocument, context: str | None, rng: np.random.Generator
    ) -> str:
        """Begin an episode around the robot; see ``StagingBackend``."""
        posture, references = self.truth.read()[0].copy(), self._reference
        name = self._set_up(stage, context, rng, None, posture)
        # Under load, references differ from positions: the robot keeps both.
        self._reference = self._reached = references
        return name

    def _set_up(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None,
        posture: Floats | None = None,
    ) -> str:
        """Begin an episode in a posture, or in that of the context if ``None``."""
        self._world = None  # none until it is complete
        name, noise, start = draw_start(
            stage, context, self._robot, self._joints, self._nearest_to_zero, rng
        )
        chosen = stage.contexts[name]
        self._tick = self._began = 0
        self._dark = math.inf if chosen.dark_after is None else chosen.dark_after
        self._reference = self._reached = start if posture is None else posture
        self.truth.begin(self._reference)
        self._cells, self._offsets = self._load_cells(noise), self._cell_offsets(noise)
        sampler = ScenarioSampler(stage, self._robot, self.truth.link_pose, rng)
        self._experimenter = Experimenter(sampler, chosen, self.truth)
        self._cameras.begin(self.truth, stage.disturbance, channels, Chance(rng, noise))
        self._observation = self._begin()
        self._world = stage, name
        return name

    def resume(
        self,
        stage: StageDocument,
        context: str | None,
        channels: Collection[str] | None = None,
        *,
        undisturbed: bool = False,
    ) -> str | None:
        """Begin an episode in the world as it is; see ``ResumableBackend.resume``."""
        if self._world is None or self._world[0] is not stage:
            return None
        name = self._world[1]
        if context not in (None, name):
            return None
        self._began = self._tick
        if not undisturbed:
            self._experimenter.take_turn(stage.world)
        self._cameras.look_for(channels)
        self._observation = self._begin()
        return name

    def _load_cells(self, noise: np.random.Generator) -> LoadCells:
        # An engine with one step per tick samples its cells less often than the robot's cells do.
        own = self.control_period / self._substeps
        # Physics period of cells whose engine makes fewer steps than the robot file requests.
        physical = own if self._substeps > 1 else 1 / self._robot.simulation.physics_rate
        ahead = 1 if isinstance(self._cameras, RenderedCameras) else _AHEAD
        return LoadCells(self.truth.cells, self._robot.contact, (own, physical), noise, ahead)

    def _cell_offsets(self, noise: np.random.Generator) -> CellOffsets:
        links = [self._robot.load_cells[hand][finger].link for hand, finger in self.truth.cells]
        tips, rows = [self._model.bodies[k] for k in links], [self.truth.rows[k] for k in links]
        # The offsets have a separate stream, as noise may be drawn ahead.
        own = noise.spawn(1)[0]
        return CellOffsets(tips, rows, self._robot.contact, self.control_period, own)

    def observe(self) -> Observation:
        """Return the current sensor values."""
        return self._observation

    def _begin(self) -> Observation:
        """Return the first observation of an episode.

        The cameras have been running and the scene has been still: the newest image is current.
        """
        self._exposures: deque[tuple[int, Exposure]] = deque()
        positions, velocities = self._encoders.begin(self.truth.read()[0])
        return self._sensed(positions, velocities, self._expose(), self._tick)

    def _sense(self) -> Observation:
        positions, velocities = self._encoders.read(self.truth.read()[0])
        if self._shutter.opens(self._tick):
            self._exposures.append((self._tick, self._expose()))
        # Exposures wait in a queue, oldest first, until their latency has passed.
        if not self._exposures or self._exposures[0][0] + self._latency > self._tick:
            return self._sensed(positions, velocities)
        taken, exposure = self._exposures.popleft()
        return self._sensed(positions, velocities, exposure, taken)

    def _sensed(
        self,
        positions: Floats,
        velocities: Floats,
        exposure: Exposure = _NOTHING,
        taken: int | None = None,
    ) -> Observation:
        loads = self._cells.read()
        return Observation(
            time=(self._tick - self._began) * self.control_period,
            positions=positions,
            velocities=velocities,
            loads=Loads(loads.cells, self._offsets.added(loads.wrenches, self.truth.placements)),
            images=exposure.images,
            regions=exposure.regions,
            efforts=self.truth.efforts() if self._robot.joint_torques is not None else None,
            exposed=None if taken is None else (taken - self._began) * self.control_period,
        )

    def _is_dark(self) -> bool:
        return self._tick * self.control_period >= self._dark

    def _expose(self) -> Exposure:
        if self._is_dark():
            return self._cameras.take_in_the_dark()
        return self._cameras.take()

    def apply(self, reference: Floats) -> None:
        """Set the references of the actuated joints, rad, shape (n,), for the end of the step."""
        self._reference = np.array(reference, dtype=np.float64)

    def step(self) -> None:
        """Let one control period pass.

        Joint references move linearly over the physics steps: a jump per control period would shake
        held objects out of the hand.
        """
        count = self._substeps
        for substep in range(1, count + 1):
            # The experimenter acts at the beginning of a physics step, in ticks since the reset.
            begun = self._tick + (substep - 1) / count
            self._experimenter.act(begun * self.control_period)
            self.truth.step(self._reference if count == 1 else self._between(substep / count))
            self._cells.sample(self.truth.wrenches())
        # Once per tick, unlike the cells, which sample in each physics step.
        self._offsets.drift()
        self._reached = self._reference
        self._tick += 1
        self._observation = self._sense()

    def _between(self, share: float) -> Floats:
        """Return the references after a share of the control period."""
        return self._reached + (self._reference - self._reached) * share

    def halt(self) -> None:
        """Freeze the references at the measured positions; without a world nothing moves."""
        if self._world is None:
            return
        # Both, since the next step would interpolate from the last reference otherwise.
        self._reference = self._reached = self._observation.positions

    def close(self) -> None:
        """Leave the engine and free the renderer."""
        self._cameras.close()
        self.truth.close()


def simulate(
    name: str, robot: RobotDocument, urdf: Path, *, cameras: str | None = None
) -> SimulatedBackend[Any]:
    """Return a robot on the backend of a name, which must be a simulated one with its truth.

    Raises:
        BackendError: The backend is not a simulated one; see also ``embody``.
    """
    backend = embody(name, robot, urdf, cameras=cameras)
    if isinstance(backend, SimulatedBackend):
        return backend
    backend.close()
    raise BackendError(f"backend '{name}' has no engine whose truth could be asked")
