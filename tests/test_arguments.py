"""Numbers of positional arguments: few, except at the call boundary of compiled code."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MOST = 8

#: Decorator of compiled functions that Python calls, with each array as an argument of its own.
BOUNDARY = "compiled_once"


def crowded(source: str) -> Iterator[str]:
    """Yield the names of functions with too many positional arguments."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef):
            taken = [each.arg for each in (*node.args.posonlyargs, *node.args.args)]
            count = len(taken) - (taken[:1] in (["self"], ["cls"]))
            decorators = {ast.unparse(each) for each in node.decorator_list}
            if count > MOST and BOUNDARY not in decorators:
                yield node.name


@pytest.mark.parametrize("package", ["cbdsl", "distributions", "reproduction/cbdsl_reproduction"])
def test_functions_take_few_positional_arguments_except_at_the_call_boundary(package: str) -> None:
    found = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in (ROOT / package).rglob("*.py")
        for name in crowded(path.read_text("utf-8"))
    }
    assert found == set()


@pytest.mark.parametrize(("form", "expected"), [
    ("def f({}): pass", ["f"]), ("@compiled\ndef f({}): pass", ["f"]),
    ("@compiled_once\ndef f({}): pass", []), ("def f(a, *, {}): pass", []),
    ("class C:\n    def f(self, {}): pass", ["f"]),
])  # fmt: skip
def test_crowded_counts_positional_arguments_of_functions_and_methods(
    form: str, expected: list[str]
) -> None:
    nine = ", ".join(f"x{number}" for number in range(9))
    eight = ", ".join(f"x{number}" for number in range(8))
    assert list(crowded(form.format(nine))) == expected
    assert list(crowded(form.format(eight))) == []
