"""Reasons why programs cannot move a joint of a model, and remedies."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from cbdsl.robot.urdf import UrdfJoint

_LIMIT = '<limit lower="-3.14" upper="3.14" effort="10" velocity="2"/>'
_MOST_NAMES = 4


class UnsupportedJoint(NamedTuple):
    """Reason why programs cannot move some joints.

    Attributes:
        trait: Property of the joint, after "is" or "are".
        cure: Change of the model or robot file that makes it movable, if there is one.
    """

    trait: str
    cure: str = ""

    def format_message(self, names: Sequence[str], model: str) -> str:
        """Return a sentence about the joints of a model that share the reason."""
        shown = [f"'{name}'" for name in names[:_MOST_NAMES]]
        more = len(names) - len(shown)
        last = f"{more} more" if more else shown.pop()
        listed = f"{', '.join(shown)} and {last}" if shown else last
        they_are, them = ("it is", "it") if len(names) == 1 else ("they are", "them")
        cure = f", or {self.cure}" if self.cure else ""
        return (
            f"{listed} cannot be moved: in {model} {they_are} {self.trait}; leave {them} out{cure}"
        )


_FIXED = UnsupportedJoint("fixed")
_LIMITLESS = UnsupportedJoint(
    "revolute without lower and upper limits",
    f"write limits in the model, in rad, such as {_LIMIT}",
)
_LIMITLESS_SLIDE = UnsupportedJoint(
    "prismatic without lower and upper limits",
    f"write limits in the model, in m, such as {_LIMIT.replace('3.14', '0.04')}",
)


def unsupported(joint: UrdfJoint) -> UnsupportedJoint | None:
    """Return the reason why an effector cannot move a joint, or ``None``."""
    if joint.fixed and joint.mimic is not None:
        trait = f"fixed, although made to mimic '{joint.mimic.joint}'"
        return UnsupportedJoint(trait, "mend its type in the model")
    if joint.fixed:
        return _FIXED
    if not joint.movable:
        trait = (
            f"{joint.kind}, and programs move only joints that turn about or slide along one axis"
        )
        return UnsupportedJoint(trait)
    # This precedes the limits, because limits alone would not make a mimicking joint movable.
    if joint.mimic is not None:
        master, ratio, offset = joint.mimic
        if joint.leaderless:
            trait = f"made to mimic '{master}', which is not a joint that moves"
            return UnsupportedJoint(trait, "mend its <mimic> in the model")
        trait = f"made to mimic '{master}'"
        shift = f" and offset {offset:g}" if offset else ""
        return UnsupportedJoint(
            trait, f"write in couplings that it follows {master}, at ratio {ratio:g}{shift}"
        )
    if joint.endless:
        return None
    if not joint.limited:
        return _LIMITLESS_SLIDE if joint.slides else _LIMITLESS
    trait = f"{joint.kind}, with a lower limit that is not below the upper"
    no_room = UnsupportedJoint(trait, "mend the limits in the model")
    return None if joint.lower < joint.upper else no_room


def unsupported_joints(joints: Iterable[UrdfJoint]) -> dict[UnsupportedJoint, list[UrdfJoint]]:
    """Return the joints that cannot be moved, by reason."""
    by_reason: dict[UnsupportedJoint, list[UrdfJoint]] = {}
    for joint in joints:
        why = unsupported(joint)
        if why is not None:
            by_reason.setdefault(why, []).append(joint)
    return by_reason
