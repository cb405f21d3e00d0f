"""Two arms on a mount, moved by the project's control law and kinematics alone."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.control import (
    Floats,
    Kinematics,
    Law,
    LawSettings,
    Level,
    localizability_potential,
    manipulability_potential,
)
from cbdsl.api.documents import RobotDocument
from cbdsl.api.sensing import heading, within_view
from cbdsl_reproduction.mounts.arm_mount import TODAY, ArmMount

SIDES = "left", "right"
#: The Jacobians that a manipulability of both arms may be of.
JACOBIANS = "position", "pose", "relative", "chain"
#: Radius of the object on the table, and distance of the palm's tip from its middle, m.
RADIUS, STANDOFF = 0.07, 0.09
TABLE = -0.42
EDGES = (0.30, 0.90), (-0.60, 0.60)
#: Tips within this distance touch the object that the other hand holds, m.
TOGETHER = 0.15

# Ticks are long: the arms' resting postures do not depend on them.
_PERIOD, _TICKS = 0.1, 60
_JOINT_STEP, _TIP_STEP = 0.1, 0.035
# The robot file's rest of MANIPULABILITY, d phi / dt = 2e-5 /s at a gain of 8 /s, for the
# logarithm of the measure, whose way is the same: at most the rate at a measure of 0.05.
_RATE, _STEEP, _LONGEST = 0.5, 0.03, 400
_ARRIVED, _TILTED = 0.01, math.radians(10)
_DOWN = np.array((0.0, 0.0, -1.0))
# Radii of the arms' links and of the hands, m.
_UPPER, _FORE, _HAND = 0.06, 0.05, 0.06
_NECK, _EYES = (0.24, 0.0, 0.50), (0.04, 0.06)


class Reach(NamedTuple):
    """Resting state of a reach.

    Attributes:
        posture: Posture of the arm, rad, shape (7,).
        error: Error of the tip's position, m.
        tilt: Angle of the palm from straight down, rad.
        clear: True if elbow and wrist are above the table.
    """

    posture: Floats
    error: float
    tilt: float
    clear: bool

    @property
    def arrived(self) -> bool:
        """True if a hand can take an object at the goal."""
        return self.error < _ARRIVED and self.tilt < _TILTED and self.clear


class HandMeeting(NamedTuple):
    """Final state of both arms after the ascent of manipulability.

    Attributes:
        apart: Distance of the palms' tips, m.
        aim: Distance of the object from the place where the other hand would close, m.
        place: Place of the object, m.
        clear: True if neither the object nor an elbow nor a wrist went into the table.
        free: Distance of one forearm's axis from the other's, m.
        seen: True if both cameras see the object past the arms.
        phi: Localizability of the object, m^2/rad^2; NaN if a camera does not see it.
    """

    apart: float
    aim: float
    place: tuple[float, ...]
    clear: bool
    free: float
    seen: bool
    phi: float

    @property
    def near(self) -> bool:
        """True if the other hand reaches the object that the first one holds."""
        return self.apart < TOGETHER

    @property
    def possible(self) -> bool:
        """Whether arms that are no mere lines could get there."""
        return self.clear and self.free > 2 * _FORE

    @property
    def together(self) -> bool:
        """Whether the hands are near each other, and could get there."""
        return self.near and self.possible


class MountedArms:
    """Both arms on a mount; ``posture`` is the posture of all joints of the robot, rad.

    Args:
        robot: Robot document of Dexter.
        mount: Mount of its arms.
    """

    def __init__(self, robot: RobotDocument, mount: ArmMount) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "mounted.urdf"
            file.write_text(mount.urdf(), encoding="utf-8")
            self.kinematics = Kinematics(robot, file)
        self.mount, joints = mount, self.kinematics.joints
        self.own = {side: joints.of(f"{side}_arm") for side in SIDES}
        self._both = np.concatenate([self.own[side] for side in SIDES])
        self._head, self._cameras = joints.of("head"), robot.cameras
        self.tips = {}
        for side in SIDES:
            tip = robot.effectors[f"{side}_arm"].tip
            assert tip is not None
            self.tips[side] = tip.link, tip.offset
        settings = LawSettings(_JOINT_STEP, limit_margin=robot.control.limit_margin)
        lower, upper = self.kinematics.lower, self.kinematics.upper
        self._laws = {
            len(own): Law(lower[own], upper[own], settings)
            for own in (self.own["right"], self._both)
        }
        self.limits = lower[self.own["right"]], upper[self.own["right"]]
        self.posture: Floats = np.zeros(len(joints))
        # Distance of the posture at rest from the mount's requested one, m and a tenth of rad.
        self.unfit = 0.0
        if mount is TODAY:
            postures = robot.effectors["right_arm"].postures
            self.rests, self.ready = (np.array(postures[name]) for name in ("home", "ready"))
        else:
            self.rests = self._find_rest()
            self.ready = self._find_ready()

    def rest(self) -> None:
        """Move both arms to rest."""
        for side in SIDES:
            self.posture[self.own[side]] = self._of(side, self.rests)

    def reach(self, place: Sequence[float], side: str = "right") -> Reach:
        """Take an object at a place of the table, from rest: posture ◁ orient ◁ approach."""
        self.rest()
        goal = np.array((*place, TABLE + RADIUS + STANDOFF))
        ready, own = self._of(side, self.ready), self.own[side]
        for _ in range(_TICKS):
            levels = [*self._palm_down(side, goal), _spring("posture", ready - self.posture[own])]
            if self._step(levels, own) < 1e-3:
                break
        return self._reached(side, goal)

    def bring_together(self, jacobian: str) -> HandMeeting:
        """Climb up the manipulability of both arms from where they are.

        Args:
            jacobian: Jacobian of the manipulability, one of ``JACOBIANS``.
        """
        clear = True
        for _ in range(_LONGEST):
            gradient = self.gradient(jacobian)
            steep = float(np.linalg.norm(gradient))
            if steep < _STEEP:
                break
            way = min(_RATE * steep, _JOINT_STEP)
            level = Level("manipulability", gradient[None] / steep, np.array([way]))
            moved = self._step([level], self._both)
            clear = clear and self._is_clear()
            if moved < 1e-4:
                break
        return self._meeting(clear)

    def sees(self, place: Floats, held: Iterable[str]) -> tuple[bool, float]:
        """Return True if both cameras see a place past the arms, and its localizability.

        Args:
            place: Position, m, shape (3,).
            held: Sides whose hands are there.
        """
        # The aim neglects that the cameras move as the head tilts; the place need not be in the
        # middle.
        level = math.hypot(place[0] - _NECK[0], place[1])
        pan, rise = math.atan2(place[1], place[0] - _NECK[0]), _NECK[2] + _EYES[1] - place[2]
        tilt = math.atan2(rise, max(level - _EYES[0], 1e-6))
        lower, upper = self.kinematics.lower[self._head], self.kinematics.upper[self._head]
        self.posture[self._head] = np.minimum(np.maximum((pan, tilt), lower), upper)
        self.kinematics.update(self.posture)
        cameras = self.kinematics.placed(tuple(each.link for each in self._cameras.values()))
        lines = [camera.rotation.T @ (place - camera.position) for camera in cameras]
        lenses = self._cameras.values()
        if not all(within_view(*each, 0.0) for each in zip(lenses, lines, strict=True)):
            return False, math.nan
        headings = [heading(line) for line in lines]
        phi = localizability_potential(cameras).evaluate(np.concatenate(headings), np.zeros(0), 4)[
            0
        ]
        bones = self._bones(frozenset(held))
        clear = all(_clears(camera.position, place, bone) for camera in cameras for bone in bones)
        return clear, phi

    def _of(self, side: str, right: Floats) -> Floats:
        """Return a posture of the right arm, or its mirror image."""
        return right if side == "right" else mirrored(right, self.limits)

    def _find_rest(self) -> Floats:
        """Return the fitting resting posture nearest to the middle of the joints' limits."""
        lower, upper = self.limits
        rng = np.random.default_rng(0)
        starts = rng.uniform(0.7 * lower + 0.3 * upper, 0.3 * lower + 0.7 * upper, (6, 7))
        settled = [self._settle(start, self.mount.rest) for start in starts]
        self.unfit = min(error for _, error in settled)

        def unfitness(rest: tuple[Floats, float]) -> float:
            posture, error = rest
            # Errors below 2 cm are equally good, so that the distance from the limits decides among
            # them.
            return max(error, 0.02) * (1 + self._off_middle(posture))

        return min(settled, key=unfitness)[0]

    def _find_ready(self) -> Floats:
        """Return the attracting posture of reaches: above the right half, elbow as at rest."""
        goal = np.array((0.5, -0.2, TABLE + RADIUS + STANDOFF))
        return self._settle(self.rests, goal)[0]

    def _settle(self, start: Floats, goal: Floats) -> tuple[Floats, float]:
        """Return a posture with the palm down at a goal and the mount's elbow, and its error."""
        own, middle = self.own["right"], np.mean(self.limits, axis=0)
        self.posture[own] = start
        for _ in range(_TICKS):
            levels = [*self._palm_down("right", goal), self._elbow(goal)]
            levels.append(_spring("middle", middle - self.posture[own]))
            if self._step(levels, own) < 2e-3:
                break
        reached = self._reached("right", goal)
        return reached.posture, reached.error + 0.1 * reached.tilt

    def _off_middle(self, posture: Floats) -> float:
        lower, upper = self.limits
        return float(np.mean(((2 * posture - lower - upper) / (upper - lower)) ** 4))

    def _elbow(self, goal: Floats) -> Level:
        """Return the level that turns the elbow about the line from shoulder to hand."""
        # With the hand at its goal, the elbow is free on a circle about the line from shoulder to
        # hand. ``below`` and ``outward`` are unit vectors in the plane of that circle.
        shoulder = self.mount.shoulder
        line = (goal - shoulder) / np.linalg.norm(goal - shoulder)
        below = _across(np.array((0.0, 0.0, -1.0)), line)
        outward = np.cross(line, below)
        # The right arm is at negative y, so that its outward direction has a negative y.
        if outward[1] > 0.0:
            outward = -outward
        wanted = math.cos(self.mount.elbow) * below + math.sin(self.mount.elbow) * outward
        elbow = self.kinematics.point("right_link_4", (0.0, 0.0, 0.0))
        here = elbow.position - shoulder
        radius = float(np.linalg.norm(here - line.dot(here) * line))
        here = _across(here, line)
        around = np.cross(line, here)
        turn = math.atan2(float(around @ wanted), float(here @ wanted))
        # A stretched arm has a circle of radius 0, for which the row would be infinite.
        row = around @ elbow.jacobian[:3, self.own["right"]] / max(radius, 0.05)
        return Level("elbow", row[None], _bounded(np.array([0.5 * turn]), 0.2))

    def _palm_down(self, side: str, goal: Floats) -> list[Level]:
        """Return the levels that keep the tip at a goal, and the palm down."""
        self.kinematics.update(self.posture)
        own = self.own[side]
        tip = self.kinematics.point(*self.tips[side])
        axes = self.kinematics.frame(self.tips[side][0]).rotation
        normal = axes[:, 2]
        turn = np.cross(normal, _DOWN)
        sine, cosine = float(np.linalg.norm(turn)), float(normal @ _DOWN)
        # For a palm straight up, all turns by half a circle are as short; the palm's own x axis is
        # taken.
        turn = axes[:, 0] * math.pi if sine < 1e-9 > cosine else turn
        turn *= math.atan2(sine, cosine) / sine if sine > 1e-9 else 1.0
        # Two rows keep the palm down and leave the turn about its normal free.
        across = axes[:, :2].T
        ahead = _bounded(0.4 * (goal - tip.position), _TIP_STEP)
        aside = _bounded(0.4 * across @ turn, 0.15)
        return [
            Level("approach", tip.jacobian[:3, own], ahead),
            Level("orient", across @ tip.jacobian[3:, own], aside),
        ]

    def _step(self, levels: Sequence[Level], own: NDArray[np.intp]) -> float:
        """Move some joints by the law; returns the largest displacement, rad."""
        moved = self._laws[len(own)].solve(levels, self.posture[own]).displacement
        self.posture[own] += moved
        return float(np.abs(moved).max())

    def _reached(self, side: str, goal: Floats) -> Reach:
        self.kinematics.update(self.posture)
        tip = self.kinematics.point(*self.tips[side])
        normal = self.kinematics.frame(self.tips[side][0]).rotation[:, 2]
        error = float(np.linalg.norm(goal - tip.position))
        tilt = math.acos(min(1.0, max(-1.0, float(normal @ _DOWN))))
        return Reach(self.posture[self.own[side]].copy(), error, tilt, self._is_clear())

    def _is_clear(self) -> bool:
        """Return True if elbows, wrists and the object in the right hand are above the table."""
        self.kinematics.update(self.posture)
        points = [(self._origin(f"{side}_link_{n}"), _FORE) for side in SIDES for n in (4, 6)]
        points.append((self._grasped("right"), RADIUS))
        return all(
            point[2] > TABLE + radius - 0.01
            for point, radius in points
            if all(low < point[k] < high for k, (low, high) in enumerate(EDGES))
        )

    def _origin(self, link: str) -> Floats:
        return self.kinematics.frame(link).position

    def _grasped(self, side: str) -> Floats:
        """Return the middle of the object in a hand, m, shape (3,)."""
        link, offset = self.tips[side]
        place: Floats = self.kinematics.point(
            link, (offset[0], offset[1], offset[2] + STANDOFF)
        ).position
        return place

    def _bones(self, holding: frozenset[str]) -> list[tuple[Floats, Floats, float]]:
        """Return upper arms and forearms, and the hands that do not hold the observed object."""
        bones = []
        for side in SIDES:
            shoulder, elbow, wrist, palm = (
                self._origin(f"{side}_{link}") for link in ("link_1", "link_4", "link_6", "palm")
            )
            bones += [(shoulder, elbow, _UPPER), (elbow, wrist, _FORE)]
            if side not in holding:
                bones.append((wrist, palm, _HAND))
        return bones

    def _meeting(self, clear: bool) -> HandMeeting:
        self.kinematics.update(self.posture)
        left, right = (self.kinematics.point(*self.tips[side]).position for side in SIDES)
        thing, other = self._grasped("right"), self._grasped("left")
        fore = [bone[:2] for bone in self._bones(frozenset(SIDES)) if bone[2] == _FORE]
        # The distance of sampled points bounds that of the forearms' axes from above.
        free = min(
            float(np.linalg.norm(one - other_one))
            for one in np.linspace(*fore[0], 12)
            for other_one in np.linspace(*fore[1], 12)
        )
        apart, aim = (float(np.linalg.norm(way)) for way in (left - right, thing - other))
        return HandMeeting(apart, aim, tuple(thing.tolist()), clear, free, *self.sees(thing, SIDES))

    def gradient(self, jacobian: str) -> Floats:
        """Return the gradient of the measure's logarithm by both arms' joints, shape (14,)."""
        self.kinematics.update(self.posture)
        # Jacobians, with the tips' velocities v and angular velocities w:
        #     position, pose   one for each arm; the logarithms of both measures add up
        #     relative         v_right - v_left, shape (3, 14)
        #     chain            v_right - v_left - w_left x (p_right - p_left)
        # The last one is that of a serial chain that begins at the left hand and ends at the right.
        rows = 6 if jacobian == "pose" else 3
        own = [self.own[side] for side in SIDES]
        points = [self.kinematics.point(*self.tips[side]) for side in SIDES]
        links = [self.tips[side][0] for side in SIDES]
        full = 6 if jacobian == "chain" else rows
        bends = [
            self.kinematics.curvature(link, point.position, full)[:, columns][:, :, columns]
            for link, point, columns in zip(links, points, own, strict=True)
        ]
        tips = [point.jacobian[:, columns] for point, columns in zip(points, own, strict=True)]
        if jacobian in ("position", "pose"):
            parts = [_slope(tip[:rows], bend[:rows]) for tip, bend in zip(tips, bends, strict=True)]
            return np.concatenate(parts)
        joined = np.concatenate((-tips[0][:3], tips[1][:3]), axis=1)
        bend = np.zeros((3, 14, 14))
        bend[:, :7, :7], bend[:, 7:, 7:] = -bends[0][:3], bends[1][:3]
        if jacobian == "chain":
            way = points[1].position - points[0].position
            joined[:, :7] -= np.cross(tips[0][3:].T, way).T
            change = np.concatenate((-tips[0][:3], tips[1][:3]), axis=1)
            bend[:, :7, :7] -= np.cross(bends[0][3:], way[:, None, None], axis=0)
            bend[:, :7, :] -= np.cross(
                np.repeat(tips[0][3:, :, None], 14, axis=2), change[:, None, :], axis=0
            )
        return _slope(joined, bend)


