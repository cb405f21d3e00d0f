"""The chain of casts that is printed, and the row of the plan that is compiled from it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.kinematics.rotation import log
from cbdsl.numeric.arrays import Floats
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import AlongNormals, Controller
from cbdsl.reporting.text.program_text import casts_text
from cbdsl.robot.resources import resources
from cbdsl.runtime.controllers.controller_rows import bind_rows
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.chain import CastError
from cbdsl.sensing.vision.regions.camera import heading
from cbdsl.sensing.vision.vision import SeenHeading
from cbdsl.types.casts import CASTS
from cbdsl.types.resource import (
    FingerForces,
    FingerLoad,
    Heading,
    MarkHeading,
    NetLoad,
    NovelHeading,
    Opening,
)
from cbdsl.types.source_record import Normals, chains_of, compares, normals_of, owner_of
from tests.conftest import ROOT, Checked
from tests.sensing.vision.signals.test_visual_signals import between, facing, feel

STEP = 1e-6
CHOSEN = NovelHeading, MarkHeading
PROGRAMS = [
    path.stem
    for path in sorted((ROOT / "programs").glob("*.yaml"))
    if "robot: dexter" in path.read_text("utf-8")
]
_HELD = "rigid hold", "inverse manipulator Jacobian"


class Oracle:
    """Dexter with something seen between its hands; each cast is computed a second time here."""

    def __init__(self, robot: RobotDocument, kinematics: Kinematics) -> None:
        self.robot, self.kinematics = robot, kinematics
        self.signals = Signals(robot, kinematics, resources(robot).values())
        self.positions = facing(robot, self.signals)
        feel(robot, self.signals, self.positions, 0.0)
        feel(robot, self.signals, self.positions, 5.0)
        self.point = between(robot, self.signals)
        self.eyes = {name: kinematics.frame(eye.link) for name, eye in robot.cameras.items()}
        for channel, memory in self.signals.vision.memories.items():
            memory.position, memory.radius = self.point, 0.1
            for name in robot.cameras:
                seen = SeenHeading(self._sighted(name, self.point), 1)
                self.signals.vision.headings[name, channel, 0] = seen
        self.casts: dict[tuple[str, ...], Callable[[Controller], Floats]] = {
            (): self._joints,
            ("inverse manipulator Jacobian",): self._moved,
            ("compliance",): self._pressed,
            ("inverse camera Jacobian",): self._turned,
            _HELD: self._borne,
            ("inverse sighting Jacobian", *_HELD): self._carried,
            ("stereo triangulation", *_HELD): self._carried,
        }

    def _sighted(self, camera: str, point: Floats) -> Floats:
        frame = self.kinematics.frame(self.robot.cameras[camera].link)
        return heading(frame.rotation.T @ (point - frame.position))

    def _joints(self, controller: Controller) -> Floats:
        return np.eye(len(self.positions))[self.signals.joints.pick(controller.joints)]

    def _moved(self, controller: Controller) -> Floats:
        """Return the Jacobian of a tip by finite differences; rotations in world axes."""

        def value() -> Floats:
            reading = self.signals.read(controller.feedback)
            assert reading is not None
            return reading.value

        slopes = self._differences(value)
        if isinstance(controller.feedback.source, Opening):
            # The joints that flex fingers have equal parts, and all others none.
            flexing = self.signals.touch.flexing[controller.feedback.source.hand]
            whole = slopes[:, flexing].sum()
            slopes[:] = 0.0
            slopes[:, flexing] = whole / len(flexing)
        if controller.feedback.type.name != "orientation":
            return slopes
        spins = [slope.reshape(3, 3) @ value().T for slope in slopes.T]
        return np.array([(spin[2, 1], spin[0, 2], spin[1, 0]) for spin in spins]).T

    def _pressed(self, controller: Controller) -> Floats:
        source, control = controller.feedback.source, self.robot.control
        if isinstance(source, FingerForces):
            touch = self.signals.touch
            rows = np.eye(len(self.positions))[touch.flexing[source.hand]]
            slides = self.kinematics.slides[touch.flexing[source.hand]]
            stiffness = np.where(slides, control.slide_stiffness, control.stiffness)[:, None]
            return stiffness * touch.closing[source.hand] * rows
        if isinstance(source, FingerLoad) and source.part == "force":
            link = self.robot.load_cells[source.hand][source.finger].link
            moved = self._differences(lambda: self.kinematics.frame(link).position)
            return control.contact_stiffness * moved
        if isinstance(source, NetLoad) and source.part == "torque":
            return self._turned_against(source.hand)
        if isinstance(source, NetLoad) and not isinstance(controller.reference, AlongNormals):
            return control.contact_stiffness * self._differences(lambda: self._tips(source.hand))
        assert normals_of(controller.feedback) is Normals.PALMS
        rows = []
        for hand in self.robot.members(owner_of(source)):
            normal = self.signals.tips.normal(self.signals.touch.carriers[hand]).copy()
            rows.append(normal @ self._differences(lambda hand=hand: self._tips(hand)))
        return control.contact_stiffness * np.array(rows)

    def _turned_against(self, hand: str) -> Floats:
        """Return the growth of the torque about a hand's tip with every fingertip on a spring."""
        control, rows = self.robot.control, np.zeros((3, len(self.positions)))
        tip = self.robot.effectors[self.signals.touch.carriers[hand]].tip
        assert tip is not None
        palm = self.kinematics.frame(tip.link)
        centre = palm.position + palm.rotation @ np.array(tip.offset)
        for cell in self.robot.load_cells[hand].values():
            link = self.kinematics.frame(cell.link)

            def moment(link: Frame = link, name: str = cell.link) -> Floats:
                now = self.kinematics.frame(name)
                force = control.contact_stiffness * (now.position - link.position)
                turn = log(now.rotation @ link.rotation.T)
                return np.cross(link.position - centre, force) + control.contact_torsion * turn

            rows += self._differences(moment)
        return rows

    def _tips(self, hand: str) -> Floats:
        """Return the sum of the positions of a hand's fingertips."""
        links = [cell.link for cell in self.robot.load_cells[hand].values()]
        return np.sum([self.kinematics.frame(link).position for link in links], axis=0)

    def _turned(self, controller: Controller) -> Floats:
        """Return the change of headings to a distant point as the cameras turn."""
        return self._differences(lambda: self._over_cameras(controller, self._ahead))

    def _ahead(self, camera: str) -> Floats:
        frame = self.kinematics.frame(self.robot.cameras[camera].link)
        return heading(frame.rotation.T @ (self.point - self.eyes[camera].position))

    def _carried(self, controller: Controller) -> Floats:
        """Return the change, in fixed cameras, of headings to an object that both hands carry."""

        def seen(camera: str) -> Floats:
            eye = self.eyes[camera]
            return heading(eye.rotation.T @ (between(self.robot, self.signals) - eye.position))

        return self._differences(lambda: self._over_cameras(controller, seen))

    def _borne(self, controller: Controller) -> Floats:
        """Return the motion of an object that both hands carry, seen from any place."""
        return self._differences(lambda: between(self.robot, self.signals))

    def _over_cameras(self, controller: Controller, seen: Callable[[str], Floats]) -> Floats:
        headings = [seen(camera) for camera in self.robot.cameras]
        one = isinstance(controller.feedback.source, Heading)
        return np.mean(headings, axis=0) if one else np.concatenate(headings)

    def _differences(self, function: Callable[[], Floats]) -> Floats:
        """Return the Jacobian of a function of the posture, shape (m, n)."""
        columns = []
        for joint in range(len(self.positions)):
            ends = []
            for sign in (1.0, -1.0):
                moved = self.positions.copy()
                moved[joint] += sign * STEP
                self.kinematics.update(moved)
                ends.append(function().ravel().copy())
            columns.append((ends[0] - ends[1]) / (2 * STEP))
        self.kinematics.update(self.positions)
        return np.array(columns).T


