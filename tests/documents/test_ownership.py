"""Ownership: documents of this project are recognized by their declared keys and their folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.documents.kinds import KINDS
from cbdsl.documents.ownership import is_declared, is_own
from tests.conftest import ROOT

FOREIGN = {
    "empty": "",
    "compose": "services:\n  web: {image: x}\n",
    "service_of_our_name": "services:\n  cbdsl: {image: x}\n  kind: robot\n",
    "workflow": "on: push\njobs:\n  a: {runs-on: x}\n",
    "pod": "apiVersion: v1\nkind: Pod\nmetadata: {name: a}\n",
    "schema_of_kubernetes": "kind: schema\napiVersion: example.com/v1\n",
    "json_pod": '{"apiVersion": "v1", "kind": "robot"}',
    "template": "data:\n  x: {{ .Values.x }}\n",
    "other_kind": "kind: pipeline\nname: drone\n",
    "in_a_text": "a: |\n  cbdsl: 1\n  kind: robot\n",
    "image": "cbdsl:latest\n",
    "list": "- cbdsl: 1\n- kind: robot\n",
}
OWN = {
    "both": "cbdsl: 1\nkind: program\n",
    "version": "cbdsl: 1\nkind: prgrm\n",
    "kind": "# a comment\nkind: robot\n",
    "later": "name: a\nkind: stage  # of what\ncbdsl: 1\n",
    "braces": "{cbdsl: 1, kind: robot}",
    "json": '\n{\n  "cbdsl": 1,\n  "kind": "robot"\n}\n',
    "braces_with_kind_behind": "{name: a, kind: robot}",
    "tight_json": '{"name":"a","kind":"robot"}',
    "quoted": "'cbdsl': 1\n",
    "second": "---\ncbdsl: 1\n",
    "after_a_comment_and_a_mark": "# x\n---\n\n  cbdsl: 1\n  kind: robot\n",
    "no_yaml": "cbdsl: 1\nkind: [\n",
    "version_of_both": "apiVersion: v1\ncbdsl: 1\n",
}


@pytest.mark.parametrize("text", FOREIGN.values(), ids=FOREIGN)
def test_is_declared_for_yaml_of_another_tool_is_false(text: str) -> None:
    assert not is_declared(text)
    assert not is_own(Path("charts/a.yaml"), text)


@pytest.mark.parametrize("text", OWN.values(), ids=OWN)
def test_is_declared_for_a_document_is_true(text: str) -> None:
    assert is_declared(text)


@pytest.mark.parametrize("kind", KINDS.builtins)
def test_is_declared_for_every_kind_is_true(kind: str) -> None:
    assert is_declared(f"name: a\nkind: {kind}\n")


@pytest.mark.parametrize("kind", KINDS.builtins)
def test_is_own_in_a_folder_of_documents_needs_no_keys(kind: str) -> None:
    file = Path(KINDS.get(kind).folder, "a.yaml")
    assert is_own(file, "") and is_own(Path("somewhere") / file, "nme: a\n")
    assert not is_own(file, "apiVersion: v1\nkind: Pod\n")
    assert not is_own(Path("a.yaml"), "")


def test_is_declared_for_every_shipped_document_is_true() -> None:
    files = [
        f for name in ("robots", "programs", "knowledge") for f in (ROOT / name).rglob("*.yaml")
    ]
    assert files and all(is_declared(file.read_text("utf-8")) for file in files)
