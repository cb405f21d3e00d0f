"""What a value should look like, for whoever wrote it otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel

from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.source_map import Step

# What is further inside is left to the imagination.
_DEPTH = 3
# Of keys without which a section does, some give an idea.
_MOST_KEYS = 3


def form(model: type[BaseModel], steps: tuple[Step, ...], found: Node | None = None) -> str | None:
    """How a mapping or a list at a path is written, as in ``{link: ...}``.

    Args:
        model: the kind of document.
        steps: the path.
        found: what is written there, if it may have been meant to be a part of that.

    Returns:
        ``None`` where neither a mapping nor a list may be.
    """
    wanted = [known for known in annotations_at(model, steps) if _is_collection(known)]
    return _sketch(wanted[0], _DEPTH, found) if wanted else None


def annotations_at(model: type[BaseModel], steps: tuple[Step, ...]) -> list[Any]:
    """What may be at a path: several where there is a choice."""
    found: list[Any] = [model]
    for step in steps:
        found = [inner for outer in found for inner in _inside(outer, step)]
    return found


def section_of(annotation: Any) -> type[BaseModel] | None:
    """The section that a mapping by names has under each, if it is one."""
    if get_origin(annotation) is not dict:
        return None
    (inner, *_) = (*_choices(get_args(annotation)[1]), None)
    return inner if isinstance(inner, type) and issubclass(inner, BaseModel) else None


def _inside(annotation: Any, step: Step) -> Iterator[Any]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        for name, field in annotation.model_fields.items():
            if step in (name, field.alias):
                yield from _choices(field.annotation)
    elif get_origin(annotation) is dict:
        yield from _choices(get_args(annotation)[1])
    elif get_origin(annotation) is tuple and isinstance(step, int):
        parts = [part for part in get_args(annotation) if part is not Ellipsis]
        yield from _choices(parts[min(step, len(parts) - 1)])


def _choices(annotation: Any) -> Iterator[Any]:
    """The parts of a union, without what is said of their values."""
    if get_origin(annotation) is Annotated:
        yield from _choices(get_args(annotation)[0])
    elif get_origin(annotation) in (Union, UnionType):
        for part in get_args(annotation):
            yield from _choices(part)
    elif annotation is not type(None):
        yield annotation


def _is_collection(annotation: Any) -> bool:
    is_section = isinstance(annotation, type) and issubclass(annotation, BaseModel)
    return is_section or get_origin(annotation) in (dict, tuple)


def _sketch(annotation: Any, depth: int, found: Node | None = None) -> str:
    if depth == 0 or not _is_collection(annotation):
        return "..."
    if get_origin(annotation) is tuple:
        return _sketch_of_list(annotation, depth, found)
    if get_origin(annotation) is dict:
        key, value = get_args(annotation)
        (inner, *_) = _choices(value)
        return f"{{{'KEY' if key is str else 'NAME'}: {_sketch(inner, depth - 1, found)}}}"
    return _sketch_of_section(annotation, depth, found)


def _sketch_of_list(annotation: Any, depth: int, found: Node | None) -> str:
    parts = get_args(annotation)
    if Ellipsis not in parts:
        return f"[{', '.join('...' for _ in parts)}]"
    (inner, *_) = _choices(parts[0])
    if _is_collection(inner):
        return f"[{_sketch(inner, depth - 1, found)}{'' if found else ', ...'}]"
    if found is None or isinstance(found.value, dict):
        return "[...]"
    return _written(found) if isinstance(found.value, list) else f"[{_written(found)}]"


def _sketch_of_section(section: type[BaseModel], depth: int, found: Node | None) -> str:
    fields = {field.alias or name: field for name, field in section.model_fields.items()}
    keys = [key for key, field in fields.items() if field.is_required()]
    keys = keys or list(fields)[:_MOST_KEYS]
    parts = []
    for key in keys:
        (inner, *_) = _choices(fields[key].annotation)
        meant = found if len(keys) == 1 and _suits(inner, found) else None
        text = _written(meant) if meant and inner is str else _sketch(inner, depth - 1, meant)
        parts.append(f"{key}: {text}")
    return f"{{{', '.join(parts)}}}"


def _suits(annotation: Any, found: Node | None) -> bool:
    """Whether what was written may have been meant for a part of a section."""
    if found is None or isinstance(found.value, dict):
        return False
    if isinstance(found.value, list):
        return get_origin(annotation) is tuple
    return annotation is str and isinstance(found.value, str)


def _written(found: Node) -> str:
    """A value of one line, as it was written."""
    if isinstance(found.value, list):
        return f"[{', '.join(_written(item) for item in found.value)}]"
    return "..." if isinstance(found.value, dict) else str(found.value)
