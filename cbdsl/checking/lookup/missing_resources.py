"""Reports of unknown resource names: each mistake once, at its origin."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

from cbdsl.checking.lookup.scope import Scope
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.diagnostics.outcome import UNKNOWN
from cbdsl.language.parameters import parameters_in
from cbdsl.robot.resources import CAMERAS, COUNTED, NOVEL, STEREO, SURFACE
from cbdsl.types.resource import CYCLOPEAN
from cbdsl.yaml_text.source_map import SourceMap, Step

Steps = tuple[Step, ...]


class MissingResources:
    """Reporter of resources that one program names and its robot does not have.

    Args:
        robot: Robot's name.
        known: Names of its resources, and of the program's internal models.
        scope: Values of the program's parameters.
        source: Source map of the program.
        diagnostics: Diagnostics so far.

    Attributes:
        parameters: Parameters of the program whose values name no resource.
    """

    def __init__(
        self,
        robot: str,
        known: Collection[str],
        scope: Scope,
        source: SourceMap,
        diagnostics: Diagnostics,
    ) -> None:
        self._robot, self._known, self._scope = robot, known, scope
        self._source, self._diagnostics = source, diagnostics
        self._wrong_values: set[str] = set()
        self.parameters: set[str] = set()

    def report(self, text: str, name: str, steps: Steps) -> None:
        """Report that a resource does not exist.

        Args:
            text: Name as written in the document.
            name: Name with its parameters replaced.
            steps: Path of the text.
        """
        # A value is wrong if one of its parts occurs in no name of a resource. With ``arm:
        # lft_arm``, the text ``$arm.position`` is correct, and the value is reported once at its
        # definition.
        given = self._scope.values.known
        values = {m[1]: given[m[1]] for m in parameters_in(text) if m[1] in given}
        parts = {part for known in self._known for part in known.split(".")}
        wrong = {p: v for p, v in values.items() if not parts.issuperset(v.split("."))}
        if not wrong:
            self._name(text, name, steps)
        elif not self._wrong_values.issuperset(wrong.values()):
            parameter, value = next(iter(wrong.items()))
            self._value(parameter, value, text, name, steps)
        self._wrong_values.update(wrong.values())

    def _value(self, parameter: str, value: str, text: str, name: str, steps: Steps) -> None:
        """Report the value of a parameter, at its definition if that is in this document."""
        there, here = self._scope.place(parameter), self._source.place(*steps)
        self.parameters.add(parameter)
        related = [] if there is None else [(here, f"here '${parameter}' stands for it")]
        details = {"name": name, "robot": self._robot, "given": value}
        names = self._values_of(parameter, text)
        self._add(there or here, names=names, related=related, **details)

    def _values_of(self, parameter: str, text: str) -> list[str]:
        """Return the values of a parameter with which a text names a resource."""
        # The text becomes a pattern, such as ``(.+)\.position`` for ``$arm.position``. Names that
        # match it show the values that would be valid.
        others = {
            name: value for name, value in self._scope.values.known.items() if name != parameter
        }
        written = re.sub(rf"\\\${parameter}\b", "(.+)", re.escape(text), count=1)
        for name, value in others.items():
            written = re.sub(rf"\\\${name}\b", re.escape(value), written)
        matches = (re.fullmatch(written, name) for name in self._known)
        values = list(dict.fromkeys(match[1] for match in matches if match))
        # A text adds all but the first part of a name to its parameter.
        return [value for value in values if "." not in value] or values

    def _name(self, text: str, name: str, steps: Steps) -> None:
        place, details = self._source.place(*steps), {"name": name, "robot": self._robot}
        first = name.split(".")[0]
        siblings = [known for known in self._known if known.split(".")[0] == first]
        channel = name.partition(".")[2]
        if first == NOVEL and f"{CYCLOPEAN}.{channel}" in self._known:
            # An unknown model may be of this channel.
            if self._source.known(name, "models") is not UNKNOWN:
                self._diagnostics.add("CB674", place, names=siblings, name=name, channel=channel)
            return
        # An effector without load cells, as in ``right_arm.net.force``: another spelling does not
        # help.
        if siblings and _is_load(name) and not any(map(_is_load, siblings)):
            loads = list(dict.fromkeys(k.split(".")[0] for k in self._known if _is_load(k)))
            self._diagnostics.add("CB586", place, effector=first, name=name, names=loads, given="")
            return
        # With a parameter ``arm``, the text ``arm.position`` most likely lacks its ``$``.
        signed = self._with_sign(text)
        if signed is not None:
            names = siblings or self._firsts()
            self._add(place, names=names, candidates=[signed], given=text, **details)
        elif siblings and self._is_alias(name, siblings):
            hint = "; other colours are declared by the robot's 'vision: channels: colors'"
            self._add(place, names=siblings, given="", hint=hint, **details)
        elif siblings:
            self._add(place, names=siblings, candidates=[*siblings, *self._known], **details)
        else:
            # Report all names with the same unknown first part as one mistake.
            firsts = [*(("here",) if steps[-1:] == ("reference",) else ()), *self._firsts()]
            candidates = firsts if "." in name else [*firsts, *self._known]
            if first in (STEREO, CAMERAS, COUNTED, SURFACE):
                pair = "of two cameras, or of more with two in its 'vision: stereo',"
                hint = f"; only a robot {pair} has '{first}'"
                self._add(place, names=firsts, given=name, hint=hint, **details)
                return
            self._add(place, names=firsts, candidates=candidates, given=first, **details)

    def _add(self, place: Place, hint: str = "", **details: Any) -> None:
        self._diagnostics.add("CB501", place, hint=hint, **details)

    def _is_alias(self, name: str, siblings: Collection[str]) -> bool:
        """Return whether a name may be a channel's alias, because it resembles no other name."""
        part, parts = name.partition(".")[2], [known.partition(".")[2] for known in siblings]
        are_channels = any(known == "motion" or known.startswith("hue_") for known in parts)
        return are_channels and bool(part) and nearest_name(part, parts) is None

    def _firsts(self) -> list[str]:
        return list(dict.fromkeys(known.split(".")[0] for known in self._known))

    def _with_sign(self, text: str) -> str | None:
        """Return the text with a ``$`` before each parameter, if that names a resource."""
        parts = text.split(".")
        signed = ".".join(f"${part}" if part in self._scope.values else part for part in parts)
        if signed == text:
            return None
        name = re.sub(r"\$(\w+)", lambda match: self._scope.values.known.get(match[1], ""), signed)
        return signed if name in self._known else None


def _is_load(name: str) -> bool:
    """Return whether a resource's name is that of a force or torque."""
    return name.endswith((".force", ".torque", ".wrench", ".finger_forces"))
