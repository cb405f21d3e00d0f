"""Forms of values, for whoever wrote one otherwise."""

from __future__ import annotations

from typing import Any, get_args, get_origin

from pydantic import BaseModel

from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.shape import SchemaShape, fields_of, is_section, required_keys, shape_of
from cbdsl.yaml_text.source_map import Step

# What is further inside is left to the imagination.
_DEPTH = 3
# Of keys without which a section does, some give an idea.
_MOST_KEYS = 3


def form(model: type[BaseModel], steps: tuple[Step, ...], node: Node | None = None) -> str | None:
    """How a mapping or a list at a path is written, as in ``{link: ...}``.

    Args:
        model: the kind of document.
        steps: the path.
        node: what is written there, if it may have been meant to be a part of that.

    Returns:
        ``None`` where neither a mapping nor a list may be.
    """
    wanted = [kind for kind in SchemaShape((model,)).at(steps).kinds if _is_collection(kind)]
    return _sketch(wanted[0], _DEPTH, node) if wanted else None


def _is_collection(kind: Any) -> bool:
    return is_section(kind) or get_origin(kind) in (dict, tuple)


def _sketch(kind: Any, depth: int, node: Node | None = None) -> str:
    if depth == 0 or not _is_collection(kind):
        return "..."
    if is_section(kind):
        return _sketch_of_section(kind, depth, node)
    if get_origin(kind) is tuple:
        return _sketch_of_list(kind, depth, node)
    key, value = get_args(kind)
    inner = shape_of(value).kinds[0]
    return f"{{{'KEY' if key is str else 'NAME'}: {_sketch(inner, depth - 1, node)}}}"


def _sketch_of_list(kind: Any, depth: int, node: Node | None) -> str:
    parts = get_args(kind)
    if Ellipsis not in parts:
        return f"[{', '.join('...' for _ in parts)}]"
    inner = shape_of(parts[0]).kinds[0]
    if _is_collection(inner):
        return f"[{_sketch(inner, depth - 1, node)}{'' if node else ', ...'}]"
    if node is None or isinstance(node.value, dict):
        return "[...]"
    return _written(node) if isinstance(node.value, list) else f"[{_written(node)}]"


def _sketch_of_section(section: type[BaseModel], depth: int, node: Node | None) -> str:
    fields, required = fields_of(section), required_keys(section)
    keys = [key for key in fields if key in required] or list(fields)[:_MOST_KEYS]
    parts = []
    for key in keys:
        inner = shape_of(fields[key].annotation).kinds[0]
        suggestion = node if len(keys) == 1 and _suits(inner, node) else None
        text = (
            _written(suggestion)
            if suggestion and inner is str
            else _sketch(inner, depth - 1, suggestion)
        )
        parts.append(f"{key}: {text}")
    return f"{{{', '.join(parts)}}}"


def _suits(kind: Any, node: Node | None) -> bool:
    """Whether what was written may have been meant for a part of a section."""
    if node is None or isinstance(node.value, dict):
        return False
    if isinstance(node.value, list):
        return get_origin(kind) is tuple
    return kind is str and isinstance(node.value, str)


def _written(node: Node) -> str:
    """A value of one line, as it was written."""
    if isinstance(node.value, list):
        return f"[{', '.join(_written(item) for item in node.value)}]"
    return "..." if isinstance(node.value, dict) else str(node.value)