@pytest.fixture
def oracle(dexter: RobotDocument, kinematics: Kinematics) -> Oracle:
    return Oracle(dexter, kinematics)


def printed_chains(controller: Controller) -> list[tuple[str, ...]]:
    """Return the names of casts in the printed text."""
    known = {cast.name for cast in CASTS} | {"rigid hold", "inverse sighting Jacobian"}
    chains = casts_text(controller).split(", and ")
    words = [[re.sub(r" \(.*\)$", "", word) for word in chain.split(" → ")] for chain in chains]
    return [tuple(word for word in chain if word in known) for chain in words]


def compared(program: CheckedProgram) -> list[Controller]:
    """Return controllers whose row is their feedback: a manipulability's is that of a Jacobian.

    The relation of two objects has no standoff, and nothing here is novel or has a mark:
    see the tests of their signals.
    """
    lists = (primitive.controllers for primitive in program.primitives.values())
    controllers = [each for controllers in lists for each in controllers]
    return [
        replace(c, standoff=None)
        for c in controllers
        if c.manipulator is None
        and not (compares(c.feedback.source) or isinstance(c.feedback.source, CHOSEN))
    ]


@pytest.mark.parametrize("name", PROGRAMS)
def test_row_of_a_controller_is_the_chain_that_is_printed(
    checked: Checked, oracle: Oracle, name: str
) -> None:
    for controller in compared(checked(name)):
        row = bind_rows(controller, oracle.signals).feedback
        reading = oracle.signals.reading(row)
        assert reading is not None and reading.jacobian is not None
        own = oracle.signals.joints.pick(controller.joints)
        printed = sum(oracle.casts[chain](controller) for chain in printed_chains(controller))
        wanted = np.asarray(printed)[:, own]
        scale = np.abs(wanted).max()
        assert scale > 0.0
        assert reading.jacobian[:, own] == pytest.approx(wanted, abs=1e-6 * scale + 1e-9), (
            controller.name
        )


def test_another_chain_gives_another_row(checked: Checked, oracle: Oracle) -> None:
    """Turn a head to a visible object by the chain through the cameras, not through hands."""
    track = checked("searchtrack").primitives["track"].lead
    own = oracle.signals.joints.pick(track.joints)
    by_camera, by_hold = chains_of(track.feedback)
    assert track.chains == (by_camera,)
    for chains, moves in (((by_camera,), True), ((by_hold,), False), ((by_camera, by_hold), True)):
        other = replace(track, chains=chains)
        reading = oracle.signals.reading(bind_rows(other, oracle.signals).feedback)
        assert reading is not None and reading.jacobian is not None
        assert bool(reading.jacobian[:, own].any()) == moves


def test_no_controller_runs_by_a_chain_that_nothing_executes(
    checked: Checked, oracle: Oracle
) -> None:
    approach = checked("reachtouch").primitives["reach"].lead
    touch = checked("reachtouch").primitives["touch"].lead
    for controller, other in ((approach, touch), (touch, approach)):
        wrong = replace(controller, chains=other.chains)
        with pytest.raises(CastError, match="no row of"):
            ControllerRun(wrong, oracle.signals, ControllerPlan(), 1 / 60)
