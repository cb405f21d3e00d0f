"""A backend without physics: ideal servos, ideal cameras, and contacts by geometry."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.ideal_cameras.cameras import Cameras, Limbs
from cbdsl.backends.ideal_cameras.links import Links
from cbdsl.backends.ideal_cameras.paint import Palette
from cbdsl.backends.ideal_cameras.tree import Tree
from cbdsl.backends.kinematic.experimenter import Experimenter
from cbdsl.backends.kinematic.handling import Handling
from cbdsl.backends.kinematic.hands import Hands
from cbdsl.backends.kinematic.load_cells import LoadCells
from cbdsl.backends.kinematic.servos import Servos
from cbdsl.backends.kinematic.truth import Truth
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.context import choose_context, starting_posture
from cbdsl.backends.staging.presentation import Presenter
from cbdsl.backends.staging.shutter import Shutter
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.chains import root
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.urdf import UrdfError, UrdfModel, read_urdf
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.observation import Observation

Floats = NDArray[np.float64]

# Ticks of the robot's own control cycle in one of ours. With more, an arm that is stretched out
# to something beyond its reach swings from tick to tick.
_SPARSER = 3


class KinematicBackend:
    """A robot that is moved, in a world that gives way.

    Joints are where their references are. Cameras see regions of colour where things are, as far as
    nothing hides them. Fingertips are springs along the surfaces that they are pressed into;
    those that go too deep are held back. What is grasped goes where the hands go, and what nobody
    holds falls onto fixtures, rolls and slides, but never topples. There are fewer ticks than the
    robot's control rate asks for.

    Args:
        robot: what can be sensed and moved.
        urdf: its model.
        gui: must be false, since there is no window.

    Attributes:
        renderer: what makes the images, for people.
        control_period: simulated time of one step, s.

    Raises:
        BackendError: robot file and model do not fit together, or a window is asked for.
    """

    def __init__(self, robot: RobotDocument, urdf: Path, gui: bool = False) -> None:
        if gui:
            raise BackendError("the kinematic backend has no window")
        _require_fit(robot, urdf)
        links, kinematics = Links(urdf), Kinematics(robot, urdf)
        self._robot = robot
        self.renderer = "ideal cameras" if robot.cameras else "nothing"
        self._joints = kinematics.joints
        self._tree = Tree(urdf, self._joints, robot.base)
        self.control_period = 1 / rate_of(robot)
        self._shutter = Shutter(robot.vision.rate, self.control_period)
        self._servos = Servos(kinematics, links, self._tree, self.control_period)
        self._hands = Hands(robot, kinematics, self._tree, links)
        self._limbs = Limbs(robot, kinematics, self._tree, links)
        self._palette = Palette(robot.vision.channels)
        self._nearest_to_zero = np.clip(0.0, kinematics.lower, kinematics.upper)

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode; see ``Backend.reset``."""
        name = choose_context(stage, context, rng)
        chosen = stage.contexts[name]
        # The sensors' noise has a stream of its own: who else draws from rng cannot change it.
        noise = np.random.default_rng(rng.integers(2**63))
        self._tick = 0
        self._positions = starting_posture(
            chosen, self._robot, self._joints, self._nearest_to_zero, rng
        )
        self._reference = self._positions.copy()
        self._velocities = np.zeros_like(self._positions)
        self._tree.update(self._positions)
        self._world = World()
        presentation = Presenter(stage, self._robot, self._tree.pose, rng).present(chosen)
        self._experimenter = Experimenter(presentation, self._world)
        self._handling = Handling(self._world, self._hands, self._experimenter.shown)
        #: What only the simulator knows, for tests.
        self.truth = Truth(self._world, self._tree, self._handling)
        self._cells = LoadCells(self._hands.cells, self._robot, self.control_period, noise)
        self._cameras = Cameras(
            self._robot,
            self._tree,
            self._limbs,
            self._palette,
            tuple(channel_names(self._robot.vision.channels)) if channels is None else channels,
            stage.disturbance,
            rng,
        )
        self._observation = self._sense()
        return name

    def observe(self) -> Observation:
        """The sensors now."""
        return self._observation

    def _sense(self) -> Observation:
        return Observation(
            time=self._tick * self.control_period,
            positions=self._positions,
            velocities=self._velocities,
            loads=self._cells.read(),
            images={},
            regions=self._cameras.look(self._world) if self._shutter.opens(self._tick) else {},
        )

    def apply(self, reference: Floats) -> None:
        """Set the references of the actuated joints, rad, shape (n,), for the end of the step."""
        self._reference[:] = reference

    def step(self) -> None:
        """Let one control period pass."""
        before = self._positions
        self._positions, self._velocities = self._servos.follow(before, self._reference)
        self._experimenter.act(self._tick * self.control_period, touched=self._handling.touched)
        self._handling.move(self.control_period)
        if self._handling.touch():
            self._hold_back(before)
        self._cells.sample(self._handling.press())
        self._tick += 1
        self._observation = self._sense()

    def _hold_back(self, before: Floats) -> None:
        """What a fingertip cannot push away holds back the joints that push.

        They go half of their way, or half of that. Without a joint that is held back, and that
        fingers share, another one may go deeper: all are asked again until nobody does.
        """
        wanted, share = self._positions, np.ones(len(before))
        while self._handling.hold_back(share):
            self._positions = before + share * (wanted - before)
            self._velocities = (self._positions - before) / self.control_period
            self._tree.update(self._positions)
            self._handling.touch()

    def close(self) -> None:
        """Nothing is held."""


def rate_of(robot: RobotDocument) -> float:
    """How often the robot is controlled here, Hz.

    What has no inertia needs no fast control, and an episode costs what its ticks cost.
    """
    return min(robot.control.rate, max(robot.control.rate / _SPARSER, robot.vision.rate))


def _require_fit(robot: RobotDocument, urdf: Path) -> None:
    """Find out whether a model is that of a robot.

    Raises:
        BackendError: it cannot be read, or lacks something that the robot file names.
    """
    try:
        model = read_urdf(urdf)
    except UrdfError as error:
        raise BackendError(f"the model cannot be read: {error}") from error
    base = root(model)
    if base != robot.base:
        raise BackendError(
            f"robot '{robot.name}' has the base '{robot.base}', "
            f"but the root link of {urdf.name} is '{base}'"
        )
    joints = [joint for effector in robot.effectors.values() for joint in effector.joints]
    missing = set(joints + list(robot.couplings)) - set(model.revolute)
    if missing:
        raise BackendError(
            f"{urdf.name} has no revolute joint {', '.join(map(repr, sorted(missing)))}, "
            f"which robot '{robot.name}' names"
        )
    _require_links(robot, model)


def _require_links(robot: RobotDocument, model: UrdfModel) -> None:
    named = [camera.link for camera in robot.cameras.values()]
    named += [cell.link for fingers in robot.load_cells.values() for cell in fingers.values()]
    named += [each.tip.link for each in robot.effectors.values() if each.tip is not None]
    for link in named:
        if link not in model.links:
            raise BackendError(
                f"{model.path.name} has no link '{link}', which robot '{robot.name}' names"
            )
