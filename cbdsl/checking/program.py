"""Programs: from a document to a checked program that can run, or to all its findings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cbdsl.checking.body import Body
from cbdsl.checking.compositions import Compositions
from cbdsl.checking.context import Context, Steps
from cbdsl.checking.findings import Findings
from cbdsl.checking.learned import check_policy, with_policy
from cbdsl.checking.model import model_resource
from cbdsl.checking.parsing import ends_within_a_call
from cbdsl.checking.scope import Scope
from cbdsl.checking.session import Session
from cbdsl.checking.states import check_states
from cbdsl.checking.suspicious import check_suspicious
from cbdsl.checking.unused import check_unused
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument, Use
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.errors.errors import DiagnosticsError, UsageError
from cbdsl.errors.nearest import meant
from cbdsl.language.expression import Expression, Term
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition, Primitive
from cbdsl.types.resource import Resource
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.reader import Loaded

# Programs within one another, and programs that one uses in all, each with other values.
_DEEPEST = 64
_MOST = 256


def check_program(
    path_or_name: str | Path,
    with_: Mapping[str, str] | None = None,
    library: Library | None = None,
) -> CheckedProgram:
    """Check a program and everything it refers to.

    Args:
        path_or_name: its file, or its name in the library.
        with_: values of its parameters that replace the defaults.
        library: where documents are found by name.

    Raises:
        DiagnosticsError: it has faults.
        UsageError: there is no such program, or it has no such parameter.
    """
    session, findings = Session(library), Findings()
    path = session.library.locate(ProgramDocument, path_or_name)
    values = with_ or {}
    loaded = session.library.read_sound_parts(path, ProgramDocument)
    known = loaded.document.parameters
    for name in values:
        if name not in known and loaded.source.is_whole("parameters", name):
            raise UsageError(f"{path}: {_no_parameter(name, list(known))}")
    checked = examine_program(path, values, session, findings)
    if checked is None or findings.failed:
        raise DiagnosticsError(findings.sorted())
    return checked


def _no_parameter(name: str, known: list[str]) -> str:
    listed = ", ".join(known) or "none"
    return f"there is no parameter '{name}'{meant(name, known)} (known: {listed})"


class Budget:
    """How far the uses below one program have gone; without bounds they could multiply for ever.

    Attributes:
        depth: how many programs are within one another.
        count: how many were checked so far.
    """

    def __init__(self) -> None:
        self.depth = 0
        self.count = 0

    @property
    def ended(self) -> bool:
        """Whether there are more than anybody writes."""
        return self.depth > _DEEPEST or self.count > _MOST


def examine_program(
    path: Path,
    values: Mapping[str, str],
    session: Session,
    findings: Findings,
    budget: Budget | None = None,
) -> CheckedProgram | None:
    """Check a program; findings gather in ``findings``.

    Args:
        path: its file.
        values: values of its parameters that replace the defaults.
        session: documents that were read before, and programs that were checked before.
        findings: where its findings go.
        budget: what has been used on the way to it.

    Returns:
        ``None`` where it cannot run.
    """
    known = session.recall(path, values)
    if known is None:
        own = Findings()
        known = _examine(path, values, session, own, budget or Budget()), own
        session.remember(path, values, *known)
    checked, own = known
    findings.extend(own.sorted())
    return checked


def _examine(
    path: Path, values: Mapping[str, str], session: Session, findings: Findings, budget: Budget
) -> CheckedProgram | None:
    budget.depth += 1
    budget.count += 1
    try:
        loaded = session.library.read_sound_parts(path, ProgramDocument)
        findings.extend(loaded.faults)
        return _ProgramCheck(loaded, values, session, findings, budget).check()
    except DiagnosticsError as error:
        findings.extend(error.diagnostics)
        return None
    finally:
        budget.depth -= 1


class _ProgramCheck:
    def __init__(
        self,
        loaded: Loaded[ProgramDocument],
        values: Mapping[str, str],
        session: Session,
        findings: Findings,
        budget: Budget,
    ) -> None:
        self._loaded = loaded
        self._document = loaded.document
        self._session = session
        self._findings = findings
        self._budget = budget
        self._scope = Scope({**self._document.parameters, **values})
        self._used_programs: dict[str, CheckedProgram | None] = {}

    def check(self) -> CheckedProgram | None:
        self._robot = self._find_robot()
        self._stage()
        for name, use in self._document.use.items():
            self._used_programs[name] = self._use(name, use)
        found = None if self._robot is None else self._session.body(self._robot, self._findings)
        body = None if found is None else self._with_models(found)
        context = Context(self._loaded, body, self._scope, self._findings)
        self._context, self._compositions = context, Compositions(context)
        if body is not None:
            drawn = {name.rpartition(".")[2] for name in body.resources}
            context.lost_models.update(set(self._document.models) - drawn)
        return self._build()

    def _build(self) -> CheckedProgram | None:
        context = self._context
        actions = self._actions()
        background = self._background()
        are_read = self._are_read(actions)
        # An action that cannot be read, or names nothing, may be the one that is missed.
        complete = are_read and all(self._is_declared(expression) for expression, _ in actions)
        members = self._members(actions)
        checked = [self._action(expression, steps) for expression, steps in actions]
        composed = self._only_composed(actions, members) if complete else []
        policy = self._policy([str(expression) for expression, _ in actions], complete)
        known = members if are_read and not composed else None
        check_states(policy, known, context.source, context.findings)
        used = frozenset(context.used)
        self._compositions.check_all()
        self._seek(_primitives(checked), complete and None not in checked)
        if self._findings.failed:
            return None
        check_unused(context, used)
        program = self._program(checked, members, policy, background)
        places = {str(expression): steps for expression, steps in actions}
        check_suspicious(context, program, self._compositions.checked(), places)
        return program

    def _program(
        self,
        actions: list[Action | None],
        members: tuple[str, ...],
        policy: dict[str, str],
        background: Composition | None,
    ) -> CheckedProgram:
        document = self._document
        return CheckedProgram(
            name=document.name,
            robot=document.robot,
            stage=document.stage,
            parameters=self._scope.values,
            members=members,
            primitives=_primitives(actions),
            actions=tuple(action for action in actions if action is not None),
            policy=policy,
            background=background,
            transitions=document.limits.transitions,
            transition_time=document.limits.transition_time,
        )

    def _find_robot(self) -> Path | None:
        name, library = self._document.robot, self._session.library
        path = library.find(RobotDocument, name, self._loaded.path)
        if path is None and self._loaded.source.is_whole("robot"):
            names = library.names(RobotDocument, self._loaded.path)
            self._findings.add("CB601", self._loaded.source.place("robot"), names=names, name=name)
        return path

    def _with_models(self, body: Body) -> Body:
        """The robot with the internal models that this program draws from."""
        found = [self._model(alias, name, body) for alias, name in self._document.models.items()]
        named = {resource.name: resource for resource in found if resource is not None}
        return body._replace(resources={**body.resources, **named}) if named else body

    def _model(self, alias: str, name: str, body: Body) -> Resource | None:
        steps: Steps = ("models", alias)
        source, library = self._loaded.source, self._session.library
        path = library.find(ModelDocument, name, self._loaded.path)
        if path is None:
            names = library.names(ModelDocument, self._loaded.path)
            self._findings.add("CB632", source.place(*steps), names=names, name=name)
            return None
        try:
            model = library.read(path, ModelDocument)
        except DiagnosticsError as error:
            self._findings.extend(error.diagnostics)
            return None
        self._same_robot(model.document.robot, name, steps)
        resource = model_resource(alias, model, body, self._findings)
        if resource is not None and resource.name in body.resources:
            place = source.key(*steps)
            self._findings.add("CB633", place, name=resource.name, robot=self._document.robot)
        return resource

    def _stage(self) -> None:
        name, library = self._document.stage, self._session.library
        if name is None:
            return
        place = self._loaded.source.place("stage")
        path = library.find(StageDocument, name, self._loaded.path)
        if path is None:
            names = library.names(StageDocument, self._loaded.path)
            self._findings.add("CB602", place, names=names, name=name)
            return
        try:
            stage = library.read(path, StageDocument)
        except DiagnosticsError as error:
            self._findings.extend(error.diagnostics)
            return
        self._same_robot(stage.document.robot, name, ("stage",))

    def _same_robot(self, other: str, name: str, steps: Steps) -> None:
        robot = self._document.robot
        source = self._loaded.source
        if other != robot and self._robot is not None and source.is_whole("robot"):
            related = [(source.place("robot"), f"this program is for '{robot}'")]
            details = {"name": name, "other": other, "robot": robot}
            self._findings.add("CB603", source.place(*steps), related=related, **details)

    def _use(self, name: str, use: Use) -> CheckedProgram | None:
        source, library = self._loaded.source, self._session.library
        steps: Steps = ("use", name, "program")
        path = library.find(ProgramDocument, use.program, self._loaded.path)
        if path is None:
            names = library.names(ProgramDocument, self._loaded.path)
            self._findings.add("CB604", source.place(*steps), names=names, name=use.program)
            return None
        way = self._session.uses.way(path, self._loaded.path)
        if way:
            cycle = " → ".join(file.stem for file in (way[-1], *way))
            self._findings.add("CB605", source.place(*steps), name=way[-1].stem, cycle=cycle)
            return None
        if self._budget.ended:
            self._findings.add("CB610", source.place(*steps), depth=_DEEPEST, bound=_MOST)
            return None
        try:
            used = library.read_sound_parts(path, ProgramDocument)
        except DiagnosticsError as error:
            self._findings.extend(error.diagnostics)
            return None
        if used.source.is_whole("robot"):
            self._same_robot(used.document.robot, use.program, steps)
        values = self._values(name, use, used)
        program = examine_program(path, values, self._session, self._findings, self._budget)
        if program is None or use.policy is None:
            return program
        return self._learned(use.policy, program, path, ("use", name, "policy"))

    def _learned(
        self, name: str, program: CheckedProgram, path: Path, steps: Steps
    ) -> CheckedProgram | None:
        """A used program under a policy of its own, or ``None`` where that does not fit."""
        source, library = self._loaded.source, self._session.library
        file = library.find(PolicyDocument, name, self._loaded.path)
        if file is None:
            names = library.names(PolicyDocument, self._loaded.path)
            self._findings.add("CB625", source.place(*steps), names=names, name=name)
            return None
        try:
            loaded = library.read(file, PolicyDocument)
        except DiagnosticsError as error:
            self._findings.extend(error.diagnostics)
            return None
        if loaded.document.program != program.name:
            details = {"name": name, "other": loaded.document.program, "program": program.name}
            self._findings.add("CB626", source.place(*steps), **details)
            return None
        found = Findings()
        check_policy(loaded, program, path, self._session, found)
        self._findings.extend(found.sorted())
        return None if found.failed else with_policy(program, loaded, library)

    def _values(self, name: str, use: Use, used: Loaded[ProgramDocument]) -> dict[str, str]:
        """The parameters of a used program, with this program's own replaced."""
        source, values = self._loaded.source, {}
        for key, text in use.with_.items():
            steps = ("use", name, "with", key)
            if key not in used.document.parameters:
                names = list(used.document.parameters)
                details = {"name": key, "program": use.program}
                if used.source.is_whole("parameters", key):
                    self._findings.add("CB606", source.key(*steps), names=names, **details)
                continue
            value = self._scope.substitute(text, source, steps, self._findings)
            if value is not None:
                values[key] = value
        return values

    def _actions(self) -> list[tuple[Expression, Steps]]:
        """The actions that can be parsed, with their paths."""
        found: dict[str, tuple[Expression, Steps]] = {}
        if self._context.source.broken.holds("actions"):
            return []
        is_cut = False
        for i, text in enumerate(self._document.actions):
            steps: Steps = ("actions", i)
            if is_cut:  # a part of the call before, which has been reported
                is_cut = ")" not in text
                continue
            is_cut = ends_within_a_call(text)
            expression = self._context.parse(text, steps)
            if expression is None:
                continue
            if str(expression) in found:
                place = self._context.source.place(*steps)
                self._context.add("CB607", place, name=str(expression))
            found.setdefault(str(expression), (expression, steps))
        return list(found.values())

    def _are_read(self, actions: list[tuple[Expression, Steps]]) -> bool:
        """Whether every action could be read, and is there once."""
        written = self._document.actions
        return self._context.source.is_whole("actions") and len(actions) == len(written)

    def _members(self, actions: list[tuple[Expression, Steps]]) -> tuple[str, ...]:
        """What a state has a predicate for: the actions of a single term."""
        return tuple(str(e.terms[0]) for e, _ in actions if len(e.terms) == 1)

    def _only_composed(
        self, actions: list[tuple[Expression, Steps]], members: tuple[str, ...]
    ) -> list[str]:
        """Report controllers that no state shows, and that are part of actions."""
        known, names = self._document.controllers, []
        for expression, steps in actions:
            if expression in self._compositions.repetitive:
                continue  # without the repetition it may be an action of a single term
            for term in expression.terms:
                if str(term) not in members and term.name in known:
                    place = self._context.at(steps, term.span)
                    self._context.add("CB608", place, name=str(term))
                    names.append(str(term))
        return names

    def _action(self, expression: Expression, steps: Steps) -> Action | None:
        term = expression.terms[0]
        if len(expression.terms) == 1 and self._is_program(term):
            return self._program_action(term, steps)
        composition = self._compositions.composition(expression, steps)
        return None if composition is None else Action(str(expression), composition)

    def _is_program(self, term: Term) -> bool:
        return term.name in self._document.use and term.name not in self._document.controllers

    def _program_action(self, term: Term, steps: Steps) -> Action | None:
        self._context.used.add(term.name)
        if term.arguments:
            self._compositions.wrong_arity(term, steps, ())
        program = self._used_programs[term.name]
        return None if program is None else Action(term.name, program=program)

    def _background(self) -> Composition | None:
        text = self._document.background
        if text is None:
            return None
        steps: Steps = ("background",)
        expression = self._context.parse(text, steps)
        return None if expression is None else self._compositions.composition(expression, steps)

    def _seek(self, primitives: Mapping[str, Primitive], complete: bool) -> None:
        """Controllers that others wait for have to run.

        Args:
            primitives: what runs, by name.
            complete: whether that is all, because no action is faulty.
        """
        running = [c for primitive in primitives.values() for c in primitive.controllers]
        names = [controller.name for controller in running]
        for key, document in self._document.controllers.items():
            seek = None if isinstance(document, str) else document.seek
            if seek is None or seek.once is None:
                continue
            steps: Steps = ("controllers", key, "seek", "once")
            once = self._context.parse(seek.once, steps)
            if once is None or str(once) in names:
                continue
            missed = {term.name for term in once.terms} <= self._compositions.unknown
            if complete or not (missed or self._is_declared(once)):
                place = self._context.source.place(*steps)
                self._context.add("CB514", place, names=names, name=str(once))

    def _policy(self, actions: list[str], complete: bool) -> dict[str, str]:
        """Canonical action by state pattern.

        Args:
            actions: the names of those that can be read.
            complete: whether these are all.
        """
        policy = {}
        for pattern, text in self._document.policy.items():
            steps: Steps = ("policy", pattern)
            expression = self._context.parse(text, steps)
            if expression is None:
                continue
            if str(expression) not in actions and (complete or not self._is_declared(expression)):
                place = self._context.source.place(*steps)
                self._context.add("CB613", place, names=actions, name=str(expression))
            policy[pattern] = str(expression)
        return policy

    def _is_declared(self, expression: Expression) -> bool:
        """Whether there are controllers or programs of all names, if only faulty ones."""
        known, is_whole = self._document, self._context.source.is_whole
        return all(
            term.name in known.controllers
            or term.name in known.use
            or not (is_whole("controllers", term.name) and is_whole("use", term.name))
            for term in expression.terms
        )


def _primitives(actions: list[Action | None]) -> dict[str, Primitive]:
    """The actions that are single primitives, by name."""
    return {
        action.name: action.composition.primitives[0]
        for action in actions
        if action is not None
        and action.composition is not None
        and len(action.composition.primitives) == 1
    }
