"""Actions of a program, and the policy that chooses from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.rules.compositions import Compositions
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.language.expression import Expression, Term
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.steps import WrittenStep, conditions_of
from cbdsl.yaml_text.shared_parts import agrees


class Actions:
    """Actions that the policy of one program chooses from.

    Args:
        context: Program context.
        compositions: Builder of the primitives of its controllers.
        programs: Programs that it uses, by name.
        steps: Steps whose compositions are valid.

    Attributes:
        members: Actions of a single term, then conditions; a state has one predicate for each.
        conditions: Conditions among the members.
        are_read: True if each action could be read, and occurs once.
        lack_a_member: True if the policy chooses an action of a single term that the list lacks.
    """

    def __init__(
        self,
        context: ProgramContext,
        compositions: Compositions,
        programs: Mapping[str, Outcome[CheckedProgram]],
        steps: Sequence[WrittenStep] = (),
    ) -> None:
        self._context, self._compositions, self._programs = context, compositions, programs
        self.lack_a_member = False
        listed = self._read()
        self._written = _with_steps(listed, steps)
        expressions = [expression for expression, _ in self._written]
        terms = tuple(str(e.terms[0]) for e in expressions if len(e.terms) == 1)
        self.conditions = conditions_of(context.document, steps)
        self.members = terms + self.conditions
        self._watched = {str(s.expression): s.conditions(context.document) for s in steps}
        written = context.source.known(context.document.actions, "actions")
        self.are_read = (
            not isinstance(written, Unknown)
            and len(listed) == len(written)
            and len(steps) == len(context.document.steps)
            and not context.source.broken.is_below(("steps",))
        )

    @property
    def are_complete(self) -> bool:
        """True if the list is complete, so that an action outside it is missing.

        An action that cannot be read, or cannot be meant as written, may be the missing one.
        """
        return self.are_read and all(self._is_possible(action) for action, _ in self._written)

    @property
    def places(self) -> dict[str, Steps]:
        """Paths of the actions in the document, by name."""
        return {str(expression): steps for expression, steps in self._written}

    def _read(self) -> list[tuple[Expression, Steps]]:
        """Return the actions that can be parsed, with their paths."""
        actions: dict[str, tuple[Expression, Steps]] = {}
        for i, text in enumerate(self._context.document.actions):
            steps: Steps = ("actions", i)
            expression = self._context.parse(text, steps)
            if isinstance(expression, Unknown):
                continue
            if str(expression) in actions:
                place = self._context.source.place(*steps)
                self._context.add("CB607", place, name=str(expression))
            actions.setdefault(str(expression), (expression, steps))
        return list(actions.values())

    def check(self) -> list[Outcome[Action]]:
        """Return the actions in their order; those with errors are unknown."""
        actions = [self._action(expression, steps) for expression, steps in self._written]
        return [a if isinstance(a, Unknown) else self._watching(a) for a in actions]

    def _watching(self, action: Action) -> Action:
        """Return an action with the conditions of its step; without steps, with all."""
        is_step = bool(self._context.document.steps)
        watched = self._watched.get(action.name, ()) if is_step else self.conditions
        return action._replace(conditions=watched) if watched else action

    def _action(self, expression: Expression, steps: Steps) -> Outcome[Action]:
        term = expression.terms[0]
        if len(expression.terms) == 1 and self._is_program(term):
            return self._program_action(term, steps)
        composition = self._compositions.composition(expression, steps)
        if isinstance(composition, Unknown):
            return UNKNOWN
        return Action(str(expression), composition)

    def _is_program(self, term: Term) -> bool:
        document = self._context.document
        return term.name in document.use and term.name not in document.controllers

    def _program_action(self, term: Term, steps: Steps) -> Outcome[Action]:
        self._context.used.add(term.name)
        agrees(term, (), self._context.at(steps, term.span), self._context.diagnostics)
        program = self._programs[term.name]
        return UNKNOWN if isinstance(program, Unknown) else Action(term.name, program=program)

    def only_composed(self) -> bool:
        """Report controllers that occur in composed actions only, so that no state shows them."""
        # A state has one letter for each action of a single term. A controller in composed actions
        # alone has none, so that no policy could respond to it.
        lacking = [
            (term, steps)
            for expression, steps in self._written
            for term in expression.terms
            if str(term) not in self.members and self._is_controller(term)
        ]
        for term, steps in lacking:
            self._context.add("CB608", self._context.at(steps, term.span), name=str(term))
        return bool(lacking)

    def _is_controller(self, term: Term) -> bool:
        return not {term.name, str(term)}.isdisjoint(self._context.document.controllers)

    def policy(self) -> dict[str, str]:
        """Return the document's policy: canonical action by state pattern."""
        policy, known, are_complete = {}, self.places, self.are_complete
        for pattern, text in self._context.document.policy.items():
            steps: Steps = ("policy", pattern)
            expression = self._context.parse(text, steps)
            if isinstance(expression, Unknown):
                continue
            # An incomplete list may hold this action in a part with errors. Then only undeclared
            # names are certain mistakes.
            is_known = str(expression) in known
            if not is_known and (are_complete or not self.is_declared(expression)):
                self._lacks(expression, steps)
            policy[pattern] = str(expression)
        return policy

    def _lacks(self, expression: Expression, steps: Steps) -> None:
        """Report an action of the policy that the list of actions lacks."""
        source, name = self._context.source, str(expression)
        names = [str(action) for action, _ in self._written if self._is_possible(action)]
        if not self._is_possible(expression):
            self._context.add("CB613", source.place(*steps), names=names, name=name)
            return
        # The name is valid: propose to add it instead of another name.
        related = [(source.key("actions"), "the actions: add it if it is meant")]
        details = {"given": "", "name": name, "names": names, "related": related}
        self._context.add("CB613", source.place(*steps), **details)
        self.lack_a_member |= len(expression.terms) == 1

    def _is_possible(self, expression: Expression) -> bool:
        """Return whether an action can be meant as written, even if its controllers have errors."""
        terms = expression.terms
        if not self.is_declared(expression) or expression in self._compositions.repetitive:
            return False
        if any(self._is_program(term) for term in terms):
            return len(terms) == 1 and not terms[0].arguments
        taken = self._context.loaded.taken
        are_called = all(str(term) in taken or not term.arguments for term in terms)
        return are_called and len(set(map(str, terms))) == len(terms)

    def is_declared(self, expression: Expression) -> bool:
        """Return whether all names are declared controllers or programs, even with errors."""
        known = (self._context.controllers, self._context.programs)
        return all(
            any(term.name in section or str(term) in section for section in known)
            for term in expression.terms
        )


def _with_steps(
    listed: list[tuple[Expression, Steps]], steps: Sequence[WrittenStep]
) -> list[tuple[Expression, Steps]]:
    """Return the listed actions, then the members of the steps, then their compositions."""
    actions = {str(expression): (expression, path) for expression, path in listed}
    for step in steps:
        for term in step.expression.terms:
            actions.setdefault(str(term), (Expression((term,)), step.path))
    for step in steps:
        actions.setdefault(str(step.expression), (step.expression, step.path))
    return list(actions.values())
