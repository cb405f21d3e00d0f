"""Sketches of the expected form of a value, for messages."""

from __future__ import annotations

from typing import Any, get_args, get_origin

from pydantic import BaseModel

from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.schema_shape import (
    SchemaShape,
    fields_of,
    is_section,
    required_keys,
    shape_of,
)
from cbdsl.yaml_text.source_map import Step

# Deeper levels are abbreviated.
_DEPTH = 3
# A section without required keys is sketched by its first optional keys.
_MOST_KEYS = 3


def form(model: type[BaseModel], steps: tuple[Step, ...], node: Node | None = None) -> str | None:
    """Sketch the form of a mapping or a list at a path, as in ``{link: ...}``.

    Args:
        model: Model of the kind of document.
        steps: Path of the value.
        node: Value written there, if it may be intended as a part of the mapping or list.

    Returns:
        Sketch, or ``None`` if neither a mapping nor a list is allowed there.
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
    """Return whether a written value may be intended as a part of a section."""
    if node is None or isinstance(node.value, dict):
        return False
    if isinstance(node.value, list):
        return get_origin(kind) is tuple
    return kind is str and isinstance(node.value, str)


def _written(node: Node) -> str:
    """Return a value in one line, as written."""
    if isinstance(node.value, list):
        return f"[{', '.join(_written(item) for item in node.value)}]"
    return "..." if isinstance(node.value, dict) else str(node.value)
