"""Addresses of the project, which a release states in its metadata."""

from __future__ import annotations

from functools import cache
from importlib.metadata import metadata


@cache
def published(label: str) -> str | None:
    """Return an address of the project, such as that of its ``Documentation``, if it has one."""
    urls = metadata("cbdsl").get_all("Project-URL") or ()
    return next((url.partition(", ")[2] for url in urls if url.startswith(f"{label}, ")), None)


def page_of(code: str) -> str | None:
    """Return the address of the explanation of a code, unless it is of another distribution."""
    pages = published("Documentation") if code.startswith("CB") else None
    return pages and f"{pages}diagnostics.html#{code.lower()}"
