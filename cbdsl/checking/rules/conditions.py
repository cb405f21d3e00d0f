"""Conditions of a program: from comparisons as written to typed ones, in SI."""

from __future__ import annotations

from typing import Any, NamedTuple

from cbdsl.checking.controller.axes import SPATIAL
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown, all_known
from cbdsl.language.scanner import CompositionError
from cbdsl.language.written_condition import (
    WrittenComparison,
    WrittenCondition,
    WrittenValue,
    parse_condition,
)
from cbdsl.program.condition import Component, ProgramCondition, SumComparison
from cbdsl.types.resource import Resource
from cbdsl.types.unit import QuantityError, dimensions_of, is_quantity, read_quantity

# Types whose components have the names of axes.
_WITH_AXES = (*SPATIAL, "velocity")
_AXES = "xyz"


def check_conditions(context: ProgramContext) -> dict[str, Outcome[ProgramCondition]]:
    """Return the conditions of a program by name; those with errors are unknown."""
    if not context.has_body:
        return dict.fromkeys(context.document.conditions, UNKNOWN)
    return {
        name: _ConditionCheck(context, name, text).check()
        for name, text in context.document.conditions.items()
    }


class _Known(NamedTuple):
    """Value of a sum: a component of a signal, or a quantity as text."""

    component: Component | None
    text: str
    factor: float
    value: WrittenValue

    @property
    def unit(self) -> str:
        assert self.component is not None, "a quantity has no unit of its own here"
        return self.component.resource.type.units[self.component.axis]


class _ConditionCheck:
    def __init__(self, context: ProgramContext, name: str, text: str) -> None:
        self._context, self._name, self._text = context, name, text
        self._path: Steps = ("conditions", name)

    def check(self) -> Outcome[ProgramCondition]:
        """Return the condition; unknown if it has errors, which are reported."""
        try:
            written = parse_condition(self._text)
        except CompositionError as error:
            place = self._context.at(self._path, error.span)
            self._context.add("CB657", place, problem=str(error))
            return UNKNOWN
        if self._name in {**self._context.document.controllers, **self._context.document.use}:
            place = self._context.source.key(*self._path)
            self._context.add("CB659", place, name=self._name)
        checked: list[Outcome[SumComparison | str]] = [self._part(part) for part in written.parts]
        parts: Outcome[list[SumComparison | str]] = all_known(checked)
        hold = self._hold(written)
        if isinstance(parts, Unknown) or isinstance(hold, Unknown):
            return UNKNOWN
        condition = ProgramCondition(self._name, self._shown(), tuple(parts), hold)
        constant = condition.constant()
        if constant is not None:
            value = "true" if constant else "false"
            details = {"name": self._name, "value": value}
            self._context.add("CB730", self._context.source.place(*self._path), **details)
        return condition

    def _shown(self) -> str:
        text = self._context.substitute(self._text, self._path)
        return self._text if isinstance(text, Unknown) else text

    def _hold(self, written: WrittenCondition) -> Outcome[float]:
        if written.hold is None:
            return 0.0
        text = self._substituted(written.hold)
        return UNKNOWN if isinstance(text, Unknown) else self._quantity(written.hold, text, "s")

    def _part(self, part: WrittenComparison | str) -> Outcome[SumComparison | str]:
        if isinstance(part, str):
            return part
        known = all_known([self._value(value) for value in part.values])
        if isinstance(known, Unknown):
            return UNKNOWN
        signals = [each for each in known if each.component is not None]
        if not signals:
            self._add("CB658", part, problem="it compares constants, and no signal")
            return UNKNOWN
        unit, first = signals[0].unit, signals[0].text
        for other in signals[1:]:
            if other.unit != unit:
                kinds = [
                    f"'{each.text}' is a {_kind(each)} in {each.unit or 'numbers'}"
                    for each in (signals[0], other)
                ]
                self._add("CB658", other.value, problem=", and ".join(kinds))
                return UNKNOWN
        factors: dict[Component, float] = {}
        constants = []
        for each in known:
            if each.component is not None:
                factors[each.component] = factors.get(each.component, 0.0) + each.factor
                continue
            number = self._quantity(each.value, each.text, unit, f" for '{first}'")
            constants.append(number if isinstance(number, Unknown) else each.factor * number)
        sums = all_known(constants)
        return UNKNOWN if isinstance(sums, Unknown) else SumComparison(
            factors, sum(sums), part.is_strict
        )  # fmt: skip

    def _quantity(
        self, value: WrittenValue, text: str, unit: str, where: str = ""
    ) -> Outcome[float]:
        try:
            return read_quantity(text, dimensions_of(unit))
        except QuantityError as error:
            self._add("CB658", value, problem=f"{error}{where}")
            return UNKNOWN

    def _substituted(self, value: WrittenValue) -> Outcome[str]:
        return self._context.substitute(value.text, self._path, value.span.start - 1)

    def _value(self, value: WrittenValue) -> Outcome[_Known]:
        text = self._substituted(value)
        if isinstance(text, Unknown):
            return UNKNOWN
        if is_quantity(text):
            return _Known(None, text, value.factor, value)
        component = self._component(value, text)
        if isinstance(component, Unknown):
            return UNKNOWN
        return _Known(component, text, value.factor, value)

    def _component(self, value: WrittenValue, text: str) -> Outcome[Component]:
        base, _, axis = value.text.rpartition(".")
        has_axis = bool(base) and axis in tuple(_AXES) and text not in self._context.body.resources
        resource = self._context.resource(base if has_axis else value.text, self._path)
        if isinstance(resource, Unknown):
            return UNKNOWN
        problem = _problem(resource, axis if has_axis else "")
        if problem:
            self._add("CB658", value, problem=problem)
            return UNKNOWN
        return Component(resource, _AXES.index(axis) if has_axis else 0)

    def _add(self, code: str, at: WrittenValue | WrittenComparison, **details: Any) -> None:
        self._context.add(code, self._context.at(self._path, at.span), **details)


def _kind(known: _Known) -> str:
    assert known.component is not None
    return str(known.component.resource.type)


def _problem(resource: Resource, axis: str) -> str:
    """Return why a resource, or its component along an axis, is no number; empty if it is one."""
    kind, name = resource.type, resource.name
    if resource.is_drawn:
        return f"'{name}' is random"
    has_axes = kind.name in _WITH_AXES and kind.factors == 1
    if axis:
        return "" if has_axes else f"'{name}' is a {kind}, which has no component along {axis}"
    if kind.size == 1:
        return ""
    if has_axes:
        return f"'{name}' is a {kind}; compare a component, as '{name}.z'"
    return f"'{name}' is a {kind} with {kind.size} components, of which none has a name"
