"""Conversion of a program's policy over patterns of states into steps with named exits."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from cbdsl.checking.rules.flow import automaton_of
from cbdsl.documents.program import ProgramDocument
from cbdsl.language.exit import when_text
from cbdsl.language.parser import parse
from cbdsl.program.automaton import Automaton, Box, ProgramStep, To
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.exit_list import with_short_exits
from cbdsl.program.steps import kind_of_member
from cbdsl.types.state import LETTERS
from cbdsl.yaml_text.reader import formatted_text
from cbdsl.yaml_text.writer import dump_plain

_KEY = re.compile(r"([a-z_]+):")
_REPLACED = ("actions", "policy", "success", "failure")


def with_steps(text: str, document: ProgramDocument, program: CheckedProgram) -> str:
    """Return the text of a program with steps in place of its policy.

    Comments stay: those of a pattern above its step, others above all steps.

    Args:
        text: Text of the document.
        document: Document without errors.
        program: The same document, checked.

    Returns:
        Text of a program that decides each state in the same way; the same text for a program
        that has steps, or no policy.
    """
    automaton = None if document.steps else automaton_of(program)
    if automaton is None:
        return text
    names = _names(automaton)
    steps = [with_short_exits(step) for step in automaton.steps.values()]
    steps.sort(key=lambda step: step.name != automaton.start)
    shown = {*program.members, *(step.action for step in steps)}
    listed = {str(parse(action)) for action in document.actions}
    is_listed = listed > shown.intersection(listed)
    sections = _sections(text)
    comments = _Comments(sections, automaton)
    lines = [*comments.general, "steps:"]
    for step in steps:
        lines += [f"  {comment}" for comment in comments.of_step.get(step.name, ())]
        lines += _StepText(step, names, document).lines()
    replaced = [key for key in _REPLACED if not (key == "actions" and is_listed)]
    kept = [section for section in sections if section.key not in replaced]
    place = next(
        (i for i, section in enumerate(sections) if section.key == "policy"), len(sections)
    )
    before = sum(section.key not in replaced for section in sections[:place])
    blocks = [[*s.comments, *s.lines] for s in kept]
    blocks.insert(before, ["", *lines, ""])
    return formatted_text("\n".join(line for block in blocks for line in block) + "\n", "steps")


def _names(automaton: Automaton) -> dict[str, str]:
    """Return the names of steps by their actions: that of the leading term where it is free."""
    names: dict[str, str] = {}
    for action in sorted(automaton.steps, key=lambda action: len(parse(action).terms)):
        terms = [term.name for term in parse(action).terms]
        options = ["_".join(terms[-count:]) for count in range(1, len(terms) + 1)]
        options += [f"{options[0]}_{number}" for number in range(2, len(automaton.steps) + 3)]
        taken = {*names.values(), "succeed", "fail", "end"}
        names[action] = next(name for name in options if name not in taken)
    return names


class _StepText:
    def __init__(
        self, step: ProgramStep, names: Mapping[str, str], document: ProgramDocument
    ) -> None:
        self._step, self._names, self._document = step, names, document

    def lines(self) -> list[str]:
        """Return the step in block style, or in one line if it has only the usual exits."""
        step, name = self._step, self._names[self._step.name]
        do = [] if step.action == name else [("do", step.action)]
        exits = [(self._when(exit_.boxes[0]), self._to(exit_.to)) for exit_ in step.exits]
        usual = self._usual()
        if usual is not None:
            inner = ", ".join(f"{key}: {_scalar(value, flow=True)}" for key, value in do + usual)
            return [f"  {name}: {{{inner}}}"]
        return [
            f"  {name}:",
            *(f"    {key}: {_scalar(value)}" for key, value in do),
            "    exits:",
            *(f"      - {_scalar(when)}: {_scalar(to)}" for when, to in exits),
        ]

    def _usual(self) -> list[tuple[str, str]] | None:
        """Return the exits as ``then`` and ``failed``, or ``None`` if there are others.

        A controller that is stuck fails behind ``then``, and goes on behind ``at rest``.
        """
        step, uses = self._step, self._document.use
        at_rest = ("1",) * len(step.members)
        keys = {at_rest: "then", ("-",): "failed"}
        if any(e.boxes[0] == at_rest and e.to.end != "success" for e in step.exits):
            keys = keys if uses.keys() >= set(step.members) else {("-",): "failed"}
        usual = {keys.get(e.boxes[0], ""): self._to(e.to) for e in self._step.exits}
        return None if "" in usual else [(k, usual[k]) for k in ("then", "failed") if k in usual]

    def _to(self, to: To) -> str:
        return self._names[to.step] if to.step else str(to)

    def _when(self, box: Box) -> str:
        step = self._step
        kinds = {member: kind_of_member(member, self._document) for member in step.members}
        return when_text(step.members, box, step.values, kinds)


def _scalar(text: str, *, flow: bool = False) -> str:
    """Return a text as YAML, in quotes where it needs them."""
    written = dump_plain({"x": text}).removeprefix("x: ").rstrip("\n")
    if "\n" in written or (flow and written[0] not in "'\"" and re.search(r"[,\[\]{}]", written)):
        return "'" + text.replace("'", "''") + "'"
    return written


class _Section(NamedTuple):
    """Lines of a top-level key, with the comments and empty lines above it."""

    key: str
    comments: list[str]
    lines: list[str]


def _sections(text: str) -> list[_Section]:
    lines = text.splitlines()
    starts = [i for i, line in enumerate(lines) if _KEY.match(line)]
    sections, end = [], 0
    for start, following in pairwise([*starts, len(lines)]):
        last = following
        while last > start + 1 and (not lines[last - 1].strip() or lines[last - 1][:1] == "#"):
            last -= 1
        key = _KEY.match(lines[start])
        assert key is not None, "sections begin at keys"
        sections.append(_Section(key[1], lines[end:start], lines[start:last]))
        end = last
    return sections


class _Comments:
    """Comments of the replaced sections.

    Attributes:
        general: Comments that belong to no step.
        of_step: Comments above the patterns of a step, by its name.
    """

    def __init__(self, sections: Sequence[_Section], automaton: Automaton) -> None:
        self.general: list[str] = []
        self.of_step: dict[str, list[str]] = {}
        members = set(automaton.members)
        for section in sections:
            if section.key not in _REPLACED:
                continue
            lines = [*section.comments, *section.lines]
            waiting: list[str] = []
            for line in lines:
                comment = re.search(r"(?:^|\s)(#.*)", line)
                if comment is not None and not _lists(comment[1], members):
                    waiting.append(comment[1])
                if line.strip() and line.strip()[0] != "#":
                    step = _step_of(line, automaton) if section.key == "policy" else None
                    self._keep(step, waiting)
                    waiting = []
            self._keep(None, waiting)

    def _keep(self, step: str | None, comments: list[str]) -> None:
        kept = self.general if step is None else self.of_step.setdefault(step, [])
        kept += comments


def _lists(comment: str, members: set[str]) -> bool:
    """Return whether a comment only lists the members behind the letters of a state."""
    words = re.findall(r"[A-Za-z][A-Za-z0-9_]*", comment)
    return bool(words) and members.issuperset(words)


def _step_of(line: str, automaton: Automaton) -> str | None:
    """Return the step that a line of the policy with a pattern belongs to, if only one does."""
    pattern = re.match(r"\s*[\"']?([X01*-]+)[\"']?\s*:", line)
    if pattern is None or len(pattern[1]) != len(automaton.members):
        return None
    active = {m for m, c in zip(automaton.members, pattern[1], strict=True) if c in LETTERS}
    fit = [step.name for step in automaton.steps.values() if active and active <= set(step.members)]
    return min(fit, key=lambda name: len(automaton.steps[name].members), default=None)
