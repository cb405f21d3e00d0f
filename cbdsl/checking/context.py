"""The program under examination."""

from __future__ import annotations

from typing import Any

from cbdsl.checking.body import Body
from cbdsl.checking.findings import Findings
from cbdsl.checking.parsing import parse_at
from cbdsl.checking.scope import Scope, parameters_in
from cbdsl.documents.program import ProgramDocument
from cbdsl.errors.diagnostic import Place
from cbdsl.language.expression import Expression, Span
from cbdsl.types.resource import Resource
from cbdsl.yaml_text.reader import Loaded
from cbdsl.yaml_text.source_map import SourceMap, Step

Steps = tuple[Step, ...]


class Context:
    """What every check of one program needs.

    Attributes:
        loaded: the program's document.
        body: its robot.
        has_body: whether there is one; without it no resource is known.
        scope: values of its parameters.
        findings: what was found so far.
        used: names of controllers and programs that something refers to.
        lost_models: names of internal models that cannot be used.
    """

    def __init__(
        self, loaded: Loaded[ProgramDocument], body: Body | None, scope: Scope, findings: Findings
    ) -> None:
        self.loaded = loaded
        self.has_body = body is not None
        self._body = body
        self.scope = scope
        self.findings = findings
        self.used: set[str] = set()
        self.lost_models: set[str] = set()
        self._wrong_values: set[str] = set()

    @property
    def body(self) -> Body:
        """The program's robot, which has to be there."""
        assert self._body is not None, "without a robot nothing asks for its resources"
        return self._body

    @property
    def document(self) -> ProgramDocument:
        """The program's document."""
        return self.loaded.document

    @property
    def source(self) -> SourceMap:
        """Where the parts of the program stand."""
        return self.loaded.source

    def add(self, code: str, place: Place, **details: Any) -> None:
        """Add a finding."""
        self.findings.add(code, place, **details)

    def parse(self, text: str, steps: Steps) -> Expression | None:
        """The composition at a path, or ``None`` where it is none."""
        return parse_at(text, self.source, steps, self.findings)

    def at(self, steps: Steps, span: Span) -> Place:
        """Where a stretch of a composition stands."""
        return self.source.inside(steps, span.start, span.end)

    def substitute(self, text: str, steps: Steps, scope: Scope, offset: int = 0) -> str | None:
        """A text at a path with its parameters replaced, or ``None``."""
        return scope.substitute(text, self.source, steps, self.findings, offset)

    def resource(self, text: str, steps: Steps, scope: Scope) -> Resource | None:
        """The resource that a text at a path names, or ``None``."""
        name = self.substitute(text, steps, scope)
        if name is None:
            return None
        resource = self.body.resources.get(name)
        if resource is None and not self._is_reported(text, name, scope):
            known = list(self.body.resources)
            hints = {"names": _similar(name, known), "candidates": known}
            robot = self.body.document.name
            self.add("CB501", self.source.place(*steps), **hints, name=name, robot=robot)
        return resource

    def _is_reported(self, text: str, name: str, scope: Scope) -> bool:
        """Whether what makes a name unknown has been reported before."""
        part = name.rpartition(".")[2]
        if part in self.lost_models or not self.source.is_whole("models", part):
            return True
        # A wrong value of a parameter is wrong wherever the parameter occurs.
        parts = {part for known in self.body.resources for part in known.split(".")}
        values = {scope.values[parameter] for parameter in parameters_in(text)}
        wrong = {value for value in values if not parts.issuperset(value.split("."))}
        is_known = bool(wrong) and wrong <= self._wrong_values
        self._wrong_values |= wrong
        return is_known


def _similar(name: str, names: list[str]) -> list[str]:
    """Names that begin like a wrong one, or the first parts of all."""
    first = name.split(".")[0]
    siblings = [known for known in names if known.split(".")[0] == first]
    return siblings or list(dict.fromkeys(known.split(".")[0] for known in names))
