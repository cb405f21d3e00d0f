"""Keys that a section of a document may have, with their descriptions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from cbdsl.documents.json_schema import json_schema
from cbdsl.documents.kinds import KINDS
from cbdsl.documents.ownership import declared_kind


def keys(text: str, steps: Sequence[str]) -> dict[str, str]:
    """Return descriptions of the keys of a section.

    Args:
        text: Text of the document; without a known kind it has only the keys of all kinds.
        steps: Keys that lead to the section, from the outside.
    """
    kind = declared_kind(text)
    if kind is None or kind not in KINDS:
        return {"cbdsl": "Version of the language.", "kind": "Kind of document."}
    whole = _schema(kind)
    sections = [whole]
    for step in steps:
        sections = [inner for each in sections for inner in _inside(each, step, whole)]
    known = (each.get("properties", {}) for each in sections)
    return {key: value.get("description", "") for some in known for key, value in some.items()}


@cache
def _schema(kind: str) -> Mapping[str, Any]:
    return json_schema(KINDS.get(kind).model)


def _inside(section: Mapping[str, Any], step: str, whole: Mapping[str, Any]) -> Iterator[Any]:
    """Yield the schemas that the value of a key may have."""
    # Sections with free names, such as `controllers`, describe all of their values by
    # `additionalProperties`.
    value = section.get("properties", {}).get(step, section.get("additionalProperties"))
    if isinstance(value, dict):
        yield from _plain(value, whole)


def _plain(schema: Mapping[str, Any], whole: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield the alternatives of a schema, with references followed."""
    if "$ref" in schema:
        yield from _plain(whole["$defs"][schema["$ref"].rpartition("/")[2]], whole)
        return
    alternatives = [*schema.get("anyOf", ()), *schema.get("oneOf", ())]
    if not alternatives:
        yield schema
    for each in alternatives:
        yield from _plain(each, whole)
