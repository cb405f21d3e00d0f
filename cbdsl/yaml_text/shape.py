"""What a mapping in a document may hold, from the models of documents."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel

from cbdsl.yaml_text.source_map import Step


class Shape(NamedTuple):
    """The shape of a value.

    Attributes:
        sections: the sections that it may be, each with its keys.
        values: annotation of its values, where its keys are names.
        items: annotation of its items, where it is a list.
    """

    sections: tuple[type[BaseModel], ...] = ()
    values: Any = None
    items: Any = None

    @property
    def keys(self) -> Mapping[str, Any]:
        """Annotation by key, of all sections that it may be."""
        return _keys(self.sections)

    @property
    def is_of_names(self) -> bool:
        """Whether its keys are names that the document chooses."""
        return self.values is not None

    def child(self, step: Step) -> Shape:
        """The shape of a value or an item in it."""
        if isinstance(step, int):
            return shape_of(self.items)
        return shape_of(self.values if self.is_of_names else self.keys.get(step))

    def is_complete(self, keys: set[str]) -> bool:
        """Whether some section of it has all that it needs in these keys."""
        return any(_required(section) <= keys for section in self.sections)


def shape_of(annotation: Any) -> Shape:
    """The shape that an annotation of a model's field stands for."""
    sections, values, items = [], None, None
    for kind in _alternatives(annotation):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            sections.append(kind)
        elif get_origin(kind) is dict:
            values = get_args(kind)[1]
        elif get_origin(kind) is tuple:
            items = get_args(kind)[0]
    return Shape(tuple(sections), values, items)


def _alternatives(annotation: Any) -> Iterator[Any]:
    """The types that a value may have."""
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from _alternatives(get_args(annotation)[0])
    elif origin in (Union, UnionType):
        for part in get_args(annotation):
            yield from _alternatives(part)
    else:
        yield annotation


@cache
def _keys(sections: tuple[type[BaseModel], ...]) -> Mapping[str, Any]:
    return {
        field.alias or name: field.annotation
        for section in sections
        for name, field in section.model_fields.items()
    }


@cache
def _required(section: type[BaseModel]) -> frozenset[str]:
    fields = section.model_fields.items()
    return frozenset(field.alias or name for name, field in fields if field.is_required())
