"""Make docs/llms.txt, the index of the documentation for language models.

Run ``python docs/make_llms.py`` after a change of the navigation in mkdocs.yml. The index names
each page of the navigation with its title and its first sentence.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
FILE = DOCS / "llms.txt"

_HEAD = """\
# cbdsl

> Robot behaviour as data: declared in YAML, type-checked, run, learned, and written back as YAML.

Check documents with `cb validate PATH... --format json`; exit code 0 means no errors.
`cb explain CODE` explains a diagnostic.
`cb schema KIND` prints the JSON Schema of a document kind.
`cb show resources --robot NAME` lists the signals and effectors of a robot.
`cb run PROGRAM --backend kinematic --json` runs a program without physics.
"""


def page() -> str:
    """Return the index."""
    return "\n".join([_HEAD, *_lines()]) + "\n"


def _lines() -> Iterator[str]:
    navigation = (ROOT / "mkdocs.yml").read_text("utf-8").partition("\nnav:\n")[2]
    for line in navigation.splitlines():
        if found := re.fullmatch(r"  - ([A-Z][\w -]+):", line):
            yield f"\n## {found[1]}\n"
        elif found := re.search(r"- (?:[\w -]+: )?([\w/]+\.md)$", line):
            yield _entry(found[1])


def _entry(name: str) -> str:
    text = (DOCS / name).read_text("utf-8")
    title = re.search(r"^# (.+)$", text, re.MULTILINE)
    assert title is not None, name
    rest = text[title.end() :].strip()
    paragraph = " ".join(re.split(r"\n\n|\n[|`#<]", rest)[0].split())
    sentence = re.split(r"(?<=[.])\s", paragraph)[0].rstrip(".")
    sentence = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", sentence)
    described = f": {sentence}" if sentence and sentence[0] not in "|`#<!" else ""
    return f"- [{title[1]}]({name}){described}"


if __name__ == "__main__":
    FILE.write_text(page(), encoding="utf-8")
