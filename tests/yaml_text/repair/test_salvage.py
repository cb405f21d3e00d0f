"""Salvage of faulty documents: all other parts are checked, without consequential diagnostics."""

from __future__ import annotations

import contextlib
import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.documents.document import Document
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.library import Library, shipped
from cbdsl.yaml_text.reader import read_sound_parts

Steps = tuple[str | int, ...]

FILES = [
    path
    for folder in ("robots", "programs")
    for path in sorted((shipped() / folder).rglob("*.yaml"))
]


def paths(value: Any, path: Steps = ()) -> Iterator[Steps]:
    """Yield the paths of all values below a value."""
    for step, inner in value.items() if isinstance(value, dict) else enumerate(value):
        yield (*path, step)
        if isinstance(inner, (dict, list)):
            yield from paths(inner, (*path, step))


def at(value: Any, path: Steps) -> Any:
    for step in path:
        value = value[step]
    return value


PLAIN = {file: compose(file.read_text("utf-8"), str(file)).root.plain() for file in FILES}
PLACES = [
    (file, path)
    for file, data in PLAIN.items()
    for path in paths(data)
    if path[0] not in ("cbdsl", "kind")  # without these keys the document kind is unknown
]
TEXTS = [place for place in PLACES if isinstance(at(PLAIN[place[0]], place[1]), str)]
#: Sections with several parts: one can be faulty while another is checked.
SEVERAL = ("controllers", "effectors", "contexts", "things")


def found(file: Path, *changes: tuple[Callable[[Any, Steps], None], Steps]) -> list[Diagnostic]:
    """Return the diagnostics of a shipped document after changes, as JSON, which is YAML."""
    data = copy.deepcopy(PLAIN[file])
    for change, path in changes:
        change(at(data, path[:-1]), path)
    library = Library(given={file: json.dumps(data, indent=1).encode()})
    all_ = check_document(file, session=Session(library))
    return [d for d in all_ if d.code != "CB704"]  # a name may differ from its file's


def spoil(parent: Any, path: Steps) -> None:
    """Replace a value by one of the wrong kind."""
    # A controller may be a mapping or a text, but never a list.
    is_mapping = isinstance(parent[path[-1]], dict) or len(path) == 2
    parent[path[-1]] = [[[]]] if is_mapping else {"nonsense": []}


def misspell(parent: Any, path: Steps) -> None:
    parent[path[-1]] += "q"


def rename(parent: Any, path: Steps) -> None:
    """Misspell a key in place."""
    items = list(parent.items())
    parent.clear()
    parent.update({key + "q" if key == path[-1] else key: value for key, value in items})


def causes(diagnostics: list[Diagnostic]) -> set[tuple[str, str]]:
    return {(diagnostic.code, diagnostic.message) for diagnostic in diagnostics}


#: A share of the examples, since each checks a document anew.
few = settings(max_examples=settings().max_examples // 4)


@few
@given(st.sampled_from(PLACES))
def test_value_of_the_wrong_kind_is_one_finding(place: tuple[Path, Steps]) -> None:
    file, path = place
    (diagnostic,) = found(file, (spoil, path))
    assert diagnostic.code in ("CB202", "CB203", "CB204", "CB205", "CB206", "CB208")


@few
@given(st.sampled_from([place for place in PLACES if isinstance(place[1][-1], str)]))
def test_misspelt_key_is_one_cause(place: tuple[Path, Steps]) -> None:
    file, path = place
    assert len(causes(found(file, (rename, path)))) <= 1


@few
@given(st.sampled_from([place for place in TEXTS if place[1][0] != "parameters"]))
def test_misspelt_text_is_one_cause(place: tuple[Path, Steps]) -> None:
    file, path = place
    assert len(causes(found(file, (misspell, path)))) <= 1


@few
@given(st.data())
def test_faulty_part_hides_nothing_in_another(data: st.DataObject) -> None:
    bound = [p for p in TEXTS if p[1][0] in SEVERAL]
    file, text = data.draw(st.sampled_from(bound))
    others = [
        p for f, p in PLACES if f == file and p[0] == text[0] and p[1:2] not in ((), text[1:2])
    ]
    assume(others)
    other = data.draw(st.sampled_from(others))
    both = causes(found(file, (spoil, other), (misspell, text)))
    alone = causes([d for d in found(file, (misspell, text)) if d.is_error])
    assert len(both) == 1 + len(alone) and both > alone


@pytest.mark.parametrize(
    ("transitions", "validations"), [("2", 1), ("two", 2)], ids=["sound", "faulty"]
)
def test_read_validates_once_and_twice_with_one_fault(
    transitions: str, validations: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "posture.yaml"
    whole = (shipped() / "programs/posture.yaml").read_text("utf-8")
    path.write_text(f"{whole}\nlimits: {{transitions: {transitions}}}\n", "utf-8")
    validate, count = ProgramDocument.model_validate, 0

    def counted(*arguments: Any, **named: Any) -> ProgramDocument:
        nonlocal count
        count += 1
        return validate(*arguments, **named)

    monkeypatch.setattr(ProgramDocument, "model_validate", counted)
    read_sound_parts(path, ProgramDocument)
    assert count == validations


@pytest.fixture
def validations(monkeypatch: pytest.MonkeyPatch) -> Callable[[Path], int]:
    """Return a function that counts how often a document is validated while it is read."""
    count, validate = 0, Document.model_validate.__func__  # type: ignore[attr-defined]

    def counted(kind: type[Document], *args: Any, **options: Any) -> Document:
        nonlocal count
        count += 1
        validated: Document = validate(kind, *args, **options)
        return validated

    monkeypatch.setattr(Document, "model_validate", classmethod(counted))

    def read(path: Path) -> int:
        nonlocal count
        count = 0
        with contextlib.suppress(DiagnosticsError):
            read_sound_parts(path, Document)
        return count

    return read


def test_sound_document_is_validated_once(validations: Callable[[Path], int]) -> None:
    assert {path.name: validations(path) for path in FILES} == {path.name: 1 for path in FILES}


# A respelt key is validated in its new place, with the faults inside it or of its value; words such
# as `off` are validated as texts once more.
SEVERAL_LAYERS = {
    "colon_missing_in_braces.yaml",
    "equals_in_braces.yaml",
    "key_meant_by_another.yaml",
    "words_for_quantities.yaml",
}


def test_broken_document_is_validated_at_most_twice(validations: Callable[[Path], int]) -> None:
    bad = sorted((Path(__file__).parents[2] / "checking" / "bad").rglob("*.yaml"))
    counts = {path.name: validations(path) for path in bad}
    assert {name for name, count in counts.items() if count > 2} == SEVERAL_LAYERS
    assert max(counts.values()) == 3
