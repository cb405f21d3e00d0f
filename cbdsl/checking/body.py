"""A robot as programs see it: its document, its resources and what its model says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.resources import CYCLOPEAN
from cbdsl.robot.urdf import UrdfModel
from cbdsl.types.resource import (
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    Heading,
    NetLoad,
    Resource,
    Source,
    Tip,
)
from cbdsl.yaml_text.reader import Loaded


class Body(NamedTuple):
    """A checked robot.

    Attributes:
        loaded: its document.
        resources: everything programs can name.
        model: its URDF, or ``None`` where that cannot be read.
    """

    loaded: Loaded[RobotDocument]
    resources: Mapping[str, Resource]
    model: UrdfModel | None

    @property
    def document(self) -> RobotDocument:
        """The robot's document."""
        return self.loaded.document

    def effector_joints(self, resource: Resource) -> tuple[str, ...]:
        """The actuated joints that an effector moves."""
        source = resource.source
        if isinstance(source, (EffectorConfiguration, Tip)):
            return self.document.effectors[source.effector].joints
        return ()

    def influence(self, resource: Resource) -> frozenset[str] | None:
        """The actuated joints that a resource depends on, or ``None`` where nobody can tell."""
        source = resource.source
        if isinstance(source, EffectorConfiguration):
            return frozenset(self.document.effectors[source.effector].joints)
        if self.model is None:
            return None
        return frozenset(joint for link in self._links(source) for joint in self._above(link))

    def _links(self, source: Source) -> list[str]:
        """The links that carry a signal's sensors."""
        robot = self.document
        if isinstance(source, Tip):
            tip = robot.effectors[source.effector].tip
            return [tip.link] if tip is not None else []
        if isinstance(source, FingerLoad):
            return [robot.load_cells[source.hand][source.finger].link]
        if isinstance(source, (NetLoad, FingerForces)):
            return [cell.link for cell in robot.load_cells[source.hand].values()]
        if isinstance(source, Heading):
            cyclopean = source.camera == CYCLOPEAN
            cameras = robot.cameras if cyclopean else [source.camera]
            return [robot.cameras[camera].link for camera in cameras]
        return []

    def _above(self, link: str) -> list[str]:
        assert self.model is not None
        couplings = self.document.couplings
        return [
            couplings[joint].follows if joint in couplings else joint
            for joint in self.model.above(link)
        ]
