"""Checks of robot documents, alone and against their URDF models."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.drivers import check_drivers
from cbdsl.checking.robot.implausible_settings import check_speeds, note_assumptions
from cbdsl.checking.robot.limits import is_of_another_kind, limit_details
from cbdsl.checking.robot.meshes import check_meshes
from cbdsl.checking.robot.model_agreement import (
    check_bodies,
    check_mimics,
    check_weights,
    note_rests,
)
from cbdsl.checking.robot.robot_constants import check_constants, check_margins
from cbdsl.checking.robot.settings import check_settings
from cbdsl.checking.robot.taken_names import check_names
from cbdsl.checking.start_clearance import unkept_clearance
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.robot import Effector, RobotDocument
from cbdsl.robot.chains import root
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.resources import resources
from cbdsl.robot.source_kind import SOURCES
from cbdsl.robot.unsupported_joint import UnsupportedJoint, unsupported
from cbdsl.robot.urdf import UrdfError, UrdfJoint, UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.storage.contents import is_file
from cbdsl.types.resource_type import TYPES
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

Steps = tuple[Step, ...]


def examine_robot(loaded: Loaded[RobotDocument], diagnostics: Diagnostics) -> CheckedRobot:
    """Check a robot's document, and return a robot for checking programs even if it has errors."""
    robot = loaded.document
    try:
        model: UrdfModel | None = read_urdf(loaded.path.parent / robot.model)
    except UrdfError as error:
        model = None
        if robot.model is not UNKNOWN:
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
        _ModelCheck(body, diagnostics, model).all()
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


