"""Groups of an SRDF as effectors of a robot document, with their tips and postures."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from cbdsl.diagnostics.nearest import suggestion
from cbdsl.robot.srdf import GroupState, SrdfGroup, SrdfModel
from cbdsl.robot.unsupported_joint import unsupported
from cbdsl.robot.urdf import UrdfError, UrdfJoint, UrdfModel

# Decimals of angles in the postures of a robot document.
_DIGITS = 6


class SemanticGroup(NamedTuple):
    """Group of joints that becomes an effector.

    Attributes:
        joints: Joints that programs can move, in the group's order.
        tip: Link that they carry, if they are in series.
        postures: Positions of the joints, rad or m, by name of the posture.
    """

    joints: tuple[UrdfJoint, ...]
    tip: str | None
    postures: Mapping[str, tuple[float, ...]]


class SemanticGroups:
    """Effectors and groups of effectors, with the names of the SRDF.

    Args:
        model: Model of the robot.
        srdf: Semantic description of the robot.

    Attributes:
        effectors: Effectors by name.
        groups: Names of effectors by the name of their group.
        separated: Pairs of links whose contacts are ignored.
        remarks: Sentences about parts of the SRDF that have no counterpart.

    Raises:
        UrdfError: If the SRDF names a missing group, joint or link.
    """

    def __init__(self, model: UrdfModel, srdf: SrdfModel) -> None:
        self._model, self._srdf = model, srdf
        self.remarks: list[str] = []
        self.groups: dict[str, tuple[str, ...]] = {}
        # The order matters: groups are of effectors, and the states of a composed group are
        # postures of its members.
        joints = self._effector_joints()
        self._add_groups(joints)
        postures = self._postures(joints)
        self.effectors = {
            name: SemanticGroup(group, self._tip(name, group), postures[name])
            for name, group in joints.items()
        }
        self.separated = tuple(self._separated())
        for name, kind in srdf.virtual.items():
            if kind != "fixed":
                self.remarks.append(f"virtual joint '{name}' is {kind}: the base is fixed in space")

    def _effector_joints(self) -> dict[str, tuple[UrdfJoint, ...]]:
        """Return the joints of each group that becomes an effector, without shared joints."""
        owners: dict[str, str] = {}
        effectors: dict[str, tuple[UrdfJoint, ...]] = {}
        # Composed groups come last and keep the remaining joints only.
        for group in sorted(self._srdf.groups.values(), key=lambda group: bool(group.groups)):
            joints = tuple(self._actuated(group))
            if self._is_of_groups(group):
                continue
            shared = next((owners[joint.name] for joint in joints if joint.name in owners), None)
            if not joints:
                self.remarks.append(f"group '{group.name}' has no joint that programs can move")
            elif shared is not None:
                self.remarks.append(
                    f"group '{group.name}' has joints of '{shared}', and a joint is in one effector"
                )
            else:
                effectors[_name(group.name)] = joints
                owners |= {joint.name: group.name for joint in joints}
        return effectors

    def _is_of_groups(self, group: SrdfGroup) -> bool:
        return bool(group.groups) and not (group.chains or group.joints or group.links)

    def _add_groups(self, effectors: Mapping[str, tuple[UrdfJoint, ...]]) -> None:
        for group in self._srdf.groups.values():
            if not self._is_of_groups(group):
                continue
            members = tuple(name for name in map(_name, group.groups) if name in effectors)
            if len(members) < 2 or len(members) < len(group.groups):
                self.remarks.append(
                    f"group '{group.name}' is of {', '.join(group.groups)}; "
                    "a group has two effectors or more, and nothing else"
                )
                continue
            self.groups[_name(group.name)] = members

    def _actuated(self, group: SrdfGroup) -> Iterator[UrdfJoint]:
        """Yield the joints of a group that programs can move, each once."""
        for name in dict.fromkeys(self._names(group, ())):
            joint = self._model.joints[name]
            if unsupported(joint) is None and name not in self._srdf.passive:
                yield joint

    def _names(self, group: SrdfGroup, above: tuple[str, ...]) -> Iterator[str]:
        """Yield the names of all joints of a group and its subgroups, including fixed ones."""
        place = f"group '{group.name}'"
        if group.name in above:
            raise UrdfError(f"{self._srdf.path}: {place} is in itself")
        for base, tip in group.chains:
            yield from self._chain(place, base, tip)
        for name in group.joints:
            if name not in self._srdf.virtual:
                self._require("joint", name, self._model.joints, place)
                yield name
        for link in group.links:
            self._require("link", link, self._model.links, place)
            yield from (joint.name for joint in self._model.way(link)[:1])
        for inner in group.groups:
            self._require("group", inner, self._srdf.groups, place)
            yield from self._names(self._srdf.groups[inner], (*above, group.name))

    def _chain(self, place: str, base: str, tip: str) -> list[str]:
        """Return the names of the joints between two links, from the root outwards."""
        for link in (base, tip):
            self._require("link", link, self._model.links, place)
        names = []
        for joint in self._model.way(tip):
            names.append(joint.name)
            if joint.parent == base:
                return names[::-1]
        raise UrdfError(
            f"{self._srdf.path}: {place} has a chain from '{base}' to '{tip}', and no row of "
            "joints leads there"
        )

    def _tip(self, name: str, joints: tuple[UrdfJoint, ...]) -> str | None:
        """Return the link that a group carries: of its hand, of its chain, or of its last joint."""
        group = next(each for each in self._srdf.groups.values() if _name(each.name) == name)
        hands = [
            each.parent_link
            for each in self._srdf.end_effectors
            if each.group != group.name and each.parent_group in ("", group.name)
        ]
        for link in hands:
            self._require("link", link, self._model.links, "an end_effector")
        ends = [tip for _, tip in group.chains] if len(group.chains) == 1 else []
        own = {joint.name for joint in joints}
        # A link is a tip only if all joints of the group are between it and the root. A hand with
        # parallel fingers thus has none. The end effector's parent link is preferred, because it is
        # the mount of the hand in the SRDF.
        last = max(joints, key=lambda joint: len(self._model.above(joint.child)))
        for link in (*hands, *ends, last.child):
            if own <= set(self._model.above(link)):
                return link
        return None

    def _postures(
        self, effectors: Mapping[str, tuple[UrdfJoint, ...]]
    ) -> dict[str, dict[str, tuple[float, ...]]]:
        """Return postures by effector, from the states of its group and of composed groups."""
        postures: dict[str, dict[str, tuple[float, ...]]] = {name: {} for name in effectors}
        for state in self._srdf.states:
            place = f"group_state '{state.name}'"
            self._require("group", state.group, self._srdf.groups, place)
            for joint in state.positions:
                # Virtual joints connect the base to the world, and the URDF does not have them.
                if joint not in self._srdf.virtual:
                    self._require("joint", joint, self._model.joints, place)
            own = _name(state.group)
            for name in self.groups.get(own, (own,)):
                if name in effectors:
                    self._add_posture(state, name, effectors[name], postures[name])
        return postures

    def _add_posture(
        self,
        state: GroupState,
        effector: str,
        joints: tuple[UrdfJoint, ...],
        postures: dict[str, tuple[float, ...]],
    ) -> None:
        positions = []
        for joint in joints:
            given = state.positions.get(joint.name)
            if given is None or len(given) != 1:
                self.remarks.append(
                    f"posture '{state.name}' of '{effector}' is left out: it says no position of "
                    f"joint '{joint.name}'"
                )
                return
            if not joint.lower <= given[0] <= joint.upper:
                self.remarks.append(
                    f"posture '{state.name}' of '{effector}' is left out: {given[0]:g} of joint "
                    f"'{joint.name}' is not within {joint.lower:g} to {joint.upper:g}"
                )
                return
            positions.append(round(given[0], _DIGITS))
        postures[_name(state.name)] = tuple(positions)

    def _separated(self) -> Iterator[tuple[str, str]]:
        for pair in self._srdf.separated:
            absent = next((link for link in pair if link not in self._model.links), None)
            if absent is None:
                yield pair
            else:
                self.remarks.append(
                    f"disable_collisions names link '{absent}', which {self._model.path.name} "
                    f"does not have{suggestion(absent, self._model.links)}"
                )

    def _require(self, what: str, name: str, known: Collection[str], place: str) -> None:
        if name not in known:
            owner = "the SRDF" if what == "group" else self._model.path.name
            raise UrdfError(
                f"{self._srdf.path}: {place} names {what} '{name}', which {owner} does not have"
                f"{suggestion(name, known)}"
            )


def _name(text: str) -> str:
    """Return a valid name: letters, digits and underscores, after a letter."""
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z]", plain) else f"group_{plain}"
