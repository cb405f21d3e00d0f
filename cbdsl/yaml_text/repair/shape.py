"""Shapes that the models of documents want at a place: sections with keys, names, or lists."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache, reduce
from types import UnionType
from typing import Annotated, Any, NamedTuple, TypeGuard, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from cbdsl.documents.document import Section
from cbdsl.yaml_text.source_map import Step


class SchemaShape(NamedTuple):
    """The shape of a value.

    Attributes:
        kinds: the types that it may have, but for ``None``.
    """

    kinds: tuple[Any, ...] = ()

    @property
    def sections(self) -> tuple[type[Section], ...]:
        """The sections that it may be."""
        return tuple(kind for kind in self.kinds if is_section(kind))

    @property
    def keys(self) -> Mapping[str, FieldInfo]:
        """Fields by key, of all sections that it may be."""
        return _fields(self.sections)

    @property
    def renamed(self) -> Mapping[str, str]:
        """Keys of older documents, and their names now."""
        return {old: new for section in self.sections for old, new in section.renamed.items()}

    @property
    def is_of_names(self) -> bool:
        """Whether its keys are names that the document chooses."""
        return any(get_origin(kind) is dict for kind in self.kinds)

    def child(self, step: Step) -> SchemaShape:
        """The shape of a value or an item in it."""
        return SchemaShape(tuple(kind for outer in self.kinds for kind in _kinds_in(outer, step)))

    def at(self, steps: Iterable[Step]) -> SchemaShape:
        """The shape at a path below it."""
        return reduce(SchemaShape.child, steps, self)

    def located(self, loc: Iterable[Step]) -> SchemaShape:
        """The shape at a ``loc`` of pydantic's, which also names what it chose of unions."""
        shape = self
        for step in loc:
            inner = shape.child(step)
            shape = inner if inner.kinds else shape._tagged(step)
        return shape

    def is_complete(self, keys: set[str]) -> bool:
        """Whether some section of it has all that it needs in these keys."""
        return any(required_keys(section) <= keys for section in self.sections)

    def _tagged(self, tag: Step) -> SchemaShape:
        """The sections that carry a tag, or all where it is none."""
        return SchemaShape(
            tuple(known for known in self.sections if _carries(known, tag)) or self.kinds
        )


def shape_of(annotation: Any) -> SchemaShape:
    """The shape that an annotation of a model's field stands for."""
    return SchemaShape(tuple(_kinds(annotation)))


def is_section(kind: Any) -> TypeGuard[type[Section]]:
    """Whether values of a type are mappings whose keys are fixed."""
    return isinstance(kind, type) and issubclass(kind, Section)


@cache
def fields_of(section: type[Section]) -> Mapping[str, FieldInfo]:
    """The fields of a section by the keys that documents have for them."""
    return {field.alias or name: field for name, field in section.model_fields.items()}


@cache
def required_keys(section: type[Section]) -> frozenset[str]:
    """The keys that a section cannot do without."""
    return frozenset(key for key, field in fields_of(section).items() if field.is_required())


@cache
def _fields(sections: tuple[type[Section], ...]) -> Mapping[str, FieldInfo]:
    return {key: field for section in sections for key, field in fields_of(section).items()}


def _kinds(annotation: Any) -> Iterator[Any]:
    """The parts of a union, without what is said of their values."""
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from _kinds(get_args(annotation)[0])
    elif origin in (Union, UnionType):
        for part in get_args(annotation):
            yield from _kinds(part)
    elif annotation is not type(None):
        yield annotation


def _kinds_in(kind: Any, step: Step) -> Iterator[Any]:
    """The types of a value or an item in a value of a type."""
    if is_section(kind):
        field = fields_of(kind).get(str(step))
        if field is not None:
            yield from _kinds(field.annotation)
    elif get_origin(kind) is dict and isinstance(step, str):
        yield from _kinds(get_args(kind)[1])
    elif get_origin(kind) is tuple and isinstance(step, int):
        parts = [part for part in get_args(kind) if part is not Ellipsis]
        yield from _kinds(parts[min(step, len(parts) - 1)])


def _carries(section: type[Section], tag: Step) -> bool:
    """Whether a section is the one of a union that a tag chooses."""
    return any(get_args(field.annotation) == (tag,) for field in fields_of(section).values())
