"""Context of the checked program."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from cbdsl.checking.lookup.missing_resources import MissingResources
from cbdsl.checking.lookup.scope import Scope
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.sound_controllers import SoundControllers
from cbdsl.checking.start_clearance import is_measured
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown, all_known
from cbdsl.documents.program import ControllerSection, ProgramDocument
from cbdsl.language.expression import Expression, Span, Term
from cbdsl.language.parser import LookAlikeError, parse
from cbdsl.language.scanner import CompositionError
from cbdsl.robot.instance_names import (
    InstanceName,
    MarkName,
    instance_names,
    is_meant_as_instance,
    parse_instance,
    parse_mark,
)
from cbdsl.robot.pair_names import PairName, parse_pair
from cbdsl.robot.resources import CLEARANCE, FROM
from cbdsl.types.resource import LinkDistance, Origin, Resource
from cbdsl.types.resource_type import LENGTH
from cbdsl.types.source_record import is_located
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import SourceMap, Step

Steps = tuple[Step, ...]


class ProgramContext:
    """One program, its robot and its scope, as each check of it needs them.

    Args:
        loaded: Program's document.
        body: Robot.
        scope: Values of its parameters.
        diagnostics: Diagnostics so far.
        is_unknown: Predicate of names of resources that an error elsewhere makes unknown.
        sound: Controllers without diagnostics in the last check of the program.

    Attributes:
        loaded: Program's document.
        body: Robot.
        has_body: True if there is a robot; without it no resource is known.
        scope: Values of its parameters.
        diagnostics: Diagnostics so far.
        controllers: Program's controllers and compositions.
        programs: Programs that it uses.
        used: Names of controllers and programs that the document refers to.
        sound: Controllers without diagnostics in the last check of the program.
    """

    def __init__(
        self,
        loaded: Loaded[ProgramDocument],
        body: Outcome[CheckedRobot],
        scope: Scope,
        diagnostics: Diagnostics,
        is_unknown: Callable[[str], bool],
        sound: SoundControllers,
    ) -> None:
        self.loaded = loaded
        self.has_body = body is not UNKNOWN
        self._body = body
        self.scope = scope
        self.diagnostics = diagnostics
        self.controllers = loaded.source.declared(loaded.document.controllers, "controllers")
        self.programs = loaded.source.declared(loaded.document.use, "use")
        self.used: set[str] = set()
        robot, known = loaded.document.robot, {} if isinstance(body, Unknown) else body.resources
        self._missing = MissingResources(robot, known, scope, loaded.source, diagnostics)
        self._is_unknown = is_unknown
        self.sound = sound

    @property
    def body(self) -> CheckedRobot:
        """Program's robot, which has to exist."""
        assert not isinstance(self._body, Unknown), "without a robot nothing asks for its resources"
        return self._body

    @property
    def wrong_parameters(self) -> Collection[str]:
        """Parameters whose values have been reported."""
        return self._missing.parameters

    @property
    def document(self) -> ProgramDocument:
        """Program's document."""
        return self.loaded.document

    @property
    def source(self) -> SourceMap:
        """Source map of the program."""
        return self.loaded.source

    def controller(self, term: Term) -> Outcome[ControllerSection | str] | None:
        """Return the controller of a term: that of a call as written, or of its name."""
        return self.controllers.get(str(term), self.controllers.get(term.name))

    def add(self, code: str, place: Place, **details: Any) -> None:
        """Add a diagnostic."""
        self.diagnostics.add(code, place, **details)

    def parse(self, text: str, steps: Steps) -> Outcome[Expression]:
        """Return the composition at a path; unknown if the text is not valid."""
        return parse_at(text, self.source, steps, self.diagnostics)

    def at(self, steps: Steps, span: Span) -> Place:
        """Return the place of a span of a composition."""
        return self.source.inside(steps, span.start, span.end)

    def substitute(self, text: str, steps: Steps, offset: int = 0) -> Outcome[str]:
        """Return a text at a path with its parameters replaced."""
        return self.scope.substitute(text, self.source, steps, self.diagnostics, offset)

    def resource(self, text: str, steps: Steps) -> Outcome[Resource]:
        """Return the resource that a text at a path names."""
        name = self.substitute(text, steps)
        if isinstance(name, Unknown):
            return UNKNOWN
        resource = self.body.resources.get(name)
        if resource is not None or self._is_unknown(name):
            return resource or UNKNOWN
        own, _, rest = name.partition(".")
        of, _, other = rest.partition(".")
        if own in self.body.document.all_effectors and (rest == CLEARANCE or of == FROM):
            return self._distance(name, own, other, steps)
        pair = parse_pair(name, self.body.resources)
        if pair is not None:
            return self._pair(name, pair, steps)
        mark = parse_mark(name, self.body.resources)
        if mark is not None:
            return self._mark(name, mark, steps)
        instance = parse_instance(name, self.body.resources)
        if instance is None or not is_meant_as_instance(instance.instance):
            self._missing.report(text, name, steps)
            return UNKNOWN
        return self._instance(name, instance, steps)

    def _distance(self, name: str, own: str, other: str, steps: Steps) -> Outcome[Resource]:
        """Return the distance between the links of an effector and others, or all others."""
        body, place = self.body, self.source.place(*steps)
        features = all_known([self.resource(other, steps)] if "." in other else [])
        if isinstance(features, Unknown) or body.model is None:
            return UNKNOWN
        is_effector = other in body.document.all_effectors
        links = body.moved_links(own) + (body.moved_links(other) if is_effector else [])
        is_known = is_effector or features or other in body.document.clearance.keep_out
        is_fixture = bool(other) and not is_known
        source = LinkDistance(own, other, tuple(links), tuple(features), is_fixture)
        hint = "; a distance is one from another effector, or a place, fixture or seen object"
        if all(is_located(each.source) for each in features):
            hint = f"; no link of '{own}' has a shape that can come near it"
            if is_measured(body.document, body.model, source):
                origin = Origin.TRIANGULATION if features else Origin.KINEMATICS
                return Resource(name, LENGTH, origin, source)
        self.add("CB501", place, name=name, robot=body.document.name, hint=hint, names=[], given="")
        return UNKNOWN

    def _pair(self, name: str, pair: PairName, steps: Steps) -> Outcome[Resource]:
        """Return the resource of a pair of channels, unless both are the same."""
        if pair.is_of_one:
            self.add("CB566", self.source.place(*steps), name=name)
            return UNKNOWN
        return pair.resource(name)

    def _mark(self, name: str, parsed: MarkName, steps: Steps) -> Outcome[Resource]:
        """Return the heading to a mark of one hue, if its object can have such a mark."""
        robot, place = self.body.document, self.source.place(*steps)
        resource = parsed.resource(name, robot)
        if resource is None:
            details = {"name": parsed.base.name, "hue": parsed.hue}
            self.add("CB567", place, names=parsed.hues(robot), given=parsed.hue, **details)
        return resource or UNKNOWN

    def _instance(self, name: str, parsed: InstanceName, steps: Steps) -> Outcome[Resource]:
        """Return the resource of an instance of a channel, if there can be such an instance."""
        robot, given = self.body.document, parsed.instance
        allowed, base = instance_names(robot), parsed.base.name
        if given in allowed:
            return parsed.resource(name)
        hint = (
            f"; {robot.vision.regions.instances} things of a channel are kept apart"
            if allowed
            else "; only two cameras tell the things of a channel apart"
        )
        place = self.source.place(*steps)
        details = {"name": base, "instance": given, "hint": hint}
        self.add("CB565", place, names=allowed, given=given, **details)
        return UNKNOWN


# Sections whose keys occur in compositions.
_CALLED = ("controllers", "use")


def parse_at(
    text: str, source: SourceMap, steps: tuple[Step, ...], diagnostics: Diagnostics
) -> Outcome[Expression]:
    """Return the composition at a path; unknown if the text is not valid."""
    try:
        return parse(text)
    except LookAlikeError as error:
        place = source.inside(steps, error.span.start, error.span.end)
        diagnostics.add("CB408", place, sign=error.sign, suggestion=error.suggestion)
    except CompositionError as error:
        if _is_of_a_faulty_name(text, source):
            return UNKNOWN
        place = source.inside(steps, error.span.start, error.span.end)
        diagnostics.add("CB401", place, problem=str(error))
    return UNKNOWN


def _is_of_a_faulty_name(text: str, source: SourceMap) -> bool:
    """Return whether a text mentions an invalid key such as ``track-it``."""
    return any(key in text and not key.isidentifier() for key in source.broken.keys(_CALLED))
