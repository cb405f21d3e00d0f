"""Programs: from a document to a checked program that can run, or to all its diagnostics."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from cbdsl.checking.allotments import check_allotments
from cbdsl.checking.cause_order import causes_first
from cbdsl.checking.controller.axes import check_contradictions
from cbdsl.checking.dependencies import Dependencies
from cbdsl.checking.knowledge.states import check_states
from cbdsl.checking.lookup.scope import Scope
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.rules.actions import Actions
from cbdsl.checking.rules.compositions import Compositions
from cbdsl.checking.rules.conditions import check_conditions
from cbdsl.checking.rules.flow import check_flow
from cbdsl.checking.rules.guards import check_guards
from cbdsl.checking.rules.outcome_states import check_ends, read_ends
from cbdsl.checking.rules.shared_documents import faults_of_shared
from cbdsl.checking.rules.suspicious_parts import check_suspicious
from cbdsl.checking.session import ProgramCheck, Session
from cbdsl.checking.substitution import Examine
from cbdsl.checking.used_programs import Budget, UsedPrograms
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.nearest import nearest_name, suggestion
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.automaton import Automaton, Tables
from cbdsl.program.checked import Action, CheckedProgram, Guards
from cbdsl.program.condition import ProgramCondition
from cbdsl.program.controller import Composition, Primitive
from cbdsl.program.steps import DocumentSpot, StepReader, written_steps
from cbdsl.types.role import ROBOT
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.loaded import Loaded


def check_program(
    path_or_name: str | Path, with_: Mapping[str, str] | None = None, library: Library | None = None
) -> CheckedProgram:
    """Check a program and all documents it refers to.

    Args:
        path_or_name: Program's file, or its name in the library.
        with_: Values of its parameters that replace the defaults.
        library: Library that finds documents by name.

    Raises:
        DiagnosticsError: The program has errors.
        UsageError: The program or one of the parameters does not exist.
    """
    session, diagnostics = Session(library), Diagnostics()
    path = session.library.locate(ProgramDocument, path_or_name)
    values = with_ or {}
    loaded = session.library.read_as_written(path, ProgramDocument)
    document = loaded.document
    known = loaded.source.declared(document.assignable, "parameters")
    for name in values:
        if name not in known and not (name == ROBOT and document.roles):
            raise UsageError(f"{path}: {_unknown(name, values[name], document, list(known))}")
    checked = examine_program(path, values, session, diagnostics)
    if isinstance(checked, Unknown) or diagnostics.failed:
        raise DiagnosticsError(causes_first(diagnostics.sorted(), session.library))
    return checked


def _unknown(name: str, value: str, document: ProgramDocument, known: list[str]) -> str:
    if name == ROBOT:
        return f"this program is for robot '{document.robot}' alone, and not for '{value}'"
    listed = ", ".join(known) or "none"
    return f"unknown parameter '{name}'{suggestion(name, known)} (known: {listed})"


def examine_program(
    path: Path,
    values: Mapping[str, str],
    session: Session,
    diagnostics: Diagnostics,
    budget: Budget | None = None,
) -> Outcome[CheckedProgram]:
    """Check a program, and collect its diagnostics.

    Args:
        path: File of the program.
        values: Values of its parameters that replace the defaults.
        session: Session with the documents and programs checked so far.
        diagnostics: Diagnostics so far.
        budget: Budget of nested programs, shared with the programs above.

    Returns:
        Checked program; unknown if it cannot run.
    """
    known = session.recall(path, values)
    if known is None:
        own = Diagnostics()
        with session.library.bindings() as bindings:
            checked = _examine(path, values, session, own, budget or Budget())
        # A program with a fault of a shared document has no faults that could be judged.
        if own.failed and (shared := faults_of_shared(path, session)).failed:
            own = shared
        known = ProgramCheck(checked, own, bindings)
        session.remember(path, values, known)
    diagnostics.extend(known.diagnostics.sorted())
    return known.program


def examiner(session: Session) -> Examine:
    """Return the check of programs in a session."""
    return lambda path, values, diagnostics: examine_program(path, values, session, diagnostics)


def _examine(
    path: Path,
    values: Mapping[str, str],
    session: Session,
    diagnostics: Diagnostics,
    budget: Budget,
) -> Outcome[CheckedProgram]:
    budget.depth += 1
    budget.count += 1
    try:
        loaded = session.library.read_as_written(path, ProgramDocument)
        diagnostics.extend(loaded.diagnostics)
        diagnostics.extend(each for each in loaded.shared_faults if each.is_error)
        if loaded.document.roles:
            from cbdsl.checking.roles import bound_program  # programs of one robot do without

            bound = bound_program(loaded, values, session, diagnostics)
            if isinstance(bound, Unknown):
                return UNKNOWN
            loaded, values = bound, {k: v for k, v in values.items() if k != ROBOT}
        checked = _ProgramCheck(loaded, values, session, diagnostics, budget).check()
        # A part that seems unused may be meant by a name with an error.
        diagnostics.extend(() if diagnostics.failed else loaded.shared_faults)
        return checked
    except DiagnosticsError as error:
        diagnostics.extend(error.diagnostics)
        return UNKNOWN
    finally:
        budget.depth -= 1


class _ProgramCheck:
    def __init__(
        self,
        loaded: Loaded[ProgramDocument],
        values: Mapping[str, str],
        session: Session,
        diagnostics: Diagnostics,
        budget: Budget,
    ) -> None:
        self._document = loaded.document
        source = loaded.source
        own = source.declared(loaded.document.parameters, "parameters")
        places = {name: source.place("parameters", name) for name in own if name not in values}
        self._scope = Scope(own.extended(values), places)
        dependencies = Dependencies(loaded, session, diagnostics)
        dependencies.check_stage()

        def examine(
            path: Path, with_: Mapping[str, str], own: Diagnostics
        ) -> Outcome[CheckedProgram]:
            return examine_program(path, with_, session, own, budget)

        used = UsedPrograms(
            loaded, session, diagnostics, dependencies, self._scope, budget, examine
        )
        self._used, programs = used, used.check()
        body = dependencies.body()
        context = self._context = ProgramContext(
            loaded,
            body,
            self._scope,
            diagnostics,
            dependencies.is_unknown,
            session.sound(loaded.path),
        )
        self._compositions = Compositions(context)
        self._steps = list(written_steps(loaded.document, self._report))
        self._actions = Actions(context, self._compositions, programs, self._steps)
        # Terms of the background, as written.
        self._below: frozenset[str] = frozenset()
        self._automaton: Automaton | None = None

    def check(self) -> Outcome[CheckedProgram]:
        context, actions = self._context, self._actions
        background = self._background()
        self._avoided = check_guards(context)
        checked = actions.check()
        conditions = check_conditions(context)
        are_complete = actions.are_complete
        are_shown = not (are_complete and actions.only_composed())
        tables = self._tables()
        is_known = actions.are_read and are_shown and not actions.lack_a_member
        members = actions.members if is_known else UNKNOWN
        if not self._document.steps:
            check_states(tables.policy, members, context.source, context.diagnostics)
        ends = read_ends(context, members)
        # Taken before all controllers are checked, because this visits unused ones as well.
        used = frozenset(context.used)
        self._compositions.check_all()
        self._compositions.check_rewards()
        check_allotments(context)
        running = _running(checked, background)
        complete = are_complete and are_shown and UNKNOWN not in (background, *checked)
        # A background with a fault may run the controllers that seem to be missing.
        if context.source.known(self._document.background, "background") is not UNKNOWN:
            self._conditions(running, complete)
        self._used.report_values(context.wrong_parameters)
        if context.diagnostics.failed:
            return UNKNOWN
        # The checks below need a sound program. A part with errors may be the use or the end that
        # another part seems to lack.
        check_unused(context, used | set(actions.conditions))
        program = self._program(checked, tables, background, conditions)
        check_ends(context, program, ends)
        check_contradictions(context, program, self._actions.places)
        check_flow(context, program)
        check_suspicious(context, program, self._compositions.checked(), actions.places)
        return UNKNOWN if context.diagnostics.failed else program

    def _tables(self) -> Tables:
        """Return the document's policy over states, written as patterns or as steps."""
        document, source = self._document, self._context.source
        if not document.steps:
            failure = document.failure
            reasons = failure if isinstance(failure, dict) else dict.fromkeys(failure, "")
            return Tables(self._actions.policy(), document.success, reasons)
        for key in ("policy", "success", "failure"):
            if getattr(document, key):
                self._context.add("CB627", source.key(key), key=key)
        reader = StepReader(document, self._steps, self._report)
        automaton = self._automaton = reader.automaton(self._actions.members)
        if source.known(document.steps, "steps") is UNKNOWN or self._context.diagnostics.failed:
            return Tables({}, (), {})
        return automaton.tables()

    def _report(self, code: str, spot: DocumentSpot, details: dict[str, Any]) -> None:
        """Add a diagnostic of the steps."""
        source, path = self._context.source, spot.path
        # A step without `do` that has a misspelt name is already reported as a missing controller.
        missing = self._compositions.missing.intersection(self._document.steps)
        if code == "CB620" and nearest_name(details["name"], missing):
            return
        # A step or a condition that had to be left out has errors of its own.
        section = {"CB616": "conditions", "CB620": "steps"}.get(code, "")
        entries = getattr(self._document, section, {})
        if source.declared(entries, section).get(details.get("name", "")) is UNKNOWN:
            return
        if code == "CB616" and source.broken.is_below(("shared",)):
            return
        place = source.key(*path) if spot.is_key else source.place(*path)
        if spot.span is not None:
            inside = source.inside_key if spot.is_key else source.inside
            place = inside(path, spot.span.start, spot.span.end)
        if (other := details.pop("related", None)) is not None:
            details["related"] = [(source.key(*other), "the other step")]
        self._context.add(code, place, **details)

    def _program(
        self,
        actions: list[Outcome[Action]],
        tables: Tables,
        background: Outcome[Composition | None],
        conditions: Mapping[str, Outcome[ProgramCondition]],
    ) -> CheckedProgram:
        document = self._document
        return CheckedProgram(
            name=document.name,
            robot=document.robot,
            stage=document.stage,
            parameters=dict(self._scope.values.known),
            members=self._actions.members,
            primitives=_primitives(actions),
            actions=tuple(action for action in actions if not isinstance(action, Unknown)),
            policy=tables.policy,
            background=None if isinstance(background, Unknown) else background,
            transitions=document.limits.transitions,
            transition_time=document.limits.transition_time,
            idle_time=document.limits.idle_time,
            episode_time=document.limits.episode_time,
            reward_ends=document.limits.reward_ends,
            lost_time=document.limits.lost_time,
            success=tables.success,
            failure=tuple(tables.failure),
            reasons=tables.failure,
            automaton=self._automaton,
            conditions={
                name: condition
                for name, condition in conditions.items()
                if name in self._actions.conditions and not isinstance(condition, Unknown)
            },
            guards=Guards(
                document.guards.finger_force,
                document.guards.hand_force,
                document.guards.joint_torque,
                document.guards.clearance,
                *self._avoided,
            ),
        )

    def _background(self) -> Outcome[Composition | None]:
        text = self._document.background
        if text is None:
            return None
        steps: Steps = ("background",)
        expression = self._context.parse(text, steps)
        if isinstance(expression, Unknown):
            return UNKNOWN
        self._below = frozenset(map(str, expression.terms))
        return self._compositions.composition(expression, steps)

    def _conditions(self, names: Sequence[str], complete: bool) -> None:
        """Check that controllers that others wait for run, as far as ``names`` are complete."""
        for steps, text in _named(self._document):
            condition = self._context.parse(text, steps)
            if isinstance(condition, Unknown) or str(condition) in names:
                continue
            missed = {term.name for term in condition.terms} <= self._compositions.missing
            is_declared = self._actions.is_declared(condition) or str(condition) in self._below
            if complete or not (missed or is_declared):
                place, others = self._context.source.place(*steps), tuple(dict.fromkeys(names))
                self._context.add("CB514", place, names=others, name=str(condition))


