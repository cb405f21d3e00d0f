"""Checked robot: its document, its resources and its URDF model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, Self

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel
from cbdsl.types.casts import CAMERA_TURNS, RIGID_HOLD, Chain
from cbdsl.types.resource import Resource, Source
from cbdsl.types.source_record import (
    Carrier,
    compares,
    configured,
    declaration_of,
    is_visual,
    links_of,
    owner_of,
    record_of,
)
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step


class CheckedRobot(NamedTuple):
    """Robot after the checks of its document.

    Attributes:
        loaded: Document of the robot.
        resources: Resources that programs can name.
        model: URDF of the robot; ``None`` if it cannot be read.
        missed: Undefined effectors and channels that the document names; groups and aliases that
            contain them. The resources that begin or end with these names are unknown.
        idle: Effectors with a tip that their joints, which are sound, do not move.
    """

    loaded: Loaded[RobotDocument]
    resources: Mapping[str, Resource]
    model: UrdfModel | None
    missed: frozenset[str] = frozenset()
    idle: frozenset[str] = frozenset()

    @property
    def document(self) -> RobotDocument:
        """Document of the robot."""
        return self.loaded.document

    def declaration(self, resource: Resource) -> Place:
        """Return the place in the robot's document that declares a resource."""
        return self.loaded.source.key(*self._declared(resource.source))

    def _declared(self, source: Source) -> tuple[Step, ...]:
        """Return the path in the robot's document that declares a resource."""
        path, robot = declaration_of(source), self.document
        if path[0] == "effectors" and path[1] in robot.groups:
            return ("groups", path[1])
        if path[0] == "cameras" and not robot.cameras.keys() >= set(path[1:]):
            return ("cameras",)
        return path

    def limits(self, joints: Iterable[str]) -> list[tuple[float, float] | None]:
        """Return the limits of joints, rad, with ``None`` for joints that the model lacks."""
        known = {} if self.model is None else self.model.joints
        turned = [known.get(joint) for joint in joints]
        return [None if joint is None else (joint.lower, joint.upper) for joint in turned]

    def circular(self, resource: Resource) -> tuple[bool, ...]:
        """Return for each joint of a configuration whether whole turns of it do not count.

        Returns:
            One value a joint; none for a resource of another type, and without a model.
        """
        own, robot = configured(resource.source), self.document
        if not own or self.model is None:
            return ()
        counted = {
            joint
            for effector in robot.effectors.values()
            if effector.count_turns
            for joint in effector.joints
        }
        joints, known = robot.joints(own), self.model.joints
        return tuple(
            joint in known and known[joint].endless and joint not in counted for joint in joints
        )

    def effector_joints(self, resource: Resource) -> tuple[str, ...]:
        """Return the actuated joints that an effector moves."""
        source = resource.source
        return self.document.joints(owner_of(source)) if record_of(source).moves else ()

    def moves(self, effector: str, link: str) -> bool:
        """Return whether one of an effector's joints moves a link of the model."""
        return not set(self.document.joints(effector)).isdisjoint(self._above(link))

    def moved_links(self, effector: str) -> list[str]:
        """Return the links that an effector moves, most moved first, by its joints above them."""
        joints = set(self.document.joints(effector))
        links = () if self.model is None else self.model.links
        moving = {link: len(joints.intersection(self._above(link))) for link in links}
        moved = [link for link, many in moving.items() if many]
        return sorted(moved, key=lambda link: (-moving[link], link))

    def with_idle_tips(self) -> Self:
        """Return a copy of the robot in which ``idle`` is set."""
        model, effectors = self.model, self.document.effectors
        sound = set() if model is None else set(model.movable)
        return self._replace(
            idle=frozenset(
                name
                for name, of in effectors.items()
                if of.tip is not None and model is not None and of.tip.link in model.links
                if sound.issuperset(of.joints) and not self.moves(name, of.tip.link)
            )
        )

    def influence(self, resource: Resource) -> frozenset[str] | None:
        """Return the actuated joints that a resource depends on, or ``None`` if unknown."""
        source = resource.source
        if own := configured(source):
            return frozenset(self.document.joints(own))
        if self.model is None:
            return None
        record, links = record_of(source), self._links(source)
        if not self.model.links.issuperset(links):
            return None
        if record.moves and not self.idle.isdisjoint(self.document.members(owner_of(source))):
            return None
        # A joint changes a signal if it moves a body with a sensor or with the sensed object. A
        # difference of two places stays the same under joints that move both bodies alike.
        above = [frozenset(self._above(link)) for link in links]
        shared = frozenset.intersection(*above) if record.differs else frozenset()
        joints = frozenset[str]().union(*above) - shared
        # Before fixed cameras, any effector may wait for a relation of two objects, as a head does.
        is_observed = any(cast.source == resource.type.name for cast in CAMERA_TURNS)
        return None if is_observed and not joints else joints

    def joints_of(self, resource: Resource, chain: Chain) -> frozenset[str]:
        """Return the joints at the end of one of a resource's chains; empty if they are unknown."""
        source, links = resource.source, None
        if RIGID_HOLD in chain:
            links = self._holding_links()
        elif is_visual(source) and not compares(source):
            links = self._camera_links(source)
        if links is None:
            return self.influence(resource) or frozenset()
        if self.model is None or not self.model.links.issuperset(links):
            return frozenset()
        return frozenset(joint for link in links for joint in self._above(link))

    def has_rigid_cameras(self) -> bool:
        """Return whether the cameras of a pair move with the same joints; true without a model."""
        links = [camera.link for camera in self.document.main_cameras.values()]
        if self.model is None or not self.model.links.issuperset(links):
            return True
        # Triangulation (Eq 3.14) needs a constant pose between the cameras. A joint that moves only
        # one of them would change it.
        return len({frozenset(self._above(link)) for link in links}) <= 1

    def has_tip(self, resource: Resource) -> bool:
        """Return whether an effector, or each member of a group, has a tip."""
        own = configured(resource.source)
        return bool(own) and all(
            self.document.effectors[name].tip for name in self.document.members(own)
        )

    def _links(self, source: Source) -> list[str]:
        """Return the links that carry a signal's sensors or the sensed object."""
        return [
            link for carrier in record_of(source).carriers for link in self._of(carrier, source)
        ]

    def _of(self, carrier: Carrier, source: Source) -> list[str]:
        """Return the links of one of a signal's carriers."""
        match carrier:
            case Carrier.TIPS:
                return self._tip_links(owner_of(source))
            case Carrier.CELL:
                _, hand, finger = declaration_of(source)
                return [self.document.load_cells[hand][finger].link]
            case Carrier.CELLS:
                return self._cell_links(self.document.members(owner_of(source)))
            case Carrier.CAMERAS:
                return self._camera_links(source)
            case Carrier.HOLD:
                return self._holding_links()
            case Carrier.LINKS:
                return list(links_of(source))

    def _camera_links(self, source: Source) -> list[str]:
        cameras = self.document.cameras
        _, *names = declaration_of(source)
        return [cameras[n].link for n in names if n in cameras] or [
            c.link for c in self.document.main_cameras.values()
        ]

    def _tip_links(self, effector: str) -> list[str]:
        tips = [self.document.effectors[m].tip for m in self.document.members(effector)]
        return [tip.link for tip in tips if tip is not None]

    def _cell_links(self, hands: Iterable[str]) -> list[str]:
        return [cell.link for hand in hands for cell in self.document.load_cells[hand].values()]

    def _holding_links(self) -> list[str]:
        """Return the tip links of effectors with load cells, with which a held object moves."""
        # All joints of an arm are above the load cells of its hand, and those of a head are not.
        sensed = {
            joint
            for link in self._cell_links(self.document.load_cells)
            for joint in self._above(link)
        }
        return [
            effector.tip.link
            for effector in self.document.effectors.values()
            if effector.tip is not None and sensed.issuperset(effector.joints)
        ]

    def _above(self, link: str) -> list[str]:
        if self.model is None:
            return []
        # A passive joint moves if the actuated joint that it follows does.
        couplings = self.document.couplings
        return [
            couplings[joint].follows if joint in couplings else joint
            for joint in self.model.above(link)
        ]
