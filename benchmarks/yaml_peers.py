"""Lines that three readers report for single faults in shipped documents.

The readers are that of cbdsl, PyYAML's, and tree-sitter-yaml, whose parser recovers from errors. A
reader is right about a fault if its first error is on the changed line.

    python benchmarks/yaml_peers.py --faults 40 --seed 7
"""

from __future__ import annotations

import argparse
import random
import re
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import tree_sitter_yaml
import yaml  # noqa: TID251 (a peer)
from tree_sitter import Language, Parser

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library, shipped

KEY = re.compile(r"(\s*)([A-Za-z_]\w*): (?=[^>|\s])")
PARSER = Parser(Language(tree_sitter_yaml.language()))

#: Faults by name: each changes a line that begins with a key and its value.
FAULTS: dict[str, Callable[[re.Match[str], str], str]] = {
    "missing colon": lambda key, rest: f"{key[1]}{key[2]} {rest}",
    "missing space": lambda key, rest: f"{key[1]}{key[2]}:{rest}",
    "missing bracket": lambda key, rest: f"{key[0]}{rest.rstrip()[:-1]}",
    "one more space of indentation": lambda key, rest: f" {key[0]}{rest}",
    "tab": lambda key, rest: f"\t{key[0].lstrip()}{rest}",
    "open quote": lambda key, rest: f'{key[0]}"{rest}',
}


def lines_by_cbdsl(path: Path, text: str) -> int | None:
    """Return the line of the first error, from 1; ``None`` if there is none."""
    session = Session(Library(given={path: text.encode()}))
    errors = [each for each in check_document(path, session=session) if each.is_error]
    return errors[0].place.line if errors else None


def lines_by_pyyaml(path: Path, text: str) -> int | None:
    """Return the line of the error, from 1; ``None`` if there is none."""
    try:
        yaml.compose(text)
    except yaml.MarkedYAMLError as error:
        return None if error.problem_mark is None else int(error.problem_mark.line) + 1
    return None


def lines_by_tree_sitter(path: Path, text: str) -> int | None:
    """Return the first line with an error or an inserted token, from 1; ``None`` without one."""
    waiting, lines = [PARSER.parse(text.encode()).root_node], list[int]()
    while waiting:
        node = waiting.pop()
        if node.is_error or node.is_missing:
            lines.append(node.start_point.row + 1)
        waiting.extend(node.children)
    return min(lines, default=None)


READERS = {
    "cbdsl": lines_by_cbdsl,
    "PyYAML": lines_by_pyyaml,
    "tree-sitter-yaml": lines_by_tree_sitter,
}


def places(name: str) -> Iterator[tuple[Path, list[str], int]]:
    """Yield the file, its lines and the index of each line that a kind of fault can change."""
    for folder in ("robots", "programs"):
        for path in sorted((shipped() / folder).rglob("*.yaml")):
            lines = path.read_text("utf-8").split("\n")
            for index, line in enumerate(lines):
                if KEY.match(line) and (name != "missing bracket" or line.endswith(("]", "}"))):
                    yield path, lines, index


def main() -> None:
    """Print the right lines of each reader, by kind of fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faults", type=int, default=40, help="faults of each kind")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    rng = random.Random(given.seed)
    print("| fault |", " | ".join(READERS), "|")
    for name, fault in FAULTS.items():
        right: Counter[str] = Counter()
        for path, lines, index in rng.sample([*places(name)], given.faults):
            key = KEY.match(lines[index])
            assert key is not None
            changed = fault(key, lines[index][key.end() :])
            text = "\n".join([*lines[:index], changed, *lines[index + 1 :]])
            right.update(n for n, read in READERS.items() if read(path, text) == index + 1)
        print(f"| {name} |", " | ".join(f"{right[n]} of {given.faults}" for n in READERS), "|")


if __name__ == "__main__":
    main()
