"""Pages: single HTML files that contain all their assets and load no others."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

_SLOT = re.compile(r"\{\{(\w+)\}\}")
# Would end a script that contains it, regardless of its meaning there.
_END_OF_SCRIPT = re.compile(r"</(?=script)", re.IGNORECASE)


def filled(
    name: str | Path,
    title: str,
    styles: Sequence[str | Path],
    scripts: Sequence[str | Path],
    data: str,
    slots: Mapping[str, str],
    *,
    connects: bool = False,
) -> str:
    """Return a page from its template in the frame of all pages.

    Inserted texts are not searched for slots.

    Args:
        name: Template of its body, among the assets, or a file of another package.
        title: Title of the page, as text.
        styles: Style sheets likewise, in order.
        scripts: Scripts likewise, in order.
        data: Data that the scripts show.
        slots: Content of the body's slots, by name, as HTML.
        connects: True if the page may connect to its own server, and to no other.
    """
    frame = {
        "title": escape(title),
        "licenses": _asset("vendor/LICENSES.txt"),
        "styles": "\n".join(map(_asset, styles)),
        # In a string of JavaScript, `<\/` is the same as `</`.
        "scripts": "\n".join(_END_OF_SCRIPT.sub(r"<\\/", _asset(each)) for each in scripts),
        "body": _fill(name, slots),
        "data": data,
        "connections": "; connect-src 'self'" if connects else "",
    }
    return _fill("page.html", frame)


def _fill(name: str | Path, slots: Mapping[str, str]) -> str:
    return _SLOT.sub(lambda slot: slots[slot[1]], _asset(name))


def _asset(name: str | Path) -> str:
    if isinstance(name, Path):
        return name.read_text("utf-8")
    return files("cbdsl.reporting").joinpath("assets", name).read_text("utf-8")
