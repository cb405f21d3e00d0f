"""Words and prose of cbdsl: banned words, class names, signatures, and the measures of prose."""

from __future__ import annotations

import ast
import io
import re
import tokenize
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import pytest

from tests.conftest import ROOT
from tests.prose import excess, files, places, read_limits

PLUGINS = (path.relative_to(ROOT) for path in sorted(ROOT.glob("distributions/*/cbdsl_*")))
PACKAGES = ("cbdsl", "reproduction/cbdsl_reproduction", *map(str, PLUGINS))
WORDS = tomllib.loads((ROOT / "tests" / "banned_words.toml").read_text("utf-8"))
#: No function takes more positional parameters, unless it is compiled.
PARAMETERS = 8
#: Names of tests with fewer than three words, or with a clause or pronoun instead of a unit.
_RIDDLE = re.compile(
    r"test_[^_]+(_[^_]+)?|test_(it|its|they|what|who|where|then|of|there|those)_.*"
    r"|.*_(what|who|whatever|whoever|told|nobody|somebody)(_.*)?"
)
_COMPILED = ("njit", "jit", "compiled", "compiled_once", "compiled_sum", "potential")


class Finding(NamedTuple):
    """A fault and its line."""

    line: int
    message: str


def diagnostics(source: str) -> list[Finding]:
    """Return the faults of a module, except for faults between several modules."""
    tree = ast.parse(source)
    return sorted({*identifiers(tree), *prose(tree, source), *openings(tree), *signatures(tree)})


def identifiers(tree: ast.AST) -> Iterator[Finding]:
    """Yield banned names that are bound here; names that others bind are theirs."""
    for node in ast.walk(tree):
        for name in bound(node):
            plain = name.strip("_")
            if plain in WORDS["identifiers"]:
                line = getattr(node, "lineno", 1)
                yield Finding(line, f"{name}: say {WORDS['identifiers'][plain]}")


def bound(node: ast.AST) -> Iterable[str]:
    """Return the names that a node binds."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        return [node.name]
    if isinstance(node, ast.arg):
        return [node.arg]
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
        return [node.id]
    if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
        return [node.attr]
    return []


def prose(tree: ast.AST, source: str) -> Iterator[Finding]:
    """Yield banned words of docstrings and comments."""
    texts = [(line, text) for line, text in docstrings(tree)]
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    texts.extend(
        (token.start[0], token.string) for token in tokens if token.type == tokenize.COMMENT
    )
    for word, replacement in WORDS["prose"].items():
        pattern = re.compile(rf"\b{word.replace('*', '[a-z]*')}\b", re.IGNORECASE)
        for line, text in texts:
            if match := pattern.search(text):
                yield Finding(line, f"{match[0]}: say {replacement}")


def openings(tree: ast.AST) -> Iterator[Finding]:
    """Yield docstrings that do not begin with a noun or a verb."""
    for line, text in docstrings(tree):
        if re.match(r"what\b", text, re.I):
            yield Finding(line, "a docstring begins with 'What': say what it is or does")


def docstrings(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text is not None:
                yield node.body[0].lineno, text


def signatures(tree: ast.AST) -> Iterator[Finding]:
    """Yield functions with too many positional parameters; compiled ones have no others."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.FunctionDef) or is_compiled(node):
            continue
        arguments = [*node.args.posonlyargs, *node.args.args]
        names = [each.arg for each in arguments if each.arg not in ("self", "cls")]
        if len(names) > PARAMETERS:
            yield Finding(node.lineno, f"{node.name} takes {len(names)} positional parameters")


def is_compiled(function: ast.FunctionDef) -> bool:
    named = {
        each.id if isinstance(each, ast.Name) else each.attr
        for decorator in function.decorator_list
        for each in ast.walk(decorator)
        if isinstance(each, ast.Name | ast.Attribute)
    }
    return any(name in _COMPILED for name in named)


def shared_names(sources: Mapping[str, str]) -> dict[str, list[str]]:
    """Return names of classes that several modules define, each with these modules."""
    owners: dict[str, list[str]] = defaultdict(list)
    for file, source in sources.items():
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ClassDef):
                owners[node.name].append(file)
    return {name: files for name, files in owners.items() if len(files) > 1}


def riddles(source: str) -> list[str]:
    """Return the names of tests that do not name a unit, a condition and an expected result."""
    names = (node.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef))
    return [name for name in names if name.startswith("test_") and _RIDDLE.fullmatch(name)]


