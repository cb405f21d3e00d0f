"""Checks of robot documents, alone and against their URDF models."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.drivers import check_drivers
from cbdsl.checking.robot.model_agreement import (
    check_bodies,
    check_mimics,
    check_weights,
    note_rests,
)
from cbdsl.checking.robot.model_check import ModelCheck
from cbdsl.checking.robot.robot_constants import check_constants, check_margins
from cbdsl.checking.robot.settings import check_settings
from cbdsl.checking.start_clearance import unkept_clearance
from cbdsl.diagnostics.counting import count, some
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.robot import Effector, RobotDocument
from cbdsl.robot.channel_names import bin_names, channel_names
from cbdsl.robot.resources import CAMERAS, STEREO, resources
from cbdsl.robot.source_kind import SOURCES
from cbdsl.robot.unsupported_joint import unsupported
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.storage.contents import is_file
from cbdsl.types.resource import CYCLOPEAN
from cbdsl.types.resource_type import TYPES
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

if TYPE_CHECKING:
    from cbdsl.robot.meshes.model_meshes import FaultyMesh


Steps = tuple[Step, ...]


def examine_robot(loaded: Loaded[RobotDocument], diagnostics: Diagnostics) -> CheckedRobot:
    """Check a robot's document, and return a robot for checking programs even if it has errors."""
    robot = loaded.document
    try:
        model: UrdfModel | None = read_urdf(loaded.path.parent / robot.model)
    except UrdfError as error:
        model = None
        if not isinstance(robot.model, Unknown):
            folder = loaded.path.parent
            names = [] if is_file(folder / robot.model) else _models_near(folder)
            place = loaded.source.place("model")
            diagnostics.add("CB301", place, names=names, given=robot.model, problem=str(error))
    _RobotCheck(loaded, diagnostics, _unclaimed(robot, model), _unmovable(model)).all()
    check_names(loaded, diagnostics)
    check_constants(loaded, diagnostics)
    check_speeds(loaded, diagnostics)
    check_drivers(loaded, model, diagnostics)
    missed = frozenset(
        diagnostic.given for diagnostic in diagnostics.sorted() if diagnostic.code == "CB308"
    )
    missed |= frozenset(_lacking(robot, missed))
    body = CheckedRobot(loaded, resources(robot, model), model, missed).with_idle_tips()
    if model is not None:
        ModelCheck(body, diagnostics, model).all()
        check_margins(loaded, model, diagnostics)
        check_meshes(loaded, model, diagnostics)
        check_bodies(loaded, model, diagnostics)
        if not diagnostics.failed:
            check_mimics(loaded, model, diagnostics)
            check_weights(loaded, model, diagnostics)
            if problem := unkept_clearance(loaded.document, model, 0.0):
                place = loaded.source.place("clearance", "distance")
                diagnostics.add("CB587", place, problem=problem)
            note_assumptions(loaded, model, diagnostics)
            note_rests(loaded, model, diagnostics)
    return body


def _lacking(robot: RobotDocument, missed: Collection[str]) -> Iterator[str]:
    """Yield the names of groups that lack effectors, and of aliases that lack channels."""
    for name, group in robot.groups.items():
        if any(member in missed for member in group.members):
            yield name
    for alias, channel in robot.vision.channels.aliases.items():
        if channel in missed:
            yield alias


def _models_near(folder: Path) -> list[str]:
    """Return URDF files in, beside and one level below a folder, as paths relative to it."""
    patterns = ("*.urdf", "*/*.urdf", "../*.urdf", "../*/*.urdf")
    models = {os.path.relpath(file, folder) for each in patterns for file in folder.glob(each)}
    return sorted(Path(file).as_posix() for file in models)


def _unclaimed(robot: RobotDocument, model: UrdfModel | None) -> frozenset[str]:
    """Return candidates for a misspelled effector joint: movable joints that no effector uses."""
    named = {joint for effector in robot.effectors.values() for joint in effector.joints}
    if model is None or named.issubset(model.movable):
        return frozenset()
    return frozenset(model.movable) - named


def _unmovable(model: UrdfModel | None) -> frozenset[str]:
    """Return the joints of unsupported types, which are reported when an effector has them."""
    joints = {} if model is None else model.joints
    return frozenset(name for name, joint in joints.items() if unsupported(joint) is not None)


