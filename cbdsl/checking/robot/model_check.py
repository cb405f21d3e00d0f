"""Joints, links and postures of robot documents, checked against URDF models."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.limits import is_of_another_kind, limit_details
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.robot import Effector
from cbdsl.robot.chains import root
from cbdsl.robot.unsupported_joint import UnsupportedJoint, unsupported
from cbdsl.robot.urdf import UrdfJoint, UrdfModel, is_named
from cbdsl.yaml_text.source_map import Step

Steps = tuple[Step, ...]


class ModelCheck:
    """Check of the joints, links and postures that a robot's document names against its model."""

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
            if not any(is_named(link, pattern) for link in links):
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
        if not isinstance(self._robot.base, Unknown):
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
