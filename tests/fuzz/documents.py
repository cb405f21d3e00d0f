"""Documents of each kind, as ``cb validate`` reads and explains them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.catalogue import catalogue
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.text_format import text
from cbdsl.diagnostics.validation_report import ValidationReport
from cbdsl.documents.kinds import KINDS
from cbdsl.yaml_text.library import Library, shipped
from tests.conftest import ROOT
from tests.fuzz.entry_point import EntryPoint

#: All kinds of documents that are built in.
NAMES = (
    *("program", "stage", "robot", "policy", "schema", "catalog", "meta_catalog", "model"),
    "calibration",
    "relations",
    "shared",
)
_BAD = ROOT / "tests" / "checking" / "bad"
_YAML = re.compile(r"^```yaml\n(.*?)^```$", re.DOTALL | re.MULTILINE)
# Larger ones are read by other tests; the fuzzer gets further with small ones.
_LARGEST = 24_000


def _reader(kind: str) -> Callable[[bytes], None]:
    """Return a reader of bytes that stand in for a file in the folder of a kind."""
    path = ROOT / KINDS.get(kind).folder / "any.yaml"
    sessions: list[Session] = []

    def read(data: bytes) -> None:
        if not sessions or not sessions[0].replace(path, data):
            sessions[:] = [Session(Library(ROOT, {path: data}))]
        session = sessions[0]
        diagnostics = check_document(path, session)

        def text_of(file: str) -> str | None:
            try:
                return session.library.text(path) if file == str(path) else None
            except DiagnosticsError:
                return None

        printed = text(ValidationReport(tuple(diagnostics), 1, 0, text_of))
        printed.encode("utf-8")
        assert "\x1b" not in printed and "internal error" not in printed

    return read


def _seeds(kind: str) -> Callable[[], Iterator[bytes]]:
    """Return a function for documents of a kind: shipped, bad, of docs and diagnostics."""
    line = re.compile(rf"^kind: {kind}\b", re.MULTILINE)

    def seeds() -> Iterator[bytes]:
        folders = (shipped() / "robots", shipped() / "programs", shipped() / "knowledge", _BAD)
        files = [file for folder in folders for file in sorted(folder.rglob("*.yaml"))]
        texts = [file.read_bytes().decode("utf-8", "replace") for file in files]
        for page in sorted((ROOT / "docs").rglob("*.md")):
            texts += _YAML.findall(page.read_text("utf-8"))
        for entry in catalogue().values():
            bad = entry.bad.encode() if isinstance(entry.bad, str) else entry.bad or b""
            texts += [bad.decode("utf-8", "replace"), entry.good]
        for each in dict.fromkeys(texts):
            if line.search(each) and len(each) <= _LARGEST:
                yield each.encode()

    return seeds


ENTRY_POINTS = {kind: EntryPoint(_reader(kind), _seeds(kind)) for kind in NAMES}
