"""Compositions: from terms to primitives, each one controller or several composed into one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cbdsl.checking.controller.triple import check_triple
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown, all_known
from cbdsl.documents import program as written
from cbdsl.language.expression import Expression, Term
from cbdsl.program.controller import Composition, Controller, Primitive
from cbdsl.yaml_text.shared_parts import agrees

# Bound on nested compositions, below Python's recursion limit.
_DEEPEST = 64


class Compositions:
    """Builder of the primitives of one program, each once.

    Attributes:
        repetitive: Compositions in which a controller occurs twice.
        missing: Names without a declaration.
    """

    def __init__(self, context: ProgramContext) -> None:
        self.repetitive: set[Expression] = set()
        self.missing: set[str] = set()
        self._context = context
        self._built: dict[str, Outcome[tuple[Controller, ...]]] = {}

    def check_all(self) -> None:
        """Check each controller that can be checked by itself, used or not."""
        for key, document in self._context.document.controllers.items():
            if isinstance(document, str):
                self._composite(key, document, ())
            else:
                self._triple(key, document)

    def check_rewards(self) -> None:
        """Check that rewarded parts belong to their composition, and can earn rewards."""
        document, source = self._context.document, self._context.source
        for key, parts in document.rewards.items():
            written = self._context.controllers.get(key)
            # Unreadable compositions, and names that an action lacks, have own diagnostics.
            if isinstance(written, Unknown) or key in self.missing:
                continue
            # A single controller is its own only part, so that naming its parts has no meaning.
            if not isinstance(written, str):
                names = [
                    name for name, each in document.controllers.items() if isinstance(each, str)
                ]
                problem = f"'{key}' is not a composition below 'controllers'"
                place = source.key("rewards", key)
                self._context.add("CB482", place, name=key, names=names, problem=problem)
                continue
            controllers = self._built.get(key)
            if controllers is None or isinstance(controllers, Unknown):
                continue
            self._check_earning(key, parts, {each.name: each.rewarded for each in controllers})

    def _check_earning(self, key: str, parts: Sequence[str], rewarded: Mapping[str, bool]) -> None:
        """Check the parts that a reward depends on; ``rewarded`` ones read the environment."""
        for i, part in enumerate(parts):
            if part not in rewarded:
                self._refuse_part(key, i, part, f"is not a part of '{key}'", list(rewarded))
        if parts and not any(rewarded.get(part, True) for part in parts):
            names = [name for name, is_rewarded in rewarded.items() if is_rewarded]
            self._refuse_part(key, 0, parts[0], "reads no heading and no force", names)

    def _refuse_part(self, key: str, i: int, part: str, why: str, names: Sequence[str]) -> None:
        place = self._context.source.place("rewards", key, i)
        self._context.add("CB482", place, name=part, names=names, problem=f"'{part}' {why}")

    def checked(self) -> list[Controller]:
        """Return the controllers without errors."""
        return [
            controllers[0]
            for name, controllers in self._built.items()
            if not isinstance(controllers, Unknown) and controllers[0].name == name
        ]

    def composition(self, expression: Expression, steps: Steps) -> Outcome[Composition]:
        """Return a composition of primitives; unknown if it has errors."""
        primitives = [self.primitive(term, steps) for term in expression.terms]
        repeats, known = self._repeats(expression, primitives, steps), all_known(primitives)
        return UNKNOWN if repeats or isinstance(known, Unknown) else Composition(tuple(known))

    def primitive(self, term: Term, steps: Steps) -> Outcome[Primitive]:
        """Return the primitive that a term names; unknown if it has errors."""
        controllers = self._controllers(term, steps, ())
        if isinstance(controllers, Unknown):
            return UNKNOWN
        return Primitive(str(term), controllers, self._context.document.rewards.get(term.name, ()))

    def _controllers(
        self, term: Term, steps: Steps, stack: tuple[str, ...]
    ) -> Outcome[tuple[Controller, ...]]:
        document = self._context.controller(term)
        if document is None or isinstance(document, Unknown):
            if document is None:
                self._missing(term, steps)
            return UNKNOWN
        self._context.used.add(term.name)
        # A call of a shared controller is declared by its text; others take no arguments.
        name = str(term) if str(term) in self._context.loaded.taken else term.name
        if name != str(term) and not self._takes_none(term, steps):
            return UNKNOWN
        if isinstance(document, str):
            return self._composite(name, document, stack)
        return self._triple(name, document)

    def _takes_none(self, term: Term, steps: Steps) -> bool:
        """Return whether a term has no arguments, and report them unless it may call a lost one."""
        if self._context.source.broken.is_below(("shared",)):
            return not term.arguments
        return agrees(term, (), self._context.at(steps, term.span), self._context.diagnostics)

    def _triple(
        self, name: str, document: written.ControllerSection
    ) -> Outcome[tuple[Controller, ...]]:
        if name not in self._built:
            controller = self._recalled(name, document) or self._checked(name, document)
            self._built[name] = UNKNOWN if isinstance(controller, Unknown) else (controller,)
        return self._built[name]

    def _recalled(self, name: str, document: written.ControllerSection) -> Controller | None:
        """Return a controller that had no diagnostics when the program was last checked."""
        context = self._context
        return context.sound.recall(name, document, context.body) if context.has_body else None

    def _checked(self, name: str, document: written.ControllerSection) -> Outcome[Controller]:
        context = self._context
        before = context.diagnostics.added
        controller = check_triple(context, name, document)
        is_clean = context.diagnostics.added == before and not context.loaded.diagnostics
        if not isinstance(controller, Unknown) and is_clean:
            context.sound.remember(name, document, context.body, controller)
        return controller

    def _composite(
        self, key: str, text: str, stack: tuple[str, ...]
    ) -> Outcome[tuple[Controller, ...]]:
        # With ``a: b ◁ c`` and ``b: a``, a composition contains itself and cannot be flattened.
        if key in stack:
            cycle = " ◁ ".join((*stack[stack.index(key) :], key))
            place = self._context.source.key("controllers", key)
            self._context.add("CB405", place, name=key, cycle=cycle.replace("◁", "→"))
            return UNKNOWN
        if len(stack) == _DEEPEST:
            place = self._context.source.key("controllers", key)
            self._context.add("CB119", place, bound=_DEEPEST)
            return UNKNOWN
        if key not in self._built:
            self._built[key] = self._flatten(key, text, (*stack, key))
        return self._built[key]

    def _flatten(
        self, key: str, text: str, stack: tuple[str, ...]
    ) -> Outcome[tuple[Controller, ...]]:
        steps: Steps = ("controllers", key)
        expression = self._context.parse(text, steps)
        if isinstance(expression, Unknown):
            return UNKNOWN
        parts = [self._controllers(term, steps, stack) for term in expression.terms]
        primitives = [
            UNKNOWN if isinstance(part, Unknown) else Primitive("", part) for part in parts
        ]
        # Without this check, a few lines of repetitions could stand for billions of controllers.
        if self._repeats(expression, primitives, steps):
            return UNKNOWN
        known = all_known(parts)
        if isinstance(known, Unknown):
            return UNKNOWN
        return tuple(controller for part in known for controller in part)

    def _repeats(
        self, expression: Expression, primitives: Sequence[Outcome[Primitive]], steps: Steps
    ) -> bool:
        """Report controllers that occur twice, and return whether there are any."""
        seen: dict[str, Term] = {}
        repeats = False
        for term, primitive in zip(expression.terms, primitives, strict=True):
            for controller in () if isinstance(primitive, Unknown) else primitive.controllers:
                if controller.name in seen:
                    self._repeat(controller.name, (seen[controller.name], term), steps)
                    self.repetitive.add(expression)
                    repeats = True
                seen[controller.name] = term
        return repeats

    def _repeat(self, name: str, terms: tuple[Term, Term], steps: Steps) -> None:
        """Report a controller that two terms contain."""
        source = self._context.source
        held = {term.name: source.place("controllers", term.name) for term in terms}
        related = [(at, f"'{key}' holds it") for key, at in held.items() if key not in name]
        place = self._context.at(steps, terms[1].span)
        self._context.add("CB407", place, related=related, name=name)

    def _missing(self, term: Term, steps: Steps) -> None:
        """Report a term without a controller of its name, unless its declaration may be lost."""
        document, place = self._context.document, self._context.at(steps, term.span)
        if self._context.source.broken.is_below(("shared",)):
            return
        if term.name in document.use:
            self._context.used.add(term.name)
            self._context.add("CB406", place, name=term.name)
        elif term.name not in self._context.programs and not self._was_overwritten():
            names = [*document.controllers, *document.use]
            self.missing.add(term.name)
            self._context.add("CB404", place, names=names, name=term.name)

    def _was_overwritten(self) -> bool:
        """Return whether a controller or program is declared twice, maybe instead of another."""
        source, faults = self._context.source, self._context.loaded.diagnostics
        left_out = set(source.broken.keys(("controllers", "use")))
        return any(fault.code == "CB107" and fault.given in left_out for fault in faults)