class _ModelCheck:
    """Checks of a robot's document against its model."""

    def __init__(self, body: CheckedRobot, diagnostics: Diagnostics, model: UrdfModel) -> None:
        self._body = body
        self._robot = body.document
        self._source = body.loaded.source
        self._diagnostics = diagnostics
        self._model = model
        named = {joint for effector in self._robot.effectors.values() for joint in effector.joints}
        self._free = [joint for joint in model.movable if joint not in named]
        #: Joint that moves a link, by the link's name, if no joint has the same name.
        self._movers = {
            joint.child: joint.name
            for joint in model.joints.values()
            if joint.child not in model.joints
        }

    def all(self) -> None:
        for name, effector in self._robot.effectors.items():
            self._effector(name, effector)
        self._turning(("couplings",), self._robot.couplings, self._free)
        self._named_links()
        efforts: Steps = ("simulation", "efforts")
        self._turning(efforts, self._robot.simulation.efforts, self._model.movable)
        self._base()
        self._axes()

    def _axes(self) -> None:
        """Check that the axis of each joint of the model has a direction."""
        for joint in self._model.joints.values():
            if not joint.directed:
                model = self._model.path.name
                self._diagnostics.add(
                    "CB361", self._source.place("model"), joint=joint.name, model=model
                )

    def _effector(self, name: str, effector: Effector) -> None:
        steps: Steps = ("effectors", name, "joints")
        places = {joint: self._source.place(*steps, i) for i, joint in enumerate(effector.joints)}
        movable = [name for name in self._free if unsupported(self._model.joints[name]) is None]
        self._joints(places, unsupported, movable)
        self._postures(name, effector)
        self._resolution(name, effector)
        if effector.tip is not None and name in self._body.idle:
            self._idle_tip(name, effector.tip.link)

    def _turning(self, steps: Steps, joints: Iterable[str], names: Sequence[str]) -> None:
        """Check that passive joints, and joints with a torque, can move."""
        places = {joint: self._source.key(*steps, joint) for joint in joints}
        self._joints(places, lambda joint: None if joint.movable else unsupported(joint), names)

    def _joints(
        self,
        places: Mapping[str, Place],
        obstacle: Callable[[UrdfJoint], UnsupportedJoint | None],
        names: Sequence[str],
    ) -> None:
        """Report missing and immovable joints, with one diagnostic for each obstacle."""
        hindered: dict[UnsupportedJoint, list[str]] = {}
        self._links_for_joints({n: at for n, at in places.items() if n in self._movers})
        for name, place in places.items():
            joint = self._model.joints.get(name)
            why = None if joint is None else obstacle(joint)
            if joint is None and name not in self._movers:
                self._missing("CB302", name, place, names)
            elif why is not None:
                hindered.setdefault(why, []).append(name)
        for why, same in hindered.items():
            first, *others = [places[name] for name in same]
            related = [(place, "and here") for place in others]
            problem = why.format_message(same, self._model.path.name)
            self._diagnostics.add("CB317", first, names=names, related=related, problem=problem)

    def _links_for_joints(self, places: Mapping[str, Place]) -> None:
        """Report all links that are named in place of joints, as one diagnostic."""
        if not places:
            return
        (name, place), *others = places.items()
        related = [(there, f"here '{self._movers[link]}'") for link, there in others]
        details = {"joint": self._movers[name], "name": name, "given": ""}
        self._diagnostics.add("CB319", place, related=related, **details)

    def _idle_tip(self, effector: str, link: str) -> None:
        """Report a tip that none of its effector's joints move."""
        place = self._source.place("effectors", effector, "tip", "link")
        links = self._body.moved_links(effector)
        self._diagnostics.add("CB318", place, names=links, name=link, effector=effector)

    def _named_links(self) -> None:
        links = sorted(self._model.links)
        for steps, link in self._links():
            if link not in self._model.links:
                would_do = [root(self._model)] if steps == ("base",) else links
                self._missing("CB303", link, self._source.place(*steps), would_do)
        for steps, pattern in self._patterns():
            if not self._matches(pattern):
                self._missing("CB303", pattern, self._source.place(*steps), links)

    def _base(self) -> None:
        """Check that the base is the model's root, which the simulator puts at the origin."""
        base = self._robot.base
        for joint in self._model.joints.values():
            if joint.child == base:
                place = self._source.place("base")
                names = [root(self._model)]
                details = {"name": base, "joint": joint.name, "given": ""}
                self._diagnostics.add("CB310", place, names=names, **details)

    def _links(self) -> Iterator[tuple[Steps, str]]:
        if self._robot.base is not UNKNOWN:
            yield ("base",), self._robot.base
        for name, effector in self._robot.effectors.items():
            if effector.tip is not None:
                yield ("effectors", name, "tip", "link"), effector.tip.link
        for hand, cells in self._robot.load_cells.items():
            for finger, cell in cells.items():
                yield ("load_cells", hand, finger, "link"), cell.link
        for name, camera in self._robot.cameras.items():
            yield ("cameras", name, "link"), camera.link
        for name in self._robot.clearance.shapes:
            yield ("clearance", "shapes", name), name
        for name, sensor in self._robot.sensors.items():
            if sensor.link is not None:
                yield ("sensors", name, "link"), sensor.link

    def _patterns(self) -> Iterator[tuple[Steps, str]]:
        """Yield the paths of link patterns, in which a trailing * matches any ending."""
        simulation = self._robot.simulation
        for i, surface in enumerate(simulation.surfaces):
            for j, pattern in enumerate(surface.links):
                yield ("simulation", "surfaces", i, "links", j), pattern
        for i, group in enumerate(simulation.no_contact):
            for j, pattern in enumerate(group):
                yield ("simulation", "no_contact", i, j), pattern
        for i, group in enumerate(self._robot.clearance.ignore):
            for j, pattern in enumerate(group):
                yield ("clearance", "ignore", i, j), pattern

    def _matches(self, pattern: str) -> bool:
        if not pattern.endswith("*"):
            return pattern in self._model.links
        return any(link.startswith(pattern[:-1]) for link in self._model.links)

    def _missing(self, code: str, name: str, place: Place, names: Sequence[str]) -> None:
        everything = [*self._model.joints] if code == "CB302" else names
        joint = self._model.joints.get(name)
        # A joint's name in place of a link's most likely means the link that the joint moves.
        given = name if joint is None else joint.child
        hints = {"names": names, "candidates": names or everything, "given": given}
        self._diagnostics.add(code, place, **hints, name=name, model=self._model.path.name)

    def _resolution(self, name: str, effector: Effector) -> None:
        """Check that an effector's encoder resolution has the unit of its joints' positions."""
        steps = "effectors", name, "resolution"
        if not self._source.holds(*steps):
            return
        node = self._source.node(steps)
        for joint in effector.joints:
            limits = self._model.joints.get(joint)
            if limits is not None and is_of_another_kind(node.value, limits.unit):
                self._diagnostics.add(
                    "CB390", node.place, text=node.value, name=joint, unit=limits.unit
                )
                return

    def _postures(self, name: str, effector: Effector) -> None:
        for posture, angles in effector.postures.items():
            for i, (joint, angle) in enumerate(zip(effector.joints, angles, strict=False)):
                limits = self._model.joints.get(joint)
                if limits is None:
                    continue
                node = self._source.node(("effectors", name, "postures", posture, i))
                unit = limits.unit
                if is_of_another_kind(node.value, unit):
                    self._diagnostics.add(
                        "CB390", node.place, text=node.value, name=joint, unit=unit
                    )
                elif not limits.lower <= angle <= limits.upper:
                    span = limits.lower, limits.upper
                    limits_text = limit_details(node.value, angle, span, unit)
                    hint = _degrees_meant(angle, limits) if limits_text["unit"] == "rad" else ""
                    self._diagnostics.add(
                        "CB305", node.place, joint=joint, hint=hint, **limits_text
                    )


def _degrees_meant(angle: float, limits: UrdfJoint) -> str:
    """Return the remedy for an angle that is within the limits if read as degrees, or ''."""
    # Up to 3.15, a number may well be radians: half a turn is 3.14 rad.
    fits = limits.lower <= math.radians(angle) <= limits.upper
    return f"; write {angle:g} deg if degrees are meant" if fits and abs(angle) > 3.15 else ""
