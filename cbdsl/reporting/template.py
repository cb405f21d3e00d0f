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
    slots: Mapping[str, str],
) -> str:
    """A page from its template; what is put in is not searched for slots.

    Args:
        name: the template, among the assets.
        title: of the page, as text.
        styles, scripts: assets, in their order.
        slots: what else goes in, by name, as HTML.
    """
    content = {
        "title": escape(title),
        "licenses": _asset("vendor/LICENSES.txt"),
        "styles": "\n".join(map(_asset, styles)),
        "scripts": "\n".join(_END_OF_SCRIPT.sub(r"<\\/", _asset(each)) for each in scripts),
        **slots,
    }
    return _SLOT.sub(lambda slot: content[slot[1]], _asset(name))


def _asset(name: str) -> str:
    return files("cbdsl.reporting").joinpath("assets", name).read_text("utf-8")
