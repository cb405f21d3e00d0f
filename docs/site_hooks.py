"""Hooks of mkdocs: parts of pages that the build writes from the code.

A comment ``<!-- generated: NAME -->`` in a page marks the place of such a part.
"""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

from mkdocs.plugins import event_priority

from cbdsl.diagnostics.entry_text import sections
from cbdsl.diagnostics.published import published
from cbdsl.documents.kinds import entries

_MARK = re.compile(r"^<!-- generated: (\w+) -->$", re.MULTILINE)


@event_priority(100)
def on_config(config: Any) -> Any:
    """Return the configuration with the address in the metadata of the package, before mike's."""
    config.site_url = published("Homepage") or ""
    return config


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the text of a page with its generated parts."""
    return _MARK.sub(lambda mark: _PARTS[mark[1]](), markdown)


def _reference() -> str:
    page: str = runpy.run_path(str(Path(__file__).with_name("make_reference.py")))["page"]()
    return page


def _diagnostics() -> str:
    text = sections(sorted(entries().values(), key=lambda entry: entry.code))
    # An anchor stays when a title changes.
    return re.sub(r"(?m)^(## (\w+): .*)$", lambda head: f"{head[1]} {{#{head[2].lower()}}}", text)


_PARTS = {"reference": _reference, "diagnostics": _diagnostics}
