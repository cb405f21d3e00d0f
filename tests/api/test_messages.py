"""Messages of the API: they name arguments of Python, and no options of the command line."""

from __future__ import annotations

import ast
import re

import pytest

from tests.conftest import ROOT

FILES = sorted((ROOT / "cbdsl" / "api").glob("*.py"))
_OPTION = re.compile(r"(?<![\w-])--[a-z]")


def literals(source: str) -> list[str]:
    """Return the literals of a module that are no docstrings."""
    tree = ast.parse(source)
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, documented) and node.body and isinstance(node.body[0], ast.Expr)
    }
    return [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and id(node) not in docstrings
    ]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_messages_of_the_api_name_no_option_of_the_command_line(file: object) -> None:
    from pathlib import Path

    texts = literals(Path(str(file)).read_text("utf-8"))
    # Commands of their own, such as ``cb new stage NAME --robot NAME``, may be named whole.
    named = [text for text in texts if _OPTION.search(text) and "cb " not in text]
    assert named == []
