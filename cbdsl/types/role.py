"""Roles: typed parts of a robot that a program needs, with their relations (Sections 8.2, 8.3)."""

from __future__ import annotations

import re
from typing import NamedTuple

from cbdsl.types.allotment import EFFECTOR, Allotment, allotment

#: Name of the value that names the robot of a program with roles.
ROBOT = "robot"

#: Relations of a role to another one, as they are written.
RELATIONS = ("on", "other than")

_ROLE = re.compile(r"(?P<kind>.+?)(?:\s+on\s+(?P<on>\w+))?(?:\s+other\s+than\s+(?P<other>\w+))?\s*")


class Role(NamedTuple):
    """Part that a robot has to have.

    Attributes:
        wanted: Kind of effector.
        on: Role of the effector that carries it; empty if any may.
        other: Role of the effector that it has to differ from; empty if none.
    """

    wanted: Allotment
    on: str = ""
    other: str = ""

    @property
    def relations(self) -> dict[str, str]:
        """Roles that it is related to, by relation."""
        pairs = zip(RELATIONS, (self.on, self.other), strict=True)
        return {relation: name for relation, name in pairs if name}


def role(text: str) -> Role | None:
    """Read a role such as ``effector of force on arm``; ``None`` if it is not one."""
    match = _ROLE.fullmatch(text.strip())
    wanted = match and allotment(match["kind"])
    if match is None or wanted is None or wanted.kind != EFFECTOR:
        return None
    return Role(wanted, match["on"] or "", match["other"] or "")
