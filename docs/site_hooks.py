"""Hooks of mkdocs: parts of pages that the build writes from the code.

A comment ``<!-- generated: NAME -->`` in a page marks the place of such a part.
"""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

from cbdsl.diagnostics.entry_text import sections
from cbdsl.documents.kinds import entries

_MARK = re.compile(r"^<!-- generated: (\w+) -->$", re.MULTILINE)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the text of a page with its generated parts."""
    return _MARK.sub(lambda mark: _PARTS[mark[1]](), markdown)


def _reference() -> str:
    page: str = runpy.run_path(str(Path(__file__).with_name("make_reference.py")))["page"]()
    return page


def _diagnostics() -> str:
    return sections(sorted(entries().values(), key=lambda entry: entry.code))


_PARTS = {"reference": _reference, "diagnostics": _diagnostics}