def sources() -> dict[str, str]:
    files = (path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py")))
    return {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in files}


@pytest.mark.parametrize("file", sources())
def test_module_has_no_banned_words(file: str) -> None:
    faults = diagnostics((ROOT / file).read_text("utf-8"))
    assert [f"{file}:{line}: {message}" for line, message in faults] == []


@pytest.mark.parametrize("folder", ["tests", "distributions", "reproduction/tests"])
def test_names_of_tests_state_a_unit_and_a_result(folder: str) -> None:
    files = sorted((ROOT / folder).rglob("test_*.py"))
    found = {file.name: riddles(file.read_text("utf-8")) for file in files}
    assert {name: names for name, names in found.items() if names} == {}


@pytest.mark.parametrize(
    "name", ["modes", "it_is_listed", "what_rests_stays", "finds_what_is_there"]
)
def test_riddles_finds_a_name_without_a_unit(name: str) -> None:
    assert riddles(f"def test_{name}(): ...") == [f"test_{name}"]


@pytest.mark.parametrize("file", files())
def test_prose_of_a_file_keeps_within_its_limits(file: str) -> None:
    found = places(file, (ROOT / file).read_text("utf-8"))
    beyond = excess(Counter(place.measure for place in found), read_limits().get(file, {}))
    lines = [f"{file}:{p.line}: {p.measure}: {p.text}" for p in found if p.measure in beyond]
    assert lines == []


@pytest.mark.parametrize(
    ("name", "text", "measure"),
    [
        ("a.py", '"""A.\n\nArgs:\n    robot: of the stage.\n"""', "fragment"),
        ("a.py", '"""Return what moves."""', "headless clause"),
        ("a.py", "x = 1  # nobody reads it", "headless clause"),
        ("a.py", f'"""{"word " * 26}."""', "long sentence"),
        ("a.md", "Whoever reads it.", "headless clause"),
        ("a.md", "a " * 26, "long sentence"),
        ("a.md", "x" * 121, "long line"),
    ],
)
def test_places_finds_each_measure(name: str, text: str, measure: str) -> None:
    assert [place.measure for place in places(name, text)] == [measure]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.py", '"""A.\n\nArgs:\n    robot: Robot of the stage.\n    what: Noun.\n"""'),
        ("a.py", f'"""Return ``what``.\n\nText.\n\n    {"word " * 26}\n"""'),
        ("a.md", f"```\nwhat {'word ' * 26}\n```"),
        ("a.md", f"| {'word ' * 26} |"),
        ("a.md", f"- {'word ' * 20}\n- {'word ' * 20}"),
    ],
)
def test_places_skips_code_tables_and_names(name: str, text: str) -> None:
    assert places(name, text) == []


def test_excess_names_the_measures_beyond_their_limits() -> None:
    assert excess({"fragment": 2, "long line": 1}, {"fragment": 1, "long line": 1}) == ["fragment"]


def test_no_class_name_has_two_owners() -> None:
    assert shared_names(sources()) == {}


@pytest.mark.parametrize(
    ("source", "fault"),
    [
        ("found = 1", "found: say"),
        ("def f(self):\n    self._told = 1", "_told: say"),
        ("for found in (): ...", "found: say"),
        ("def f(meant): ...", "meant: say suggestion"),
        ("class School: ...", "School: say TrialRunner"),
        ('"""Lessons of a robot."""', "Lessons: say"),
        ("x = 1  # the wishes of all", "wishes: say"),
        ('def f():\n    """What is done."""', "begins with 'What'"),
        ('class A:\n    """what it is"""', "begins with 'What'"),
        ("def f(a, b, c, d, e, f, g, h, i): ...", "f takes 9 positional parameters"),
        ("def f(self, a, b, c, d, e, f, g, /, h, i=1): ...", "f takes 9 positional parameters"),
    ],
)
def test_diagnostics_of_a_faulty_module_name_the_fault(source: str, fault: str) -> None:
    assert any(fault in message for _, message in diagnostics(source))


@pytest.mark.parametrize(
    "source",
    [
        "from a import told\ntold()",
        "foundation = finder.found(1)",
        '"""Whatever is left."""',
        "def f(self, a, b, c, d, e, f, g, h): ...",
        "def f(a, b, *, c, d, e, f, g, h, i): ...",
        "@njit(cache=True)\ndef f(a, b, c, d, e, f, g, h, i): ...",
        "@numba.njit\ndef f(a, b, c, d, e, f, g, h, i): ...",
        "@compiled_once\ndef f(a, b, c, d, e, f, g, h, i): ...",
        "@compiled_sum\ndef f(a, b, c, d, e, f, g, h, i): ...",
    ],
)
def test_foreign_names_endings_and_compiled_functions_pass(source: str) -> None:
    assert diagnostics(source) == []


def test_shared_names_finds_a_class_name_with_two_owners() -> None:
    assert shared_names({"a": "class A: ...", "b": "class A: ...\nclass B: ..."}) == {
        "A": ["a", "b"]
    }
