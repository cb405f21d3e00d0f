"""Why programs cannot move a joint of a model, and what helps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from cbdsl.robot.urdf import UrdfJoint, UrdfModel

_LIMIT = '<limit lower="-3.14" upper="3.14" effort="10" velocity="2"/>'
_MOST_NAMES = 4


class Hindrance(NamedTuple):
    """What several joints may have in common.

    Attributes:
        trait: what the joint is, after "is" or "are".
        remedy: what to do; ``{them}`` stands for the joints.
    """

    trait: str
    remedy: str

    def told(self, names: Sequence[str], model: str) -> str:
        """The sentence that says so of some joints of a model."""
        shown = [f"'{name}'" for name in names[:_MOST_NAMES]]
        more = len(names) - len(shown)
        last = f"{more} more" if more else shown.pop()
        listed = f"{', '.join(shown)} and {last}" if shown else last
        they_are, them = ("it is", "it") if len(names) == 1 else ("they are", "them")
        advice = self.remedy.format(them=them)
        return f"{listed} cannot be moved: in {model} {they_are} {self.trait}; {advice}"


_FIXED = Hindrance("fixed", "leave {them} out")
_CONTINUOUS = Hindrance(
    "continuous, and programs move only between limits",
    f'leave {{them}} out, or write type="revolute" and {_LIMIT} there, with limits in rad',
)
_LIMITLESS = Hindrance(
    "revolute without lower and upper limits",
    f"leave {{them}} out, or write limits there, in rad, such as {_LIMIT}",
)


def hindrance(joint: UrdfJoint) -> Hindrance | None:
    """What keeps a joint from being moved by an effector, or ``None``."""
    if joint.kind == "fixed":
        return _FIXED
    if joint.kind == "continuous":
        return _CONTINUOUS
    if not joint.revolute:
        trait = f"{joint.kind}, and programs move only joints that turn about one axis"
        return Hindrance(trait, "leave {them} out")
    if joint.mimic is not None:
        master, ratio = joint.mimic.joint, joint.mimic.ratio
        trait = f"made to mimic '{master}'"
        return Hindrance(trait, f"write {{them}} in couplings: follows {master}, ratio {ratio:g}")
    return None if joint.limited else _LIMITLESS


def movable(model: UrdfModel) -> list[str]:
    """The names of the joints that effectors can have, in the file's order."""
    return [joint.name for joint in model.joints.values() if hindrance(joint) is None]


def hindered(joints: Iterable[UrdfJoint]) -> dict[Hindrance, list[UrdfJoint]]:
    """The joints that cannot be moved, by what keeps them from it."""
    found: dict[Hindrance, list[UrdfJoint]] = {}
    for joint in joints:
        why = hindrance(joint)
        if why is not None:
            found.setdefault(why, []).append(joint)
    return found
