"""Expressions of xacro, interpreted on their syntax tree.

xacro itself passes them to ``eval``, which no list of forbidden names makes safe. Here each node of
the tree is interpreted: numbers, texts, lists, dictionaries, operators, and calls of the documented
functions alone. Lambdas, comprehensions and names that begin with an underscore have no
interpretation. An expression thus reaches only values of the model.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from typing import Any

from cbdsl_formats.budget import StepBudget, require_small
from cbdsl_formats.functions import ModelFunction, Namespace, method

_Operation = Callable[[Any, Any], Any]

_MOST_EXPONENT = 1024


class ExpressionError(ValueError):
    """Expression that is refused, or has no value."""


def evaluate(text: str, names: Mapping[str, Any], budget: StepBudget) -> Any:
    """Return the value of an expression.

    Args:
        text: Expression in Python's notation.
        names: Values of properties and arguments, by name.
        budget: Remaining steps, which this takes from.

    Raises:
        ExpressionError: If the expression is refused, or has no value.
        BudgetError: If the value is too large, or the steps are spent.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        raise ExpressionError(f"invalid syntax: {error}") from None
    return _Interpreter(names, budget).value(tree.body)


def _power(base: Any, exponent: Any) -> Any:
    # Integers have any size in Python, and 9**9**9 would take all memory before its size could be
    # checked. Within these bounds an integer has at most about 65,000 bits; beyond them, a float
    # overflows with an error.
    if abs(exponent) > _MOST_EXPONENT or abs(base) > 2**64:
        return float(base) ** float(exponent)
    return base**exponent


def _product(left: Any, right: Any) -> Any:
    for sequence, count in ((left, right), (right, left)):
        if isinstance(sequence, str | list | tuple):
            require_small(len(sequence) * max(count, 1))
    return left * right


def _remainder(left: Any, right: Any) -> Any:
    if isinstance(left, str):
        raise ExpressionError("'%' formats no text here; use round() and str()")
    return left % right


_BINARY: Mapping[type[ast.operator], _Operation] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: _product,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: _remainder,
    ast.Pow: _power,
}
_UNARY: Mapping[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
}
_COMPARISONS: Mapping[type[ast.cmpop], _Operation] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
}


class _Interpreter:
    """Interpreter of one expression.

    Args:
        names: Values of properties and arguments, by name.
        budget: Remaining steps.
    """

    def __init__(self, names: Mapping[str, Any], budget: StepBudget) -> None:
        self._names, self._budget = names, budget

    def value(self, node: ast.expr) -> Any:
        """Return the value of a node."""
        self._budget.spend(1)
        # This is a list of allowed syntax: a kind of node without a method of its name has no
        # value.
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise ExpressionError(f"{_name(node)} is not allowed in expressions of a model")
        value = method(node)
        self._budget.require_small(value)
        return value

    def _constant(self, node: ast.Constant) -> Any:
        if isinstance(node.value, bool | int | float | str) or node.value is None:
            return node.value
        raise ExpressionError(f"{node.value!r} is not allowed in expressions of a model")

    def _name(self, node: ast.Name) -> Any:
        if node.id.startswith("__"):
            raise ExpressionError(f"'{node.id}' is not allowed: it begins with underscores")
        try:
            return self._names[node.id]
        except KeyError:
            raise ExpressionError(f"name '{node.id}' is not defined") from None

    def _attribute(self, node: ast.Attribute) -> Any:
        if node.attr.startswith("_"):
            raise ExpressionError(f"'{node.attr}' is not allowed: it begins with an underscore")
        owner = self.value(node.value)
        function = method(owner, node.attr)
        if function is not None:
            return function
        if not isinstance(owner, Mapping):
            raise ExpressionError(f"'{node.attr}' of {_kind(owner)} is not allowed")
        try:
            return owner[node.attr]
        except (KeyError, AttributeError):
            raise ExpressionError(f"there is no '{node.attr}' in it") from None

    def _call(self, node: ast.Call) -> Any:
        function = self.value(node.func)
        if not isinstance(function, ModelFunction):
            raise ExpressionError(f"{_kind(function)} is not a function that xacro documents")
        arguments = [self.value(argument) for argument in node.args]
        keywords = {}
        for keyword in node.keywords:
            if keyword.arg is None:
                raise ExpressionError("** is not allowed in expressions of a model")
            keywords[keyword.arg] = self.value(keyword.value)
        return function(*arguments, **keywords)

    def _subscript(self, node: ast.Subscript) -> Any:
        owner = self.value(node.value)
        if not isinstance(owner, str | list | tuple | Mapping) or isinstance(owner, Namespace):
            raise ExpressionError(f"{_kind(owner)} has no parts")
        if isinstance(node.slice, ast.Slice):
            bounds = (node.slice.lower, node.slice.upper, node.slice.step)
            return owner[slice(*(None if each is None else self.value(each) for each in bounds))]
        return owner[self.value(node.slice)]

    def _binop(self, node: ast.BinOp) -> Any:
        operation = _BINARY.get(type(node.op))
        if operation is None:
            raise ExpressionError(f"operator {type(node.op).__name__} is not allowed")
        return operation(self.value(node.left), self.value(node.right))

    def _unaryop(self, node: ast.UnaryOp) -> Any:
        operation = _UNARY.get(type(node.op))
        if operation is None:
            raise ExpressionError(f"operator {type(node.op).__name__} is not allowed")
        return operation(self.value(node.operand))

    def _boolop(self, node: ast.BoolOp) -> Any:
        stops_at = isinstance(node.op, ast.Or)
        result: Any = None
        for operand in node.values:
            result = self.value(operand)
            if bool(result) is stops_at:
                break
        return result

    def _compare(self, node: ast.Compare) -> bool:
        left = self.value(node.left)
        for operation, operand in zip(node.ops, node.comparators, strict=True):
            right = self.value(operand)
            if not _COMPARISONS[type(operation)](left, right):
                return False
            left = right
        return True

    def _ifexp(self, node: ast.IfExp) -> Any:
        return self.value(node.body if self.value(node.test) else node.orelse)

    def _list(self, node: ast.List) -> list[Any]:
        return [self.value(element) for element in node.elts]

    def _tuple(self, node: ast.Tuple) -> tuple[Any, ...]:
        return tuple(self.value(element) for element in node.elts)

    def _dict(self, node: ast.Dict) -> dict[Any, Any]:
        if any(key is None for key in node.keys):
            raise ExpressionError("** is not allowed in expressions of a model")
        pairs = zip(node.keys, node.values, strict=True)
        return {self.value(key): self.value(value) for key, value in pairs if key is not None}


def _name(node: ast.expr) -> str:
    """Return a syntax node's name, for messages."""
    words = {"ListComp": "a comprehension", "GeneratorExp": "a comprehension"}
    words |= {"SetComp": "a comprehension", "DictComp": "a comprehension", "Lambda": "a lambda"}
    return words.get(type(node).__name__, type(node).__name__)


def _kind(value: Any) -> str:
    return f"a {type(value).__name__}"
