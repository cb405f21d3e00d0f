"""Conditions of signals: three-valued comparisons, evaluated in the compiled tick."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.conditions.predicate import PREDICATES
from cbdsl.numeric.arrays import Integers, Records
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.program.condition import ProgramCondition, SumComparison
from cbdsl.sensing.signal_arrays import TableArrays
from cbdsl.sensing.table.refresh import DEFINED
from cbdsl.types.resource import Resource
from cbdsl.types.state import Predicate

_UNDEFINED, _FALSE, _TRUE = (
    PREDICATES.index(each)
    for each in (Predicate.UNDEFINED, Predicate.TRANSIENT, Predicate.QUIESCENT)
)
_ABOVE, _AT_LEAST, _AND, _OR, _NOT = range(5)
_OPERATORS = {"and": _AND, "or": _OR, "not": _NOT}

#: Condition: its operations, and its value with the ticks for which its comparisons have held.
CONDITION = np.dtype(
    [
        ("first", np.int64),
        ("operations", np.int64),
        ("hold", np.int64),  # ticks for which they have to hold
        ("predicate", np.int64),
        ("ticks", np.int64),
    ]
)
#: Operation: a comparison of a sum of terms and a constant with 0, or an operator.
OPERATION = np.dtype(
    [("kind", np.int64), ("first", np.int64), ("terms", np.int64), ("constant", np.float64)]
)
#: Term: a component of a row of the signal table, with its factor.
TERM = np.dtype([("row", np.int64), ("component", np.int64), ("factor", np.float64)])


class ConditionPlan:
    """Conditions of all programs of a run, in arrays that compiled code shares.

    Attributes:
        conditions, operations, terms: Records, shapes (c,) of ``CONDITION``, (o,) of ``OPERATION``
            and (t,) of ``TERM``.
        watched: Numbers of the conditions of the active steps, ascending.
    """

    def __init__(self) -> None:
        self.conditions: NDArray[Any] = np.zeros(0, CONDITION)
        self.operations: NDArray[Any] = np.zeros(0, OPERATION)
        self.terms: NDArray[Any] = np.zeros(0, TERM)
        self.watched: tuple[int, ...] = ()
        self._rows: list[tuple[int, ...]] = []

    def add(self, condition: ProgramCondition, rows: Mapping[Resource, int], period: float) -> int:
        """Add a condition; return its number.

        Args:
            condition: Condition to add.
            rows: Row of the signal table of each resource.
            period: Period of the ticks, s.
        """
        number, first = len(self.conditions), len(self.operations)
        operations, terms = [], list[tuple[int, int, float]]()
        for part in condition.parts:
            if isinstance(part, SumComparison):
                own = [(rows[c.resource], c.axis, f) for c, f in part.factors.items()]
                kind, place = _ABOVE if part.is_strict else _AT_LEAST, len(self.terms) + len(terms)
                operations.append((kind, place, len(own), part.constant))
                terms += own
            else:
                operations.append((_OPERATORS[part], 0, 0, 0.0))
        hold = max(1, math.ceil(condition.hold / period - 1e-9))
        record = (first, len(operations), hold, _UNDEFINED, 0)
        self.conditions = np.append(self.conditions, np.array([record], CONDITION))
        self.operations = np.append(self.operations, np.array(operations, OPERATION))
        self.terms = np.append(self.terms, np.array(terms, TERM))
        self._rows.append(tuple(rows[each] for each in condition.resources))
        return number

    def watch(self, started: tuple[int, ...], stopped: tuple[int, ...] = ()) -> None:
        """Begin to evaluate conditions, and end the evaluation of others."""
        for number in set(started).difference(self.watched):
            self.conditions[number]["predicate"] = _UNDEFINED
            self.conditions[number]["ticks"] = 0
        numbers = tuple(sorted({*self.watched, *started}.difference(set(stopped) - set(started))))
        # The same object stands for the same conditions, so that a tick compares identities.
        self.watched = self.watched if numbers == self.watched else numbers

    def rows(self) -> list[int]:
        """Return the rows that the watched conditions read."""
        return [row for number in self.watched for row in self._rows[number]]

    def letter(self, number: int) -> str:
        """Return the predicate of a condition."""
        code: int = self.conditions["predicate"].item(number)
        return PREDICATES[code].value


@compiled_once
def note_conditions(
    watched: Integers, conditions: Records, operations: Records, terms: Records, table: TableArrays
) -> None:
    """Evaluate conditions in a tick; each is true once it has held for its time.

    Args:
        watched: Numbers of the conditions.
        conditions, operations, terms: Records of ``ConditionPlan``.
        table: Signal table.
    """
    for number in watched:
        own = conditions[number]
        value = _evaluate(own, operations, terms, table)
        own.ticks = own.ticks + 1 if value == _TRUE else 0
        own.predicate = _FALSE if 0 < own.ticks < own.hold else value


@compiled
def _evaluate(own: Any, operations: Records, terms: Records, table: TableArrays) -> int:
    """Return the value of a condition in this tick, by Kleene's logic of three values."""
    # Values of operands, two bits each, the last one lowest.
    stack = 0
    for i in range(own.first, own.first + own.operations):
        operation = operations[i]
        if operation.kind == _NOT:
            value = stack & 3
            stack >>= 2
            if value != _UNDEFINED:
                value = _FALSE + _TRUE - value
        elif operation.kind == _AND or operation.kind == _OR:
            one, other = stack & 3, (stack >> 2) & 3
            stack >>= 4
            strong = _FALSE if operation.kind == _AND else _TRUE
            if one == strong or other == strong:
                value = strong
            elif one == _UNDEFINED or other == _UNDEFINED:
                value = _UNDEFINED
            else:
                value = one
        else:
            value = _compare(operation, terms, table)
        stack = (stack << 2) | value
    return stack


@compiled
def _compare(operation: Any, terms: Records, table: TableArrays) -> int:
    total = operation.constant
    for i in range(operation.first, operation.first + operation.terms):
        term = terms[i]
        record = table.records[term.row]
        if record.defined != DEFINED:
            return _UNDEFINED
        total += term.factor * table.value[record.start + term.component]
    is_met = total > 0.0 or (total == 0.0 and operation.kind == _AT_LEAST)
    return _TRUE if is_met else _FALSE
