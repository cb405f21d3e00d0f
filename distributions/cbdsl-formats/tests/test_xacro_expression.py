"""Expressions of xacro: the documented ones have the library's values, others are refused."""

from __future__ import annotations

import pytest
import xacro
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_formats.budget import BudgetError, StepBudget
from cbdsl_formats.functions import functions
from cbdsl_formats.xacro_expression import ExpressionError, evaluate

NAMES = {"length": 0.4, "side": "left", "flag": True, "limits": {"elbow": {"lower": -1.5}}}


def value(text: str) -> object:
    return evaluate(text, {**functions({}), **NAMES}, StepBudget())


@pytest.mark.parametrize(
    "text",
    [
        "2*length + 0.1",
        "-length if side == 'left' else length",
        "pi/2",
        "math.pi/2",
        "radians(90)",
        "sin(0.3)**2 + cos(0.3)**2",
        "round(1/3, 4)",
        "[1, 2, 3][1]",
        "list(map(float, '1 2 3'.split()))",
        "dict(a=1)['a']",
        "{'a': 1}['a']",
        "max(1, 2, length)",
        "python.sum([1, 2])",
        "side + '_arm'",
        "not flag or length > 1",
        "'ef' in side",
        "side.upper()",
        "'a,b'.split(',')",
        "1 < 2 <= 2",
        "7 // 2 + 7 % 2",
        "side[0:2]",
        "len(side) == 4 and flag",
        "xacro.tokenize('1 2,3')",
        "list(range(3))",
    ],
)
def test_evaluate_documented_expression_returns_value_of_the_library(text: str) -> None:
    expected = xacro.safe_eval(text, {**xacro._global_symbols, **NAMES})
    assert value(text) == expected


def test_evaluate_dotted_yaml_returns_entry() -> None:
    assert value("limits.elbow.lower") == -1.5


@pytest.mark.parametrize(
    "text",
    [
        "(lambda: 1)()",
        "[x for x in (1, 2)]",
        "{x for x in (1, 2)}",
        "(x for x in (1, 2))",
        "length.__class__",
        "length._x",
        "__import__('os')",
        "__builtins__",
        "'{0.__class__}'.format(1)",
        "'%s' % side",
        "f'{length}'",
        "(y := 1)",
        "math.__loader__",
        "map.__globals__",
        "map._call",
        "side.encode()",
        "side.format",
        "getattr(side, 'upper')",
        "eval('1')",
        "open('/etc/passwd')",
        "python.type(side)",
        "python.vars(side)",
        "python['map']",
        "list(*[1])",
        "dict(**limits)",
        "await_(1)",
        "1j",
        "b'x'",
        "...",
        "(1)()",
        "1 @ 2",
        "1 << 900",
        "math.factorial(9)",
    ],
)
def test_evaluate_anything_else_is_refused(text: str) -> None:
    with pytest.raises(ExpressionError):
        value(text)


@pytest.mark.parametrize(
    "text",
    [
        "'x' * 10**9",
        "[0] * 10**9",
        "10**900 * 10**900 * 10**900 * 10**900",
        "list(range(10**9))",
        "range(10**12)",
        "'x'.join(range(10**9))",
        "'aaaaaaaaaa'.replace('', 'x' * 9000)",
        "[[[[0] * 100] * 100] * 100] * 100",
    ],
)
def test_evaluate_large_value_is_refused_before_it_is_made(text: str) -> None:
    with pytest.raises((BudgetError, TypeError)):
        value(text)


def test_evaluate_large_power_is_a_float_or_an_error() -> None:
    assert value("2.0 ** 10") == 1024
    with pytest.raises((OverflowError, BudgetError)):
        value("9 ** 9 ** 9")


@given(st.text(alphabet="()[]{}.,_:+-*/% '\"abmx01lenstr=<>", max_size=40))
def test_evaluate_any_text_returns_plain_value_or_raises(text: str) -> None:
    try:
        result = value(text)
    except Exception:
        return
    assert result is None or not hasattr(result, "__globals__")
