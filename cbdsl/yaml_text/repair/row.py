"""Suggestion of the list that was intended by a value of another form."""

from __future__ import annotations

import re

from cbdsl.types.quantity_problem import quantities_in
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.source_map import SourceMap

_BRACKETS = re.compile(r"[\[({]?(?P<inner>.*?)[\])}]?", re.DOTALL)
_DASH = re.compile(r"(?:^|\s)-\s*(?=[^\W\d])")


def suggested_row(node: Node, source: SourceMap) -> str | None:
    """Return the list, in brackets, that a mapping, a text or a nested list probably represents."""
    value = node.value
    if isinstance(value, list):
        inner = value[0] if len(value) == 1 else None
        is_row = inner is not None and isinstance(inner.value, list) and _is_flat(inner)
        return source.written(inner) if inner is not None and is_row else None
    if isinstance(value, dict):
        return _of_mapping(node, value, source) if _is_flat(node) else None
    return f"[{', '.join(_of_text(str(value)))}]" if value is not None else None


def _is_flat(node: Node) -> bool:
    return not any(isinstance(child.value, (dict, list)) for child in node.children())


def _of_mapping(node: Node, value: dict[str, Node], source: SourceMap) -> str:
    """Return its values, or its keys if these have no values, as in ``{left_arm, right_arm}``."""
    if all(child.value is None for child in value.values()):
        return f"[{', '.join(value)}]"
    return f"[{', '.join(source.written(child) for child in node.children())}]"


def _of_text(text: str) -> list[str]:
    match = _BRACKETS.fullmatch(text.strip())
    inner = match["inner"].strip() if match else text
    # A quantity may contain spaces, as "3 cm 4 cm", so quantities precede words.
    if parts := quantities_in(inner):
        return parts
    if "," in inner:
        return [part.strip() for part in inner.split(",") if part.strip()]
    if _DASH.match(inner):
        return [part.strip() for part in _DASH.split(inner) if part.strip()]
    return [inner] if re.search(r"[^\w\s$]", inner) else inner.split()
