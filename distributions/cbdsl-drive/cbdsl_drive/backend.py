"""Backend of a real robot, by the drivers of its document."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import (
    BackendError,
    Floats,
    Image,
    Kinematics,
    Loads,
    Observation,
    Person,
    Regions,
    RobotDocument,
    StageDocument,
    draw_start,
    read_fitting,
)
from cbdsl.extend.driver import (
    Command,
    Endpoint,
    ImageSample,
    RegionsSample,
    Setup,
    horizon,
)
from cbdsl_drive.clock import Clock
from cbdsl_drive.connection import Connection, Opener
from cbdsl_drive.joint_limits import joint_limits
from cbdsl_drive.links import open_links, require_drivers
from cbdsl_drive.person import RefusingPerson
from cbdsl_drive.real_time import RealTime
from cbdsl_drive.safety_supervisor import SafetySupervisor, State
from cbdsl_drive.setup import describe_setup
from cbdsl_drive.views import with_views
from cbdsl_drive.way_back import WayBack

# Time between two polls for a new state, s.
_PAUSE = 5e-4
# A joint at its start is closer to it, rad or m.
_AWAY = 0.05
# Longest time until a robot stands at its start after the last reference, s.
_ARRIVAL = 2.0
# Cause of a hold that is no fault.
HALTED = "the program was halted"


class DrivenBackend:
    """A real robot behind the drivers of its document; see ``Backend``.

    Args:
        robot: Robot with drivers.
        urdf: URDF of the robot.
        gui: False, since a real robot has no window.
        cameras: ``ideal`` if the drivers' ``regions`` replace images.
        opener: Opens the drivers.
        clock: Times of this computer.

    Attributes:
        renderer: Source of the images, for people.
        control_period: Time of one step, s.
        supervisor: State machine that decides when references pass.

    Raises:
        BackendError: The robot has no drivers, or they do not cover it.
    """

    renderer = "the robot's cameras"

    def __init__(
        self,
        robot: RobotDocument,
        urdf: Path,
        *,
        gui: bool = False,
        cameras: str | None = None,
        opener: Opener = open_links,
        clock: Clock = Clock(),  # noqa: B008 (immutable)
    ) -> None:
        if gui:
            raise BackendError("a real robot has no window; leave --gui out")
        self._require_cover(robot, cameras)
        robot = with_views(robot, ideal=cameras == "ideal")
        self._robot, self._clock = robot, clock
        model = read_fitting(robot, urdf)
        self.control_period = 1.0 / robot.control.rate
        self.supervisor = SafetySupervisor(
            robot, model, self.control_period, ideal=cameras == "ideal"
        )
        self._kinematics = Kinematics(robot, urdf)
        limits = joint_limits(robot, model)
        self._way_back = WayBack(robot, model, self._kinematics, limits)
        # Joints without a start posture begin each episode where they began the first one.
        self._first: Floats | None = None
        self._cells = tuple((h, f) for h, cells in robot.load_cells.items() for f in cells)
        self._commanded = {
            name: (tuple(driver.joints.get(j, j) for j in joints), self._columns(joints))
            for name, driver in robot.drivers.items()
            for joints in [[j for effector in driver.moves for j in robot.joints(effector)]]
            if driver.commands is not None
        }
        self._deadline = min(driver.deadline for driver in robot.drivers.values())
        self._person: Person = RefusingPerson()
        self._connection = Connection(robot, self.supervisor, opener, clock)
        self._real_time = RealTime() if clock.is_real else None
        self._observation: Observation | None = None

    @staticmethod
    def _require_cover(robot: RobotDocument, cameras: str | None) -> None:
        """Refuse robots of which a part has no driver."""
        require_drivers(robot)
        if not any(driver.states for driver in robot.drivers.values()):
            raise BackendError(f"no driver of robot '{robot.name}' has joint states")
        driven = {j for d in robot.drivers.values() for e in d.moves for j in robot.joints(e)}
        for name, effector in robot.effectors.items():
            if not driven.issuperset(effector.joints):
                raise BackendError(f"no driver of robot '{robot.name}' moves effector '{name}'")
        read = {(h, f) for d in robot.drivers.values() for h, fs in d.wrenches.items() for f in fs}
        for hand, cells in robot.load_cells.items():
            for finger in cells:
                if (hand, finger) not in read:
                    raise BackendError(f"no driver reads load cell '{hand}.{finger}'")
        ideal = cameras == "ideal"
        views = {c for d in robot.drivers.values() for c in (d.regions if ideal else d.images)}
        if ideal and not views:
            raise BackendError("no driver has regions; leave --cameras ideal out")
        # A robot without any view may run programs that need none.
        for camera in robot.cameras if views else ():
            if camera not in views:
                raise BackendError(f"no driver reads camera '{camera}'")

    def _columns(self, joints: Sequence[str]) -> NDArray[np.intp]:
        names = self.supervisor.joints.names
        return np.array([names.index(joint) for joint in joints], dtype=np.intp)

    @property
    def deadline(self) -> float | None:
        """Longest computation of a control tick, s; ``None`` before the robot may move.

        The first tick loads machine code, and the robot stands meanwhile.
        """
        if self.supervisor.state in (State.OFF, State.READY):
            return None
        return self.supervisor.patience

    def attend(self, person: Person, interface: str | None = None) -> None:
        """Set the person who confirms the stage, and the network interface.

        Args:
            person: Person who answers.
            interface: Network interface; loopback only if ``None``.
        """
        self._person, self._connection.interface = person, interface

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode on a stage that is set up; see ``Backend.reset``.

        A robot away from its start releases held objects and returns by motion within its limits.
        Then it waits, without references, until the stage is set up: by the simulation
        that serves the robot, or by the person.

        Raises:
            BackendError: The robot is not ready, cannot return, or the person refuses; the message
                has a line for each reason.
        """
        drawn = rng.bit_generator.state
        # Order: the links listen, a person confirms, and only then does the robot get a commander.
        # A refusal leaves other programs on the robot undisturbed.
        self._leave_last()
        self._connection.open()
        self._connection.await_ready()
        here = self.supervisor.joints.positions
        if self._first is None:
            self._first = here.copy()
        start = draw_start(stage, context, self._robot, self._kinematics.joints, self._first, rng)
        if np.abs(here - start.posture).max(initial=0.0) > _AWAY:
            self._return(here.copy(), start.posture)
        self._connection.await_stage(Setup(self._robot.name, stage, context, drawn))
        setup = describe_setup(stage, start.context, self._robot)
        if not self._person.confirm(setup, "is this set up, and may the robot move", released=True):
            raise BackendError("the stage is not set up: no reference was sent")
        self._make_ready()
        self._way_back.begin(self.supervisor.joints.positions)
        self._observation = self._sense()
        return start.context

    def _make_ready(self) -> None:
        """Become the robot's commander.

        Raises:
            BackendError: The robot is not ready.
        """
        if self._real_time is not None:
            self._real_time.begin()
        # Messages queued while the person answered are old.
        self.supervisor.rest()
        self._connection.claim()
        self._connection.drain()
        # The robot may have changed while the person answered.
        self._connection.await_ready()
        self.supervisor.make_ready(self._clock.monotonic())
        # Time 0 of the episode is by the robot's clock, as all stamps are.
        self._began = self.supervisor.joints.stamp
        self._due = self._clock.monotonic()

    def _return(self, here: Floats, goal: Floats) -> None:
        """Let go, and move from measured positions to a goal, rad or m, shape (n,); then rest.

        Raises:
            BackendError: The person refuses, the way is not free, or the robot is held.
        """
        names, errors = self.supervisor.joints.names, np.abs(goal - here)
        farthest = int(errors.argmax())
        known = self._way_back.is_known(here)
        text = (
            f"the robot is away from its start: joint '{names[farthest]}' by "
            f"{errors[farthest]:.2f}; it opens its hands and returns "
            + ("on the way that it came" if known else "upwards, then straight")
        )
        points = self._way_back.points(here, goal)
        if not known and (links := self._way_back.self_contact(points)):
            raise BackendError(
                f"{text}, where links '{links[0]}' and '{links[1]}' would touch: bring it near its "
                "start by hand"
            )
        if not self._person.confirm(text, "may it return", released=True):
            raise BackendError(f"{text}; a person has to allow it")
        if not known:
            self._way_back.begin(here)
        self._make_ready()
        for reference in self._way_back.references(points, self.control_period):
            self.apply(reference)
            self.step()
        for _ in range(round(_ARRIVAL / self.control_period)):
            if np.abs(self.supervisor.joints.positions - goal).max() < _AWAY:
                break
            self.apply(goal)
            self.step()
        self.halt()
        self.supervisor.release()
        self.supervisor.rest()

    def examine(self, seconds: float) -> list[Endpoint]:
        """Listen to the robot for a while, without moving it.

        Args:
            seconds: Time to listen.

        Returns:
            Streams of all drivers; ``obstacles`` returns the reasons against them.

        Raises:
            BackendError: The drivers cannot be opened.
        """
        return self._connection.examine(seconds)

    def _leave_last(self) -> None:
        """Bring the last episode to rest, and have a person release a held robot."""
        supervisor = self.supervisor
        if supervisor.state is State.RUNNING:
            self.halt()
        if supervisor.state is State.HELD:
            orderly = supervisor.cause == HALTED
            text = f"the robot is held: {supervisor.cause}"
            if not self._person.confirm(text, "release it", released=orderly):
                raise BackendError(f"{text}; a person has to release it")
            supervisor.release()
        supervisor.rest()

    def obstacles(self) -> list[str]:
        """Return every reason against ``ready``, one sentence each."""
        return self._connection.obstacles()

    def observe(self) -> Observation:
        """Return the newest observation."""
        assert self._observation is not None, "reset comes first"
        return self._observation

    def _sense(self) -> Observation:
        joints, sensors = self.supervisor.joints, self.supervisor.sensors
        images: dict[str, Image] = {}
        regions: dict[str, Mapping[str, Regions]] = {}
        exposed: float | None = None
        for camera, view in sensors.take_views().items():
            if isinstance(view, ImageSample) and view.image is not None:
                images[camera] = view.image
            elif isinstance(view, RegionsSample):
                regions[camera] = view.regions
            # The oldest of the images counts.
            exposed = min(view.stamp, exposed or view.stamp)
        efforts = joints.efforts.copy() if self._robot.joint_torques else None
        return Observation(
            time=joints.stamp - self._began,
            positions=joints.positions.copy(),
            velocities=joints.velocities.copy(),
            loads=self._loads(),
            images=images,
            regions=regions,
            efforts=efforts,
            exposed=None if exposed is None else exposed - self._began,
        )

    def _loads(self) -> Loads:
        """Return the wrenches of all load cells in the world's axes."""
        wrenches = np.zeros((len(self._cells), 6))
        if self._cells:
            self._kinematics.update(self.supervisor.joints.positions)
        for row, (hand, finger) in enumerate(self._cells):
            link = self._robot.load_cells[hand][finger].link
            turn = self._kinematics.frame(link).rotation
            wrench = np.array(self.supervisor.sensors.wrenches[hand, finger].wrench)
            wrenches[row, :3], wrenches[row, 3:] = turn @ wrench[:3], turn @ wrench[3:]
        return Loads(self._cells, wrenches)

    def apply(self, reference: Floats) -> None:
        """Send references within all limits, rad or m, shape (n,).

        Raises:
            BackendError: The robot is held.
        """
        if self.supervisor.state is State.READY or self.supervisor.is_late(self._clock.monotonic()):
            self._catch_up()
        # The stamp is taken first: a suspension of this process after the check for lateness
        # makes the stamp old, and the controller refuses the command.
        stamp = self._clock.wall()
        admitted = self.supervisor.admit(reference, self._clock.monotonic())
        if admitted is None:
            self._stop()
        else:
            self._send(admitted, stamp)

    def _catch_up(self) -> None:
        """Wait for a new state of a standing robot; discard those queued during a long tick.

        Raises:
            BackendError: None came within the deadline, or a fault holds the robot.
        """
        self._connection.drain()
        before, until = self.supervisor.joints.stamp, self._clock.monotonic() + self._deadline
        # Queued states are as old as the long tick. A new one shows that the robot still answers.
        while self.supervisor.joints.stamp <= before and self._clock.monotonic() < until:
            self._clock.sleep(_PAUSE)
            self._connection.gather()
        self._due = self._clock.monotonic()
        self.supervisor.resume(self._due)
        self.supervisor.check(self._due)
        if not self.supervisor.passes:
            self._stop()

    def _send(self, references: Floats, stamp: float) -> None:
        for name, (joints, columns) in self._commanded.items():
            reach = horizon(self._robot.drivers[name], 1.0 / self.control_period)
            command = Command(joints, tuple(references[columns].tolist()), reach, stamp)
            self._connection.send(name, command)

    def step(self) -> None:
        """Wait for the next control period, and for joint states that are newer.

        Raises:
            BackendError: The robot is held; the message has the cause.
        """
        clock, before = self._clock, self.supervisor.joints.stamp
        self._due += self.control_period
        clock.sleep(max(0.0, self._due - clock.monotonic()))
        while True:
            self._connection.gather()
            now = clock.monotonic()
            self.supervisor.check(now)
            if not self.supervisor.passes:
                self._stop()
            # A tick without a newer joint state would control the robot by old positions.
            if self.supervisor.joints.stamp > before:
                break
            clock.sleep(_PAUSE)
        self._way_back.note(self.supervisor.joints.positions)
        # A late step is not caught up.
        self._due = max(self._due, now - self.control_period)
        self._observation = self._sense()

    def _stop(self) -> None:
        """Bring a held robot to rest, and end the episode.

        Raises:
            BackendError: Always, with the cause.
        """
        self._settle()
        raise BackendError(
            f"the robot is held: {self.supervisor.cause}; a person has to release it"
        )

    def halt(self) -> None:
        """Hold a robot that may move: brake, and return to the measured positions."""
        if self.supervisor.passes:
            self.supervisor.hold(HALTED)
        self._settle()
        # After a fault, a watchdog holds, too.
        if self.supervisor.cause == HALTED:
            self._connection.rest()

    def _settle(self) -> None:
        """Send the references that bring a held robot to rest."""
        while True:
            # A robot with another time would brake when its clock reaches the stamp; 0 means now.
            differs = self.supervisor.joints.clock_differs
            stamp = 0.0 if differs else self._clock.wall()
            references = self.supervisor.settle(self._clock.monotonic())
            if references is None:
                return
            self._send(references, stamp)
            self._clock.sleep(self.control_period)

    def close(self) -> None:
        """Hold a robot that moves, and close the links."""
        if self.supervisor.state is State.RUNNING:
            self.halt()
        self._connection.close()
        if self._real_time is not None:
            self._real_time.end()