def _named(document: ProgramDocument) -> Iterator[tuple[Steps, str]]:
    """Yield the paths of references to other controllers, with their texts."""
    for key, controller in document.controllers.items():
        if isinstance(controller, str):
            continue
        if controller.seek is not None and controller.seek.once is not None:
            yield ("controllers", key, "seek", "once"), controller.seek.once
        if controller.requires is not None:
            yield ("controllers", key, "requires"), controller.requires


def _running(actions: list[Outcome[Action]], background: Outcome[Composition | None]) -> list[str]:
    """Return the names of the controllers that some action or the background runs."""
    own = _primitives(actions).values()
    below = background.primitives if isinstance(background, Composition) else ()
    return [each.name for primitive in (*own, *below) for each in primitive.controllers]


def _primitives(actions: list[Outcome[Action]]) -> dict[str, Primitive]:
    """Return the actions that are single primitives, by name."""
    return {
        action.name: action.composition.primitives[0]
        for action in actions
        if not isinstance(action, Unknown)
        and action.composition is not None
        and len(action.composition.primitives) == 1
    }


def check_unused(context: ProgramContext, used: Collection[str]) -> None:
    """Warn of unused controllers, programs and parameters, and of hidden names.

    Args:
        context: Program context.
        used: Controllers, programs and conditions that the program refers to.
    """
    document, source = context.document, context.source
    for section in ("controllers", "use", "conditions"):
        for name in getattr(document, section):
            if name not in used and name not in context.loaded.taken:
                context.add("CB701", source.key(section, name), name=name)
    for name in document.parameters:
        if name not in context.scope.used:
            section = "roles" if name in document.roles else "parameters"
            context.add("CB702", source.key(section, name), name=name)
    for name in document.controllers:
        if name in document.use:
            related = [(source.key("use", name), "the program")]
            place = source.key("controllers", name)
            context.add("CB703", place, related=related, name=name, other="program")
