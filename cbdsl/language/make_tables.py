"""Rewrites ``tables.py`` from ``composition.lark``: ``python -m cbdsl.language.make_tables``.

To build the parser's tables takes lark thirty times as long as to load them.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from pprint import pformat

import lark
from lark.grammar import Rule
from lark.lexer import TerminalDef

HERE = Path(__file__).parent


def grammar_digest() -> str:
    """What tells one grammar's tables from another's; lark numbers its states as chance has it."""
    return sha256((HERE / "composition.lark").read_bytes()).hexdigest()


def tables_source() -> str:
    """The text of ``tables.py``."""
    grammar = (HERE / "composition.lark").read_text("utf-8")
    parser = lark.Lark(grammar, parser="lalr", start="expression")
    data, memo = parser.memo_serialize([TerminalDef, Rule])
    tables = pformat({"data": data, "memo": memo}, width=98, compact=True)
    return (
        '"""The parser of compositions as lark built it; written by make_tables.py."""\n\n'
        "from typing import Any\n\n"
        "#: The version of lark whose tables these are; others may not read them.\n"
        f'LARK = "{lark.__version__}"\n'
        "#: SHA-256 of the grammar whose tables these are.\n"
        f'GRAMMAR = "{grammar_digest()}"\n\n'
        f"TABLES: dict[str, Any] = {tables}\n"
    )


if __name__ == "__main__":
    (HERE / "tables.py").write_text(tables_source(), "utf-8")
