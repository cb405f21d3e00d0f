"""Writer of a document to a file that reads back as the same document."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from cbdsl.documents.document import Document
from cbdsl.storage.atomic_file import write_text
from cbdsl.yaml_text import scalar
from cbdsl.yaml_text.characters import (
    escaped_invisible,
    invisible_in,
    suggested_key,
    suggested_value,
)
from cbdsl.yaml_text.composer import MERGE


class _Dumper(yaml.SafeDumper):
    """Dumper that quotes exactly the texts that the reader would resolve to other types."""

    # PyYAML's stubs declare no class variable here.
    yaml_implicit_resolvers = {  # noqa: RUF012
        None: [
            ("tag:yaml.org,2002:null", scalar.NULL),
            ("tag:yaml.org,2002:bool", scalar.BOOLEAN),
            ("tag:yaml.org,2002:int", scalar.INTEGER),
            ("tag:yaml.org,2002:float", scalar.FLOAT),
            *(("tag:yaml.org,2002:float", refused) for refused in scalar.REFUSED),
            ("tag:yaml.org,2002:merge", re.compile(rf"{re.escape(MERGE)}\Z")),
        ]
    }

    # By default, an object that occurs twice is written as an anchor and an alias.
    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_sequence(
        self, tag: str, sequence: Iterable[Any], flow_style: bool | None = None
    ) -> yaml.SequenceNode:
        """Represent a list of scalars in one line."""
        items = list(sequence)
        plain = not any(isinstance(item, (dict, list, tuple)) for item in items)
        return super().represent_sequence(tag, items, flow_style or plain)

    def text(self, data: str) -> yaml.ScalarNode:
        # YAML folds these line breaks into spaces unless they are escaped. The reader takes a
        # look-alike for a number or a name. Invisible characters have to be escaped.
        is_strange = not data.isascii() and (
            suggested_value(data) or suggested_key(data) or invisible_in(data)
        )
        style = '"' if is_strange or _BREAKS.intersection(data) else None
        return self.represent_scalar("tag:yaml.org,2002:str", data, style)


_BREAKS = frozenset("\x85\u2028\u2029")
_Dumper.add_representer(str, _Dumper.text)


def dump(document: Document) -> str:
    """Return a document as YAML, without values that equal their defaults."""
    data = document.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    # An empty key that another one replaces is as good as absent, and might be invalid.
    others = {key: data.keys() & by for key, by in document.alternatives.items()}
    return dump_plain({k: value for k, value in data.items() if value or not others.get(k)})


def dump_plain(data: Mapping[str, Any]) -> str:
    """Return the dicts, lists and scalars of a document as YAML, in their order."""
    text = yaml.dump(dict(data), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100)
    return escaped_invisible(text)


def write(document: Document, path: Path, *, follow: bool = False) -> None:
    """Write a document atomically; see ``replace_file``."""
    write_text(dump(document), path, follow=follow)
