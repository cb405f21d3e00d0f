"""Links by the patterns with which a robot file names them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import combinations

from cbdsl.backends.backend import BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.simulation_section import TipSurface
from cbdsl.robot.urdf import UrdfModel, is_named


def matching_links(
    robot: RobotDocument, model: UrdfModel, patterns: Iterable[str]
) -> tuple[str, ...]:
    """Return links that match patterns, by pattern; a trailing * matches any ending.

    Raises:
        BackendError: A pattern matches no link.
    """
    links: list[str] = []
    for pattern in patterns:
        # In the model's order, which its set of names does not have.
        matching = [name for name in model.bodies if is_named(name, pattern)]
        if not matching and not pattern.endswith("*"):
            raise BackendError(
                f"{model.path.name} has no link '{pattern}', which robot '{robot.name}' names"
            )
        if not matching:
            raise BackendError(
                f"{model.path.name} has no link that matches '{pattern}', "
                f"as robot '{robot.name}' expects"
            )
        links += matching
    return tuple(links)


def pairs_without_contact(robot: RobotDocument, model: UrdfModel) -> set[tuple[str, str]]:
    """Return the pairs of links whose contacts a robot file ignores, each in order of the names.

    Raises:
        BackendError: A pattern matches no link.
    """
    groups = (set(matching_links(robot, model, each)) for each in robot.simulation.no_contact)
    return {pair for group in groups for pair in combinations(sorted(group), 2)}


def link_surfaces(robot: RobotDocument, model: UrdfModel) -> Mapping[str, TipSurface]:
    """Return the material of each link that has one in a robot file; the last one counts.

    Raises:
        BackendError: A pattern matches no link.
    """
    return {
        link: surface
        for surface in robot.simulation.surfaces
        for link in matching_links(robot, model, surface.links)
    }
