"""Order of diagnostics: possible causes come before their consequences."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from cbdsl.checking.cause_order import causes_first
from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.yaml_text.library import Library

HEAD = "cbdsl: 1\nkind: program\nname: {name}\nrobot: dexter\n"
LOOK = "potential: spring, reference: 0, feedback: cyclopean.moton, effector: head"
BODY = f"controllers: {{look: {{{LOOK}}}}}\n"


def write(folder: Path, name: str, uses: str = "") -> Path:
    path = folder / "programs" / f"{name}.yaml"
    path.parent.mkdir(exist_ok=True)
    use = f"use: {{other: {{program: {uses}}}}}\n" if uses else ""
    actions = "actions: [look, other]\n" if uses else "actions: [look]\n"
    path.write_text(HEAD.format(name=name) + use + BODY + actions, encoding="utf-8")
    return path


def test_used_document_is_reported_before_its_user(tmp_path: Path) -> None:
    write(tmp_path, "z")
    write(tmp_path, "m", "z")
    found = check_document(write(tmp_path, "a", "m"), session=Session(Library(tmp_path)))
    assert [Path(diagnostic.place.file).stem for diagnostic in found] == ["z", "m", "a"]


def test_documents_that_name_each_other_keep_their_order(tmp_path: Path) -> None:
    session = Session(Library(tmp_path))
    paths = [write(tmp_path, "b", "c"), write(tmp_path, "c", "b")]
    found = [f for path in paths for f in check_document(path, session=session)]
    ordered = causes_first(found[::-1], session.library)
    assert sorted(ordered) == sorted(found)
    assert ordered == causes_first(found, session.library)


def test_unrelated_documents_are_sorted_by_path_and_line() -> None:
    places = [Place("b.yaml", 1), Place("a.yaml", 9), Place("a.yaml", 2), Place("b.yaml", 4)]
    found = [Diagnostic("CB101", "a message", place) for place in places]
    assert [f.place for f in causes_first(found, Library())] == sorted(places)


def test_chain_of_any_length_is_followed(tmp_path: Path) -> None:
    library, files = Library(tmp_path), [tmp_path / f"{i:05}.yaml" for i in range(3000)]
    for user, used in pairwise(files):
        library._named[library.real(user)] = {used}
    found = [Diagnostic("CB101", "a message", Place(str(file))) for file in files]
    ordered = causes_first(found, library)
    assert [f.place.file for f in ordered] == [str(file) for file in reversed(files)]