def mirrored(right: Floats, limits: tuple[Floats, Floats]) -> Floats:
    """Return the left arm's posture for one of the right arm, rad, within the limits."""
    left = right * np.array((-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0))
    # The hands are alike, not mirror images: half a turn puts the thumb where it belongs.
    left[6] += math.pi
    for joint in (4, 6):
        # A whole turn leaves the pose of the hand unchanged.
        if left[joint] > limits[1][joint]:
            left[joint] -= 2 * math.pi
    within: Floats = np.clip(left, *limits)
    return within


def _slope(jacobian: Floats, bend: Floats) -> Floats:
    """Return the gradient of log sqrt(det(J J^T)): J (k, n), its change per joint (k, n, n)."""
    rows, joints = jacobian.shape
    phi, _, slope = manipulability_potential(rows, joints).evaluate(
        np.ascontiguousarray(jacobian).ravel(), np.zeros(0), rows * joints
    )
    # The potential is the negative measure, whose sign cancels: d ln w / dq = (dw / dq) / w.
    gradient: Floats = np.einsum("ki,kij->j", slope[0].reshape(rows, joints), bend) / phi
    return gradient


def _spring(name: str, error: Floats) -> Level:
    """Return a posture's spring, at 2 /s."""
    return Level(name, np.eye(len(error)), _bounded(_PERIOD * error, 0.08))


def _bounded(step: Floats, size: float) -> Floats:
    length = float(np.linalg.norm(step))
    return step if length <= size else step * (size / length)


def _across(vector: Floats, line: Floats) -> Floats:
    """Return the direction of the part of a vector at right angles to a line."""
    rest = vector - (vector @ line) * line
    return rest / max(float(np.linalg.norm(rest)), 1e-9)


def _clears(eye: Floats, place: Floats, bone: tuple[Floats, Floats, float]) -> bool:
    """Return True if a line of sight passes a link, given by its ends and its radius."""
    start, end, radius = bone
    along = end - start
    sight = eye + np.linspace(0.0, 1.0, 40)[:, None] * (place - eye)
    # For each point of the line of sight, this is the parameter of the nearest point of the link's
    # axis.
    part = np.clip((sight - start) @ along / max(float(along @ along), 1e-9), 0.0, 1.0)
    off = np.linalg.norm(sight - start - part[:, None] * along, axis=1)
    return bool(off.min() > radius)