class _RobotCheck:
    """Checks of a robot's document that need no model.

    Args:
        loaded: Robot.
        diagnostics: Diagnostics so far.
        unclaimed: Names of joints that are not reported as missing.
        unmovable: Names of joints that effectors cannot have.
    """

    def __init__(
        self,
        loaded: Loaded[RobotDocument],
        diagnostics: Diagnostics,
        unclaimed: frozenset[str],
        unmovable: frozenset[str],
    ) -> None:
        self._unclaimed = unclaimed
        self._unmovable = unmovable
        self._robot = loaded.document
        self._source = loaded.source
        self._effectors = loaded.source.declared(self._robot.effectors, "effectors")
        self._diagnostics = diagnostics

    def all(self) -> None:
        for name, effector in self._robot.effectors.items():
            self._effector(name, effector)
        self._groups()
        self._roles()
        self._masters()
        self._couplings()
        self._load_cells()
        self._sensors()
        self._aliases()
        self._stereo()
        self._tasks()

    def _effector(self, name: str, effector: Effector) -> None:
        steps: Steps = ("effectors", name)
        # A fixed joint of an effector is reported by itself. A posture that already leaves it out
        # is not a second fault.
        movable = [joint for joint in effector.joints if joint not in self._unmovable]
        for posture, angles in effector.postures.items():
            if len(angles) not in (len(effector.joints), len(movable)):
                place = self._source.place(*steps, "postures", posture)
                counts = {
                    "found": count(len(angles), "angle"),
                    "wanted": count(len(effector.joints), "joint"),
                }
                self._diagnostics.add("CB304", place, name=posture, **counts)
        if effector.start is not None and effector.start not in effector.postures:
            place = self._source.place(*steps, "start")
            postures = list(effector.postures)
            self._diagnostics.add(
                "CB306", place, names=postures, name=effector.start, effector=name
            )

    def _roles(self) -> None:
        for role, name in self._robot.roles.items():
            if name not in self._robot.groups:
                self._known(name, self._effectors, ("roles", role), "effector")

    def _groups(self) -> None:
        for name, group in self._robot.groups.items():
            if name in self._robot.effectors:
                self._diagnostics.add("CB311", self._source.key("groups", name), name=name)
            for i, member in enumerate(group.members):
                steps: Steps = ("groups", name, "members", i)
                self._known(member, self._effectors, steps, "effector")
                if member in group.members[:i]:
                    self._diagnostics.add(
                        "CB312", self._source.place(*steps), name=member, group=name
                    )

    def _masters(self) -> None:
        masters: dict[str, str] = {}
        for name, effector in self._robot.effectors.items():
            for i, joint in enumerate(effector.joints):
                if joint in masters:
                    place = self._source.place("effectors", name, "joints", i)
                    self._diagnostics.add("CB307", place, name=joint, other=masters[joint])
                if joint not in self._unmovable:
                    masters.setdefault(joint, f"effector '{name}'")
        for joint in self._robot.couplings:
            if joint in masters:
                place = self._source.key("couplings", joint)
                self._diagnostics.add("CB307", place, name=joint, other=masters[joint])

    def _couplings(self) -> None:
        effectors = self._source.known(self._robot.effectors, "effectors")
        if isinstance(effectors, Unknown):
            return
        actuated = [joint for effector in effectors.values() for joint in effector.joints]
        for joint, coupling in self._robot.couplings.items():
            steps: Steps = ("couplings", joint, "follows")
            if coupling.follows not in self._unclaimed:
                self._known(coupling.follows, actuated, steps, "actuated joint")

    def _load_cells(self) -> None:
        for hand, cells in self._robot.load_cells.items():
            if hand not in self._effectors:
                place, names = self._source.key("load_cells", hand), list(self._effectors)
                self._diagnostics.add("CB308", place, names=names, name=hand, what="effector")
            effector = self._effectors.get(hand, UNKNOWN)
            if isinstance(effector, Unknown):
                continue
            for finger, cell in cells.items():
                steps = ("load_cells", hand, finger, "joint")
                if cell.joint not in self._unclaimed:
                    self._known(cell.joint, effector.joints, steps, f"joint of '{hand}'")

    def _sensors(self) -> None:
        for name, sensor in self._robot.sensors.items():
            if sensor.kind not in SOURCES:
                place = self._source.place("sensors", name, "kind")
                self._diagnostics.add("CB320", place, names=list(SOURCES.names()), name=sensor.kind)
            if sensor.hand is not None and sensor.hand not in self._robot.load_cells:
                place, names = self._source.place("sensors", name, "hand"), self._robot.load_cells
                what = "effector with load cells"
                self._diagnostics.add(
                    "CB308", place, names=list(names), name=sensor.hand, what=what
                )

    def _aliases(self) -> None:
        channels = self._source.known(self._robot.vision.channels, "vision", "channels")
        if isinstance(channels, Unknown):
            return
        names = list(channel_names(channels))
        for alias, channel in channels.aliases.items():
            steps = ("vision", "channels", "aliases", alias)
            self._known(channel, names, steps, "channel")

    def _stereo(self) -> None:
        vision = self._source.known(self._robot.vision, "vision")
        cameras = self._source.known(self._robot.cameras, "cameras")
        if isinstance(vision, Unknown) or isinstance(cameras, Unknown) or vision.stereo is None:
            return
        first, second = vision.stereo
        self._known(first, cameras, ("vision", "stereo", 0), "camera")
        others = [name for name in cameras if name != first]
        self._known(second, others, ("vision", "stereo", 1), "second camera")

    def _tasks(self) -> None:
        for name in self._robot.control.tasks:
            steps = ("control", "tasks", name)
            if name not in TYPES:
                self._diagnostics.add(
                    "CB309", self._source.key(*steps), names=list(TYPES), name=name
                )
            else:
                check_settings(TYPES[name], self._source, steps, self._diagnostics)

    def _known(self, name: str, names: Collection[str], steps: Steps, what: str) -> None:
        if name not in names:
            place = self._source.place(*steps)
            self._diagnostics.add("CB308", place, names=list(names), name=name, what=what)


