"""Roles: typed parts of a robot that a program needs, with their relations (Sections 8.2, 8.3)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.types.allotment import EFFECTOR, Allotment, allotment

#: Kind of roles of sight: two cameras, or the effector that turns them.
EYES = "eyes"
STEREO, STEREO_HEADING = "stereo", "stereo heading"

#: Name of the value that names the robot of a program with roles.
ROBOT = "robot"

#: Relations of a role to another one, as they are written.
RELATIONS = ("on", "other than")

_ROLE = re.compile(
    r"(?P<kind>.+?)(?:\s+on\s+(?P<on>\w+))?(?:\s+other\s+than\s+(?P<other>\w+))?"
    r"(?P<any>\s+if\s+any)?\s*"
)


class Role(NamedTuple):
    """Part that a robot has to have.

    Attributes:
        wanted: Kind of effector, or of sight.
        on: Role of the effector that carries it; empty if any may.
        other: Role of the effector that it has to differ from; empty if none.
        optional: True if a robot without such a part runs the program, too.
    """

    wanted: Allotment
    on: str = ""
    other: str = ""
    optional: bool = False

    @property
    def relations(self) -> dict[str, str]:
        """Roles that it is related to, by relation."""
        pairs = zip(RELATIONS, (self.on, self.other), strict=True)
        return {relation: name for relation, name in pairs if name}


def role(text: str, earlier: Mapping[str, Role]) -> Role | None:
    """Read a role such as ``effector of force on arm``; ``None`` if it is not one.

    Args:
        text: Text of the role.
        earlier: Earlier roles by name, which stand for their kinds: ``arm other than arm``.
    """
    match = _ROLE.fullmatch(text.strip())
    if match is None:
        return None
    kind = " ".join(match["kind"].split())
    relations = match["on"] or "", match["other"] or "", match["any"] is not None
    if kind in earlier:
        return Role(earlier[kind].wanted, *relations)
    wanted = Allotment(EYES, kind) if kind in (STEREO, STEREO_HEADING) else allotment(kind)
    if wanted is None or wanted.kind not in (EFFECTOR, EYES):
        return None
    return Role(wanted, *relations)
