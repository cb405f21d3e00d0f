"""The program under examination."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from cbdsl.checking.findings import Findings
from cbdsl.checking.lookup.parsing import parse_at
from cbdsl.checking.lookup.resources import MissingResources
from cbdsl.checking.lookup.scope import Scope
from cbdsl.checking.robot.checked_robot import Body
from cbdsl.documents.program import ProgramDocument
from cbdsl.errors.diagnostic import Place
from cbdsl.language.expression import Expression, Span
from cbdsl.types.resource import Resource
from cbdsl.yaml_text.reader import Loaded
from cbdsl.yaml_text.source_map import SourceMap, Step

Steps = tuple[Step, ...]


class Context:
    """What every check of one program needs.

    Args:
        loaded: the program's document.
        body: its robot.
        scope: values of its parameters.
        findings: where findings go.
        is_explained: whether what makes a resource unknown has been reported.

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
        self,
        loaded: Loaded[ProgramDocument],
        body: Body | None,
        scope: Scope,
        findings: Findings,
        is_explained: Callable[[str], bool],
    ) -> None:
        self.loaded = loaded
        self.has_body = body is not None
        self._body = body
        self.scope = scope
        self.findings = findings
        self.used: set[str] = set()
        self.lost_models: set[str] = set()
        robot, known = loaded.document.robot, {} if body is None else body.resources
        self._missing = MissingResources(robot, known, loaded.source, findings, is_explained)

    @property
    def body(self) -> Body:
        """The program's robot, which has to be there."""
        assert self._body is not None, "without a robot nothing asks for its resources"
        return self._body

    @property
    def wrong_parameters(self) -> Collection[str]:
        """The parameters whose values have been reported."""
        return self._missing.parameters

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
        if resource is None and not self._is_of_a_lost_model(name):
            self._missing.report(text, name, steps, scope)
        return resource

    def _is_of_a_lost_model(self, name: str) -> bool:
        """Whether a name is that of an internal model with faults, which have been reported."""
        part = name.rpartition(".")[2]
        return part in self.lost_models or not self.source.is_whole("models", part)
