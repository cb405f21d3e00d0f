"""JSON Schemas: they agree with the models on the shipped documents and on bad ones."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.documents.document import Document
from cbdsl.documents.json_schema import common_values, json_schema
from cbdsl.documents.kinds import models
from cbdsl.types.unit import UNITS
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.repair.repair import mend

KINDS = models()

ROOT = Path(__file__).parents[2]
BAD = ROOT / "tests" / "checking" / "bad"
SHIPPED = sorted(p for folder in ("robots", "programs") for p in (ROOT / folder).rglob("*.yaml"))
SHAPE_CODES = {"CB202", "CB203", "CB204", "CB205", "CB206", "CB207", "CB208"}

#: Relations between keys are left to the checker.
BEYOND_SCHEMAS = {
    "place_twice",
    "place_nowhere",
    "gap_without_hand",
    "field_obstacle_shape",
    "thrown_and_shaken",
    "load_cell_with_two_surfaces",
    # A schema treats a reference that is text like any other text.
    "reference_in_parentheses",
    "reference_quoted",
    "reference_without_brackets_below",
}


@cache
def validator(kind: str) -> Any:
    return jsonschema.Draft202012Validator(json_schema(KINDS[kind]))


def plain(path: Path) -> Any:
    composed = mend(path.read_text("utf-8"), str(path))
    if composed.diagnostics:
        raise DiagnosticsError(composed.diagnostics)
    return composed.root.plain()


def is_valid(data: Any) -> bool:
    kind = data.get("kind") if isinstance(data, dict) else None
    return kind in KINDS and bool(validator(kind).is_valid(data))


def readable(path: Path) -> bool:
    """Return whether a file is valid YAML; other files have no shape."""
    try:
        plain(path)
    except (DiagnosticsError, UnicodeDecodeError):
        return False
    return True


def fits(data: Any) -> bool:
    """Return whether some model accepts the data."""
    kind = data.get("kind") if isinstance(data, dict) else None
    if kind not in KINDS:
        return False
    try:
        KINDS[kind].model_validate(data)
    except ValidationError:
        return False
    return True


READABLE_BAD = [path for path in sorted(BAD.rglob("*.yaml")) if readable(path)]


@pytest.mark.parametrize("kind", KINDS)
def test_schemas_are_valid_json_schemas(kind: str) -> None:
    jsonschema.Draft202012Validator.check_schema(json_schema(KINDS[kind]))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_documents_are_valid(path: Path) -> None:
    data = plain(path)
    assert list(validator(data["kind"]).iter_errors(data)) == []


@pytest.mark.parametrize("path", READABLE_BAD, ids=lambda path: path.stem)
def test_bad_documents_are_valid_where_the_models_accept_them(path: Path) -> None:
    data = plain(path)
    assert is_valid(data) == (fits(data) or path.stem in BEYOND_SCHEMAS)


def test_bad_documents_hold_every_fault_of_shape() -> None:
    session = Session(Library(BAD))
    invalid = [path for path in READABLE_BAD if not is_valid(plain(path))]
    codes = {d.code for path in invalid for d in check_document(path, session=session)}
    assert codes >= SHAPE_CODES


def sections(model: type[BaseModel], seen: set[type[BaseModel]]) -> Iterator[type[BaseModel]]:
    if model in seen:
        return
    seen.add(model)
    yield model
    for field in model.model_fields.values():
        for part in _parts(field.annotation):
            yield from sections(part, seen)


def _parts(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in getattr(annotation, "__args__", ()):
        yield from _parts(part)


SECTIONS = {s.__name__: s for kind in KINDS.values() for s in sections(kind, set())}


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_is_described_and_no_other_is_allowed(kind: str) -> None:
    schema = json_schema(KINDS[kind])
    objects = [schema, *schema["$defs"].values()]
    for part in objects:
        for key, value in part.get("properties", {}).items():
            assert len(value["description"]) > 10, key
        if part.get("type") == "object":
            assert part["additionalProperties"] is False and part["title"]


def _is_quantity(definition: dict[str, Any]) -> bool:
    return str(definition.get("description", "")).startswith("Unit: ")


@pytest.mark.parametrize("text", [f"1{space}{s}" for s in UNITS for space in ("", " ")])
@pytest.mark.parametrize("kind", ["robot", "program", "stage"])
def test_quantities_have_the_units_of_their_own_dimensions(kind: str, text: str) -> None:
    dimension = UNITS[text[1:].strip()].dimension
    quantities = {k: d for k, d in json_schema(KINDS[kind])["$defs"].items() if _is_quantity(d)}
    assert quantities
    for name, definition in quantities.items():
        words = "".join(word.capitalize() for word in dimension.split())
        own = words in name.removeprefix("NonNegative").removeprefix("Positive").split("Or")
        assert jsonschema.Draft202012Validator(definition).is_valid(text) is own, name


NUMBERS = (
    0,
    -1,
    1.5,
    "0",
    "-0.5",
    "+2",
    "1e-3",
    ".5",
    "0.0e3",
    "00.10",
    "",
    "one",
    True,
    [1],
    "5 px",
)


@pytest.mark.parametrize("value", NUMBERS, ids=repr)
def test_quantities_are_valid_where_the_models_accept_them(value: object) -> None:
    for key, dimensioned in (
        ("gain", {"gain": value}),
        ("within", {"funnel": {"height": 1, "within": value}}),
        ("speed", {"speed": value}),
    ):
        triple = {"potential": "spring", "feedback": "head", "effector": "head", **dimensioned}
        head = {"cbdsl": 1, "kind": "program", "name": "n", "robot": "r", "actions": ["c"]}
        data = {**head, "controllers": {"c": triple}}
        assert is_valid(data) == fits(data), key


@pytest.mark.parametrize(
    ("section", "key"), [(name, key) for name, keys in common_values().items() for key in keys]
)
def test_examples_are_accepted_by_the_models(section: str, key: str) -> None:
    fields = SECTIONS[section].model_fields.items()
    (field,) = [field for name, field in fields if key in (name, field.alias)]
    adapter = TypeAdapter(field.rebuild_annotation())
    for value in common_values()[section][key]:
        adapter.validate_python(value)


def test_examples_are_valid_where_they_are_shown() -> None:
    for kind in KINDS:
        schema = json_schema(KINDS[kind])
        for part in (schema, *schema["$defs"].values()):
            for value in part.get("properties", {}).values():
                whole = {**value, "$defs": schema["$defs"]}
                for example in (*value.get("examples", ()), *_default(value)):
                    assert jsonschema.Draft202012Validator(whole).is_valid(example), example


def _default(value: dict[str, Any]) -> list[Any]:
    return [value["default"]] if "default" in value else []


def test_document_of_another_kind_is_invalid() -> None:
    for path in SHIPPED:
        data = plain(path)
        others = [kind for kind in KINDS if kind != data["kind"]]
        assert not any(validator(kind).is_valid(data) for kind in others)


def test_every_kind_is_a_document() -> None:
    assert all(issubclass(model, Document) for model in KINDS.values())