def check_meshes(loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics) -> None:
    """Warn of missing mesh files, and report damaged ones.

    An engine that reads no mesh can run a model without them. A damaged mesh is an error for all
    engines, because each would treat it differently.
    """
    if not model.meshes:
        return
    # Most robots of a check have no meshes.
    from cbdsl.robot.meshes.model_meshes import damaged_meshes, missing_meshes

    for code, faults in (("CB741", missing_meshes(model)), ("CB366", damaged_meshes(model))):
        if faults:
            diagnostics.add(code, loaded.source.place("model"), **_details(faults))


def _details(faults: list[FaultyMesh]) -> dict[str, str]:
    more = f", and {len(faults) - 1} more" if len(faults) > 1 else ""
    file, link, damage = faults[0]
    return {"file": file, "link": link, "problem": damage, "more": more}


# Eight turns a second, and 180 km/h: no arm comes near either.
_FASTEST = {"rad": 50.0, "m": 50.0}


def check_speeds(loaded: Loaded[RobotDocument], diagnostics: Diagnostics) -> None:
    """Warn of implausibly high speeds, such as degrees that were read as radians."""
    control = loaded.document.control
    speeds: list[tuple[tuple[Step, ...], float, str]] = [
        (("control", "joint_speed"), control.joint_speed, "rad")
    ]
    for name, settings in control.tasks.items():
        if settings.speed is not None and name in TYPES:
            unit = TYPES[name].unit.partition(" or ")[0]
            speeds.append((("control", "tasks", name, "speed"), settings.speed, unit))
    for steps, speed, unit in speeds:
        if speed > _FASTEST.get(unit, math.inf):
            details = {"speed": f"{speed:g} {unit}/s", "most": f"{_FASTEST[unit]:g} {unit}/s"}
            diagnostics.add("CB740", loaded.source.place(*steps), **details)


def note_assumptions(
    loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics
) -> None:
    """Note links without collision geometry, and drives whose effort is taken to be unlimited."""
    robot, place = loaded.document, loaded.source.place("model")
    # A link that only houses a camera needs no geometry for contacts.
    housings = {camera.link for camera in robot.cameras.values()}
    shapeless = [link for link in model.shapeless if link not in housings]
    if shapeless:
        diagnostics.add("CB742", place, model=model.path.name, links=some(shapeless))
    driven = [joint for effector in robot.effectors.values() for joint in effector.joints]
    zero = [name for name in driven if name in model.joints and _is_unbounded(model, robot, name)]
    if zero:
        diagnostics.add("CB743", place, model=model.path.name, joints=some(zero))


def _is_unbounded(model: UrdfModel, robot: RobotDocument, joint: str) -> bool:
    """Return whether the model states an effort of 0 for a joint and the document sets no bound."""
    return model.joints[joint].zero_effort and joint not in robot.simulation.efforts


_SIGHT = {CAMERAS: "all cameras", CYCLOPEAN: "the mean of all cameras", STEREO: "both cameras"}
_TIP = ("position", "orientation", "pose")


def check_names(loaded: Loaded[RobotDocument], diagnostics: Diagnostics) -> None:
    """Report names that already have another meaning in programs."""
    robot, source = loaded.document, loaded.source
    for steps, meaning in _taken(robot):
        diagnostics.add("CB314", source.key(*steps), name=steps[-1], meaning=meaning)
    channels = robot.vision.channels
    bins = {*bin_names(channels)}
    for key, names, taken in (
        ("colors", channels.colors, bins),
        ("aliases", channels.aliases, bins | {*channels.colors}),
    ):
        for name in names:
            if name in taken:
                diagnostics.add("CB315", source.key("vision", "channels", key, name), name=name)


def _taken(robot: RobotDocument) -> Iterator[tuple[Steps, str]]:
    """Yield the paths of keys with names that are taken, and the meaning of each name."""
    cameras = {name: f"camera '{name}'" for name in robot.cameras}
    sight = {**cameras, **_SIGHT} if robot.cameras else {}
    yield from ((("cameras", name), _SIGHT[name]) for name in robot.cameras if name in _SIGHT)
    for section in ("effectors", "groups"):
        names = getattr(robot, section)
        yield from (((section, name), sight[name]) for name in names if name in sight)
    for name, effector in robot.effectors.items():
        parts = {"uniform": "a draw between the joint limits"}
        if effector.tip is not None:
            parts |= {part: f"the {part} of its tip" for part in _TIP}
        if name in robot.load_cells:
            parts |= {"finger_forces": "the forces of its fingers"}
        for posture in effector.postures:
            if posture in parts:
                yield ("effectors", name, "postures", posture), parts[posture]
    for hand, cells in robot.load_cells.items():
        if "net" in cells:
            yield ("load_cells", hand, "net"), "the sum over the fingers"
