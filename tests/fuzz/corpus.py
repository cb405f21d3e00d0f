"""The corpus of an entry point: inputs worth keeping, one a line, as JSON texts of single bytes."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

FOLDER = Path(__file__).parent / "corpus"


def kept(name: str) -> list[bytes]:
    """Return the inputs that are kept for an entry point."""
    file = FOLDER / f"{name}.jsonl"
    if not file.exists():
        return []
    return [json.loads(line).encode("latin-1") for line in file.read_text("ascii").splitlines()]


def keep(name: str, inputs: Iterable[bytes]) -> int:
    """Keep exactly these inputs, shortest first; returns how many."""
    ordered = sorted(set(inputs), key=lambda each: (len(each), each))
    lines = [json.dumps(each.decode("latin-1")) + "\n" for each in ordered]
    (FOLDER / f"{name}.jsonl").write_text("".join(lines), encoding="ascii")
    return len(lines)
