"""Templates of documents to start from."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from string import Template
from types import MappingProxyType

from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.legible_text import encoded, seen
from cbdsl.diagnostics.reason import reason
from cbdsl.documents.document import NAME_PATTERN, Document
from cbdsl.documents.json_schema import json_schema, json_text, schema_file
from cbdsl.documents.kinds import KINDS, kind_of
from cbdsl.storage.atomic_file import require_unlinked, write_bytes

# Unquoted texts that every YAML parser reads as strings, not as numbers, booleans or null.
_PLAIN = re.compile(
    r"(?!(?:true|false|null|yes|no|on|off|y|n)\Z)[A-Za-z_][\w./-]*\Z", re.ASCII | re.IGNORECASE
)


class DocumentTemplate:
    """Template of a document.

    Args:
        kind: Kind of document.
        word: Name of the kind and of its template.
        name: Name of the document.
        to: Folder of the document; ``None`` for the kind's folder.
        template: Name of the template; that of the kind if empty.

    Attributes:
        folder: Folder of the document.
        file: File of the document.

    Raises:
        UsageError: The name is invalid.
    """

    def __init__(
        self, kind: type[Document], word: str, name: str, to: Path | None, template: str = ""
    ) -> None:
        require_name(name)
        self._word, self._name, self._template = word, name, template or word
        self.folder = folder_of(kind, to)
        self.file = self.folder / f"{name}.yaml"
        # Folder of the document's project, as far as known.
        self._root = Path() if to is None else self.folder

    def write(
        self,
        values: Mapping[str, str],
        force: bool,
        files: Mapping[Path, bytes] = MappingProxyType({}),
    ) -> tuple[Path, ...]:
        """Write the document to its folder, with the files that it needs.

        Args:
            values: Values of the template's placeholders.
            force: True to replace existing files.
            files: Contents of the files to which the document refers, by path.

        Returns:
            Written schemas and document, without ``files``.

        Raises:
            UsageError: A file exists already, or cannot be written.
        """
        file = self.file
        # All files are checked before the first one is written, so that a refusal leaves nothing
        # behind.
        there = next((each for each in (file, *files) if each.exists() and not force), None)
        if there is not None:
            raise UsageError(f"{there} is there; --force replaces it")
        template = Path(__file__).parent / "templates" / f"{self._template}.yaml.template"
        text = Template(template.read_text("utf-8"))
        schema, generated = _schema(self._word, self.folder, self._root)
        # Editors resolve the path of a schema relative to the document, with slashes on every
        # system.
        line = Path(os.path.relpath(schema, self.folder)).as_posix()
        written = text.substitute(values, name=self._name, schema=line)
        # The document comes last: if it exists, the files that it names do, too.
        self._write_files({**files, **generated, file: encoded(written)})
        return (*generated, file)

    def renew(self, files: Mapping[Path, bytes]) -> tuple[Path, ...]:
        """Replace the files to which the document refers, and leave the document as it is.

        Args:
            files: Contents of the files, by path.

        Returns:
            Written files.

        Raises:
            UsageError: There is no document, nothing to replace, or a file cannot be written.
        """
        if not self.file.is_file():
            raise UsageError(f"{self.file} is not there; without --renew, it is written")
        if not files:
            raise UsageError(f"{self.file}: nothing to renew; it refers to the model in its place")
        self._write_files(files)
        return tuple(files)

    def _write_files(self, files: Mapping[Path, bytes]) -> None:
        try:
            for folder in {folder for path in files for folder in path.parents}:
                if folder.is_relative_to(self._root) and folder != self._root:
                    require_unlinked(folder)
            for path, contents in files.items():
                path.parent.mkdir(parents=True, exist_ok=True)
                write_bytes(contents, path)
        except OSError as error:
            raise UsageError(f"{self.file}: {reason(error)}") from error


def folder_of(kind: type[Document], to: Path | None) -> Path:
    """Return the folder of a new document: a given one, or that of its kind."""
    return Path(kind_of(kind).folder) if to is None else to


def require_name(name: str) -> None:
    """Check the name of a document.

    Raises:
        UsageError: The name is invalid.
    """
    if not re.search(NAME_PATTERN, name):
        raise UsageError(
            f"'{name}' is not a name: a letter, then letters, digits and underscores make one"
        )


def _schema(word: str, folder: Path, root: Path) -> tuple[Path, dict[Path, bytes]]:
    """Return the schema of a kind for documents of a folder, and the file to write for it.

    The file is that of the nearest folder ``schemas`` above the documents. Where there is none, it
    is written to the project, since a path into the installed package would be wrong elsewhere.

    Args:
        word: Name of the kind.
        folder: Folder of the document.
        root: Folder of its project.
    """
    here, file = folder.resolve(), Path("schemas") / schema_file(word)
    nearest = next(
        (above / file for above in (here, *here.parents) if (above / file).is_file()), None
    )
    if nearest is not None:
        return nearest, {}
    text = json_text(json_schema(KINDS.get(word).model))
    return root / file, {root / file: text.encode()}


def scalar(text: str) -> str:
    """Return a text as a YAML scalar, quoted as in JSON if necessary."""
    # Names such as ``on`` or ``1e3`` are not strings in YAML without quotes.
    if _PLAIN.match(text):
        return text
    return seen(json.dumps(text, ensure_ascii=False), lambda sign: f"\\u{ord(sign):04x}")
