"""Comparison of the identities of two undertakings, such as trials."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def differences(known: Mapping[str, Any], requested: Mapping[str, Any]) -> Iterator[str]:
    """Yield the differences between two identities, in words."""
    for key in {**known, **requested}:
        old, new = known.get(key), requested.get(key)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            # Documents are identified by name and digest. Another name is another document, and
            # another digest the same document with changed contents.
            if old.get("name") != new.get("name"):
                yield f"{key} was {old.get('name')}, is {new.get('name')}"
            elif "sha256" in old:
                yield f"{key} '{old.get('name')}' has changed since"
            else:
                yield from differences(old, new)
        else:
            yield f"{key} was {_shown(old)}, is {_shown(new)}"


def _shown(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return str(value.get("name", value))
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
