"""Learn stale knowledge again, by the commands in its provenance.

``python -m tests.relearn`` learns all documents whose inputs have changed, each after the policies
that it uses. ``python -m tests.relearn NAME ...`` learns the named ones.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Iterator, Sequence
from graphlib import TopologicalSorter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import yaml

from cbdsl.checking.knowledge.staleness import LEARNED, changed_inputs
from cbdsl.documents.kinds import KINDS, kind_of
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

_CB = Path(sys.executable).with_name("cb")


class Learned(NamedTuple):
    """Learned document: its file, its data, and the inputs that have changed since."""

    path: Path
    data: dict[str, Any]
    changed: list[str]

    @property
    def key(self) -> str:
        """Kind and name, which identify a document."""
        return f"{self.path.parent.name}/{self.path.stem}"

    @property
    def uses(self) -> set[str]:
        """Keys of the documents that have to be learned earlier."""
        provenance = self.data["provenance"]
        names = [*provenance.get("policies", {}), self.data.get("policy")]
        used = {f"policies/{name}" for name in names if isinstance(name, str)}
        relations = (provenance.get("earlier"), provenance.get("relations"))
        used |= {f"relations/{identity['name']}" for identity in relations if identity}
        used |= {f"meta_catalogs/{name}" for name in self.data.get("over", [])}
        return used - {self.key}


def learned(root: Path = ROOT) -> dict[str, Learned]:
    """Return the learned documents of a folder in the order of their uses, by key."""
    library, known = Library(root), {}
    for kind in LEARNED:
        for path in sorted((root / kind_of(kind).folder).glob("*.yaml")):
            changed = list(changed_inputs(library.read(path, kind).document, path, library))
            each = Learned(path, yaml.safe_load(path.read_text("utf-8")), changed)
            known[each.key] = each
    order = TopologicalSorter({key: each.uses & known.keys() for key, each in known.items()})
    return {key: known[key] for key in order.static_order()}


def commands(data: dict[str, Any]) -> Iterator[list[str]]:
    """Yield the words of the commands that learn a document, in their order.

    An exploration that programs joined runs without them first.
    """
    provenance = data["provenance"]
    words = shlex.split(provenance["command"])
    if joined := provenance.get("joined", []):
        later = {name for each in joined for name in each["programs"]}
        begun = [word for word in words if word.partition("=")[0] not in later]
        begun.remove("--join")
        begun[begun.index("--stage") + 1] = provenance["stage"]["name"]
        begun[begun.index("--actions") + 1] = str(joined[0]["after"])
        yield begun
    yield words


def learn(each: Learned, folder: Path) -> None:
    """Learn a document in an empty folder, and move it with its models to the shipped ones."""
    for words in commands(each.data):
        subprocess.run([_CB, *words[1:]], cwd=folder, check=True)
    for path in sorted(folder.glob("**/*.yaml")):
        kind, target = shipped(path)
        if kind != "model" or target.exists():
            target.write_bytes(path.read_bytes())


def shipped(path: Path) -> tuple[str, Path]:
    """Return the kind of a document, and the path at which it is shipped."""
    kind = yaml.safe_load(path.read_text("utf-8"))["kind"]
    return kind, ROOT / KINDS.get(kind).folder / path.name


def main(names: Sequence[str]) -> int:
    """Learn the named documents, or the stale ones; return the exit code."""
    known = learned()
    unknown = [name for name in names if not any(name in (k, k.split("/")[1]) for k in known)]
    if unknown:
        sys.stderr.write(f"no learned document {', '.join(unknown)}; known: {', '.join(known)}\n")
        return 2
    for key in known:
        each = learned()[key]  # an earlier one may have made it stale
        if key in names or each.path.stem in names or (not names and each.changed):
            sys.stdout.write(f"{key}: {', '.join(each.changed) or 'asked for'}\n")
            sys.stdout.flush()
            with TemporaryDirectory() as folder:
                learn(each, Path(folder))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
