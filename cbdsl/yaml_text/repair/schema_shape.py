"""Shapes that the models of documents expect at a place: sections with keys, names, or lists."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache, reduce
from types import UnionType
from typing import Annotated, Any, NamedTuple, TypeGuard, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from cbdsl.documents.document import Section
from cbdsl.yaml_text.source_map import Step


class SchemaShape(NamedTuple):
    """Shape of a value.

    Attributes:
        kinds: Types that the value may have, except ``None``.
    """

    kinds: tuple[Any, ...] = ()

    @property
    def sections(self) -> tuple[type[Section], ...]:
        """Types of sections that the value may be."""
        return tuple(kind for kind in self.kinds if is_section(kind))

    @property
    def keys(self) -> Mapping[str, FieldInfo]:
        """Fields by key of all sections that the value may be."""
        return _fields(self.sections)

    @property
    def renamed(self) -> Mapping[str, str]:
        """New names of keys by the names in older documents."""
        return {old: new for section in self.sections for old, new in section.renamed.items()}

    @property
    def moved(self) -> Mapping[str, str]:
        """Advice for keys of older documents, by key."""
        return {key: advice for section in self.sections for key, advice in section.moved.items()}

    @property
    def is_of_names(self) -> bool:
        """True if the keys are names that the document defines."""
        return any(get_origin(kind) is dict for kind in self.kinds)

    def child(self, step: Step) -> SchemaShape:
        """Return the shape of a value or an item inside the value."""
        return SchemaShape(tuple(kind for outer in self.kinds for kind in _kinds_in(outer, step)))

    def at(self, steps: Iterable[Step]) -> SchemaShape:
        """Return the shape at a path below the value."""
        return reduce(SchemaShape.child, steps, self)

    def located(self, loc: Iterable[Step]) -> SchemaShape:
        """Return the shape at a ``loc`` of pydantic, which also names chosen members of unions."""
        shape = self
        for step in loc:
            # A step that leads nowhere is not a key of the text but the tag of a chosen member.
            inner = shape.child(step)
            shape = inner if inner.kinds else shape._tagged(step)
        return shape

    def is_complete(self, keys: set[str]) -> bool:
        """Return whether these keys include all required keys of one of the sections."""
        return any(required_keys(section) <= keys for section in self.sections)

    def _tagged(self, tag: Step) -> SchemaShape:
        """Return the shape of the sections with a tag, or of all kinds if no section has it."""
        return SchemaShape(
            tuple(known for known in self.sections if _carries(known, tag)) or self.kinds
        )


def shape_of(annotation: Any) -> SchemaShape:
    """Return the shape of the annotation of a model's field."""
    return SchemaShape(tuple(_kinds(annotation)))


def is_section(kind: Any) -> TypeGuard[type[Section]]:
    """Return whether values of a type are mappings with fixed keys."""
    return isinstance(kind, type) and issubclass(kind, Section)


@cache
def fields_of(section: type[Section]) -> Mapping[str, FieldInfo]:
    """Return the fields of a section by their keys in documents."""
    return {field.alias or name: field for name, field in section.model_fields.items()}


@cache
def required_keys(section: type[Section]) -> frozenset[str]:
    """Return the required keys of a section."""
    return frozenset(key for key, field in fields_of(section).items() if field.is_required())


@cache
def _fields(sections: tuple[type[Section], ...]) -> Mapping[str, FieldInfo]:
    return {key: field for section in sections for key, field in fields_of(section).items()}


def _kinds(annotation: Any) -> Iterator[Any]:
    """Yield the members of a union, without their annotations."""
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from _kinds(get_args(annotation)[0])
    elif origin in (Union, UnionType):
        for part in get_args(annotation):
            yield from _kinds(part)
    elif annotation is not type(None):
        yield annotation


def _kinds_in(kind: Any, step: Step) -> Iterator[Any]:
    """Yield the types of a value or an item inside a value of a type."""
    if is_section(kind):
        field = fields_of(kind).get(str(step))
        if field is not None:
            yield from _kinds(field.annotation)
    elif get_origin(kind) is dict and isinstance(step, str):
        yield from _kinds(get_args(kind)[1])
    elif get_origin(kind) is tuple and isinstance(step, int):
        parts = [part for part in get_args(kind) if part is not Ellipsis]
        # A list of any length has one type for all items. Items beyond a fixed length have the last
        # one.
        yield from _kinds(parts[min(step, len(parts) - 1)])


def _carries(section: type[Section], tag: Step) -> bool:
    """Return whether a tag selects a section from a union."""
    return any(get_args(field.annotation) == (tag,) for field in fields_of(section).values())
