"""Outcomes of look-ups: values, and the unknown one."""

from __future__ import annotations

import ast
from pathlib import Path

from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, all_known

_CHECKING = Path(__file__).parents[2] / "cbdsl" / "checking"


def test_unknown_differs_from_the_same_text() -> None:
    assert (UNKNOWN != "unknown") and not (UNKNOWN == "unknown")  # noqa: SIM201
    assert UNKNOWN not in {"unknown": 1} and UNKNOWN in (UNKNOWN, "unknown")


def test_all_known_with_values_returns_them_in_order() -> None:
    assert all_known([3, 1, 2]) == [3, 1, 2] and all_known([]) == []


def test_all_known_with_an_unknown_value_is_unknown() -> None:
    outcomes: list[Outcome[int]] = [1, UNKNOWN, 2]
    assert all_known(outcomes) is UNKNOWN


def _reports(function: ast.FunctionDef) -> bool:
    """Return whether a function adds a diagnostic."""
    calls = (node.func for node in ast.walk(function) if isinstance(node, ast.Call))
    names = (call.attr for call in calls if isinstance(call, ast.Attribute))
    return not {"add", "_add", "extend", "_problem"}.isdisjoint(names)


def test_checking_functions_that_report_and_return_a_value_return_an_outcome() -> None:
    """``None`` as a result would not say whether a value is absent or unknown."""
    ambiguous = []
    for file in sorted(_CHECKING.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if not isinstance(node, ast.FunctionDef) or node.returns is None:
                continue
            result = ast.unparse(node.returns)
            if result.endswith("| None") and _reports(node):
                ambiguous.append(f"{file.name}:{node.lineno} {node.name} -> {result}")
    assert ambiguous == []
