"""Pages: one HTML file with everything in it, which loads nothing."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files

_SLOT = re.compile(r"\{\{(\w+)\}\}")
# Would end a script that it is a part of, whatever it means there.
_END_OF_SCRIPT = re.compile(r"</(?=script)", re.IGNORECASE)


def filled(
    name: str,
    title: str,
    styles: Sequence[str],
    scripts: Sequence[str],
    data: str,
    slots: Mapping[str, str],
    *,
    connects: bool = False,
) -> str:
    """A page from its template in the frame of all pages; what is put in is not searched for slots.

    Args:
        name: the template of its body, among the assets.
        title: of the page, as text.
        styles, scripts: assets, in their order.
        data: what the scripts show.
        slots: what goes into the body, by name, as HTML.
        connects: whether the page may talk to the server that it comes from, and to no other.
    """
    frame = {
        "title": escape(title),
        "licenses": _asset("vendor/LICENSES.txt"),
        "styles": "\n".join(map(_asset, styles)),
        "scripts": "\n".join(_END_OF_SCRIPT.sub(r"<\\/", _asset(each)) for each in scripts),
        "body": _fill(name, slots),
        "data": data,
        "connections": "; connect-src 'self'" if connects else "",
    }
    return _fill("page.html", frame)


def _fill(name: str, slots: Mapping[str, str]) -> str:
    return _SLOT.sub(lambda slot: slots[slot[1]], _asset(name))


def _asset(name: str) -> str:
    return files("cbdsl.reporting").joinpath("assets", name).read_text("utf-8")
