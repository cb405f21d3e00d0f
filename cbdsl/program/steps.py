"""Steps of a program document, read into the automaton that they state."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from cbdsl.documents.program import ControllerSection, ProgramDocument, StepSection
from cbdsl.language.exit import ENDS, OF_KIND, WORDS, Clause, parse_target, parse_when
from cbdsl.language.expression import Expression, Span
from cbdsl.language.parser import parse
from cbdsl.language.scanner import CompositionError
from cbdsl.program.automaton import Automaton, Box, Exit, ProgramStep, To

Path = tuple[str | int, ...]


class DocumentSpot(NamedTuple):
    """Place of a diagnostic in a document.

    Attributes:
        path: Path of a value, or of the value whose key is meant.
        span: Span of the text there, if not all of it.
        is_key: True for the key.
    """

    path: Path
    span: Span | None = None
    is_key: bool = False


Report = Callable[[str, DocumentSpot, dict[str, Any]], None]
"""Receiver of an error: its code, its spot, and details for its message."""


class WrittenStep(NamedTuple):
    """Step of a document before its exits are read.

    Attributes:
        name: Name of the step.
        expression: Composition that it runs.
        path: Path of the composition in the document.
        section: Section with its exits.
    """

    name: str
    expression: Expression
    path: Path
    section: StepSection

    @property
    def members(self) -> tuple[str, ...]:
        """Names of its controllers and programs, in written order."""
        return tuple(map(str, self.expression.terms))

    def conditions(self, document: ProgramDocument) -> tuple[str, ...]:
        """Return the conditions that its exits name, in the order of the document."""
        named = set[str]()
        for when in (when for entry in self.section.exits for when in entry):
            with suppress(CompositionError):
                named.update(str(part.term) for way in parse_when(when) for part in way)
        named.difference_update(self.members)
        return tuple(name for name in document.conditions if name in named)


def written_steps(document: ProgramDocument, report: Report) -> Iterator[WrittenStep]:
    """Yield the steps of a document whose compositions are valid, and report the others."""
    for name, section in document.steps.items():
        path: Path = ("steps", name) if section.do is None else ("steps", name, "do")
        try:
            expression = parse(section.do or name)
        except CompositionError as error:
            report("CB401", DocumentSpot(path, error.span), {"problem": str(error)})
            continue
        yield WrittenStep(name, expression, path, section)


def kind_of_member(name: str, document: ProgramDocument) -> str:
    """Return the kind of a member: a condition, a program or a controller."""
    if name in document.conditions and name not in {**document.controllers, **document.use}:
        return "condition"
    return "program" if name in document.use and name not in document.controllers else "controller"


def may_be_stuck(name: str, document: ProgramDocument) -> bool:
    """Return whether a controller may be at rest beyond the tolerance of its arrival."""
    seen: set[str] = set()
    known = document.controllers
    while isinstance(section := known.get(name), str):
        if name in seen:
            return True
        seen.add(name)
        try:
            name = str(parse(section).terms[-1])
        except CompositionError:
            return True
    if not isinstance(section, ControllerSection):
        return True
    rest = section.quiescence
    is_within = rest is not None and (rest.tolerance is not None or rest.within is not None)
    return section.arrival != "rest" and not (section.arrival is None and is_within)


def compiled(document: ProgramDocument) -> ProgramDocument:
    """Return a program without steps that has the same states and decides them in the same way.

    Args:
        document: Program without errors.
    """
    if not document.steps:
        return document
    steps = list(written_steps(document, _refuse))
    actions = all_actions(document, steps)
    members = tuple(action for action in actions if len(parse(action).terms) == 1)
    members += conditions_of(document, steps)
    tables = StepReader(document, steps, _refuse).automaton(members).tables()
    changed = {
        "steps": {},
        "start": None,
        "actions": actions,
        "policy": dict(tables.policy),
        "success": tables.success,
        "failure": dict(tables.failure) or (),
    }
    return document.model_copy(update=changed)


def conditions_of(document: ProgramDocument, steps: Sequence[WrittenStep]) -> tuple[str, ...]:
    """Return the conditions that are letters of the state: those of exits; without steps, all."""
    if not document.steps:
        return tuple(document.conditions)
    named = {name for step in steps for name in step.conditions(document)}
    return tuple(name for name in document.conditions if name in named)


def all_actions(document: ProgramDocument, steps: list[WrittenStep]) -> tuple[str, ...]:
    """Return the listed actions, then the members of the steps, then their compositions."""
    listed = [str(parse(text)) for text in document.actions]
    members = [member for step in steps for member in step.members]
    return tuple(dict.fromkeys((*listed, *members, *(str(step.expression) for step in steps))))


def _refuse(code: str, spot: DocumentSpot, details: dict[str, Any]) -> None:
    raise AssertionError(f"the program has errors: {code} at {spot.path}")


class StepReader:
    """Reader of the exits of a program's steps.

    Args:
        document: Program.
        steps: Steps whose compositions are valid.
        report: Receiver of errors.
    """

    def __init__(self, document: ProgramDocument, steps: list[WrittenStep], report: Report) -> None:
        self._document, self._steps, self._report = document, steps, report

    def automaton(self, members: tuple[str, ...]) -> Automaton:
        """Return the steps with the exits that are valid; the others have been reported."""
        self._check_names()
        first = next(iter(self._document.steps))
        start = self._document.start or first
        if start not in self._document.steps:
            names = list(self._document.steps)
            self._report("CB620", DocumentSpot(("start",)), {"name": start, "names": names})
            start = first
        return Automaton({each.name: self._step(each) for each in self._steps}, start, members)

    def _check_names(self) -> None:
        """Report steps named like an end, and steps with the same members."""
        first: dict[frozenset[str], WrittenStep] = {}
        for step in self._steps:
            spot = DocumentSpot(("steps", step.name), is_key=True)
            if step.name in ENDS:
                self._report("CB618", spot, {"name": step.name})
            other = first.setdefault(frozenset(step.members), step)
            if other is not step:
                related = ("steps", other.name)
                details = {"name": step.name, "other": other.name, "related": related}
                self._report("CB619", spot, details)

    def _step(self, written: WrittenStep) -> ProgramStep:
        path: Path = ("steps", written.name)
        exits = []
        conditions = written.conditions(self._document)
        open_ones = (OF_KIND["condition"],) * len(conditions)
        for i, entry in enumerate(written.section.exits):
            for when, target in entry.items():
                boxes = self._boxes(when, written, (*path, "exits", i, when))
                to = self._to(target, (*path, "exits", i, when))
                if to is not None:
                    exits.append(Exit(boxes, to, ("exits", i, when)))
        own_values = tuple(self._values(str(term)) for term in written.expression.terms)
        values = own_values + open_ones
        at_rest: Box = tuple("1s" if "s" in own else "1" for own in own_values) + open_ones
        # A success asks for arrival in any case; otherwise, a member that is stuck fails.
        arrived = ("1",) * len(own_values) + open_ones
        undefined = _any_of("-", values, len(own_values))
        for key, box in (("failed", undefined), ("then", (arrived,))):
            target = getattr(written.section, key)
            to = None if target is None else self._to(target, (*path, key))
            if to is not None and to.end == "success":
                exits.append(Exit((at_rest,), to, (key,)))
            elif to is not None:
                exits.append(Exit(box, to, (key,)))
                if key == "then" and arrived != at_rest:
                    exits.append(Exit((at_rest,), To(end="failure"), (key,)))
        action, rest = str(written.expression), To(written.name)
        members = written.members + conditions
        return ProgramStep(written.name, action, members, values, tuple(exits), rest)

    def _values(self, name: str) -> str:
        letters = OF_KIND[kind_of_member(name, self._document)]
        return letters if may_be_stuck(name, self._document) else letters.replace("s", "")

    def _boxes(self, text: str, written: WrittenStep, path: Path) -> tuple[Box, ...]:
        """Return the boxes of an exit's condition; none for one that is invalid."""
        try:
            ways = parse_when(text)
        except CompositionError as error:
            self._report(
                "CB615", DocumentSpot(path, error.span, is_key=True), {"problem": str(error)}
            )
            return ()
        boxes = []
        for way in ways:
            letters = {str(term): self._values(str(term)) for term in written.expression.terms}
            letters |= dict.fromkeys(written.conditions(self._document), OF_KIND["condition"])
            for part in way:
                own = self._letters(part, written, path)
                if own is None:
                    return ()
                name = str(part.term)
                letters[name] = "".join(each for each in letters[name] if each in own)
            boxes.append(tuple(letters.values()))
        return tuple(box for box in boxes if all(box))

    def _letters(self, part: Clause, written: WrittenStep, path: Path) -> str | None:
        name = str(part.term)
        conditions = written.conditions(self._document)
        if name not in (*written.members, *conditions):
            names = [*written.members, *self._document.conditions]
            details = {"name": name, "step": written.name, "names": names}
            self._report("CB616", DocumentSpot(path, part.term.span, is_key=True), details)
            return None
        kind = kind_of_member(name, self._document)
        letters = part.letters(kind)
        if letters is None:
            words = ", ".join(f"'{word}'" for word in WORDS[kind])
            details = {"name": name, "kind": kind, "word": part.word, "words": words}
            self._report("CB617", DocumentSpot(path, part.span, is_key=True), details)
        return letters

    def _to(self, text: str, path: Path) -> To | None:
        try:
            target = parse_target(text)
        except CompositionError as error:
            self._report("CB615", DocumentSpot(path, error.span), {"problem": str(error)})
            return None
        if target.name in ENDS:
            return To(end=ENDS[target.name], reason=target.reason)
        if target.name not in self._document.steps:
            names = [*self._document.steps, *ENDS]
            self._report("CB620", DocumentSpot(path), {"name": target.name, "names": names})
            return None
        return To(target.name)


def _any_of(letter: str, values: Box, size: int) -> tuple[Box, ...]:
    """Return the boxes in which one of the first members has a letter."""
    return tuple((*values[:place], letter, *values[place + 1 :]) for place in range(size))
