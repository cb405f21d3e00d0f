"""Bounded parts that replace the library's own during the expansion of a model.

The library evaluates expressions with ``eval`` and takes time that grows with the square of a
text's length. It also reads the environment, opens every file that a model names, and expands
macros without a bound.
"""

from __future__ import annotations

import re
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any
from xml.dom import expatbuilder
from xml.parsers import expat

import xacro

from cbdsl.extend.model import MOST_BYTES, PackageFolders, UrdfError, contents, refuse_entities
from cbdsl_formats.budget import BudgetError, StepBudget
from cbdsl_formats.functions import functions
from cbdsl_formats.xacro_expression import ExpressionError, evaluate

_MOST_YAML_BYTES = 200_000
_ELEMENT_STEPS = 100  # for an element, in addition to its texts
# Longest text, because nested properties grow by a power with each level.
_MOST_TEXT = 1_000_000
# Pieces of a text, in the library's syntax. In "$${x}" the first dollar sign escapes the rest. An
# expression ends at its first closing brace and an extension at its first closing parenthesis, so
# that neither nests in its own kind.
_PIECES = re.compile(
    r"\$(?P<escaped>\$+[{(])|\$\{(?P<expression>[^}]*)\}|\$\((?P<extension>[^)]*)\)"
    r"|(?P<text>[^$]+|\$[^{($]+|\$$)"
)
# Key of an element's place, and functions of the library whose first argument is an element.
_PLACE = "place"
_OF_ELEMENTS = ("check_attrs", "reqd_attrs", "handle_macro_call")


class LibraryParts:
    """Parts for the expansion of one model.

    Args:
        arguments: Values by name; the model's own defaults are added.
        packages: Folders of packages, for ``$(find NAME)``.

    Attributes:
        refusals: Errors to report, which the library wraps in its own.
        place: File and line of the element that is expanded; empty before the first one.
    """

    def __init__(self, arguments: Mapping[str, str], packages: PackageFolders) -> None:
        self._arguments, self._packages = arguments, packages
        self._budget = StepBudget()
        self.refusals: list[Exception] = []
        self.place = ""
        self._library_eval_all: Callable[..., None] = xacro.eval_all
        self._library_load_yaml: Callable[[str], Any] = xacro.load_yaml
        self._functions = functions(
            {
                "arg": self._argument,
                "load_yaml": self._load_yaml,
                "abs_filename": xacro.abs_filename_spec,
            }
        )

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Replace the library's parts during the expansion of a model."""
        parts = {
            "_global_symbols": self._functions,
            "safe_eval": self._evaluate,
            "eval_text": self._eval_text,
            "eval_all": self._eval_all,
            "eval_extension": lambda s: self._substitute(s[2:-1]),
            "parse": self._parse,
            "get_include_files": self._included,
            **{name: self._placed(getattr(xacro, name)) for name in _OF_ELEMENTS},
        }
        # The library has no hooks, so its module's globals are replaced for the whole process
        # meanwhile. Two threads must not expand models at the same time.
        library = {name: getattr(xacro, name) for name in parts}
        vars(xacro).update(parts)
        try:
            yield
        finally:
            vars(xacro).update(library)

    def _placed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function of the library that first sets the place to that of its element."""

        def placed(elt: Any, *arguments: Any, **named: Any) -> Any:
            self.place = elt.getUserData(_PLACE) or self.place
            return function(elt, *arguments, **named)

        return placed

    @contextmanager
    def _reported(self) -> Iterator[None]:
        try:
            yield
        except (UrdfError, BudgetError, ExpressionError) as error:
            self.refusals.append(error)
            raise

    def _evaluate(
        self, expr: str, globals: Mapping[str, Any], locals: Mapping[str, Any] | None = None
    ) -> Any:
        try:
            return evaluate(expr, globals, self._budget)
        except ExpressionError as error:
            refusal = ExpressionError(f"expression '{expr.strip()}': {error}")
            self.refusals.append(refusal)
            raise refusal from None
        except BudgetError as error:
            self.refusals.append(error)
            raise

    def _eval_text(self, text: str, symbols: Mapping[str, Any]) -> Any:
        """Return the text with expressions and substitutions replaced, or a lone one's value."""
        results: list[Any] = []
        size, at = 0, 0
        while at < len(text):
            piece = _PIECES.match(text, at)
            if piece is None:
                raise ExpressionError(f"invalid expression: {text[at : at + 60]}")
            at = piece.end()
            result = self._piece(piece, symbols)
            size += len(result) if isinstance(result, str) else 1
            with self._reported():
                self._budget.spend(1 + len(piece[0]) // 100)
                if size > _MOST_TEXT:
                    raise BudgetError(f"a text has more than {_MOST_TEXT} characters")
            results.append(result)
        return results[0] if len(results) == 1 else "".join(map(str, results))

    def _piece(self, piece: re.Match[str], names: Mapping[str, Any]) -> Any:
        kind, text = piece.lastgroup, piece[piece.lastgroup or 0]
        # Substitutions inside an expression come first, as in ${2 * $(arg size)}.
        if kind == "expression":
            return self._evaluate(str(self._eval_text(text, names)), names)
        if kind == "extension":
            return self._substitute(str(self._eval_text(text, names)))
        return text

    def _eval_all(self, node: Any, macros: Any, symbols: Any) -> None:
        with self._reported():
            self._budget.spend(_ELEMENT_STEPS * (1 + len(node.childNodes)))
        outer = self.place
        self.place = node.getUserData(_PLACE) or outer
        self._library_eval_all(node, macros, symbols)
        self.place = outer  # an error leaves the place of the innermost element

    def _substitute(self, text: str) -> str:
        """Return the value of ``$(text)``."""
        command, *words = text.split() or [""]
        if command == "eval":
            return str(self._evaluate(text.strip()[len("eval") :], self._substitution_names()))
        commands: Mapping[str, tuple[int, Callable[..., str]]] = {
            "arg": (1, self._argument),
            "cwd": (0, lambda: str(Path.cwd())),
            "dirname": (0, lambda: str(Path(xacro.filestack[-1]).resolve().parent)),
            "env": (1, self._environment),
            "find": (1, self._find),
        }
        with self._reported():
            if command == "optenv":
                return " ".join(words[1:])
            if command not in commands or len(words) != commands[command][0]:
                known = ", ".join(sorted([*commands, "eval", "optenv"]))
                raise UrdfError(f"$({text}) is unknown (known: {known})")
            return commands[command][1](*words)

    def _substitution_names(self) -> Mapping[str, Any]:
        given = {name: _converted(value) for name, value in self._arguments.items()}
        own = functions({"arg": lambda name: _converted(self._argument(name))})
        return ChainMap({"true": True, "false": False, "arg": own["xacro"]["arg"]}, given, own)

    def _argument(self, name: str) -> str:
        with self._reported():
            try:
                return self._arguments[name]
            except KeyError:
                raise UrdfError(
                    f"argument '{name}' has no value; --xacro-arg {name}:=VALUE gives it one"
                ) from None

    def _environment(self, name: str) -> str:
        raise UrdfError(
            f"it reads the environment, $(env {name}), which models may not; write $(arg {name}) "
            f"and give --xacro-arg {name}:=VALUE"
        )

    def _find(self, name: str) -> str:
        return str(self._packages.folder(name))

    def _load_yaml(self, name: str) -> Any:
        """Return the contents of a YAML file without aliases, which can multiply its size."""
        path = Path(xacro.abs_filename_spec(name))
        with self._reported():
            if path.suffix not in (".yaml", ".yml"):
                raise UrdfError(f"load_yaml reads .yaml and .yml files, not {path}")
            data = _read(path, _MOST_YAML_BYTES)
            if re.search(rb"(?:^|[\s,\[{:-])[*]\w|<<", data):
                raise UrdfError(f"{path}: aliases and merge keys (*, <<) are not read from a model")
        self._budget.spend(5 * len(data))
        return _plain(self._library_load_yaml(name))

    def _parse(self, inp: Any, filename: str | None = None) -> Any:
        """Return the document of a file, whose elements know their places."""
        path = Path(xacro.root_dir, filename or "")
        try:
            data = _read(path, MOST_BYTES)
        except UrdfError as error:
            xacro.filestack.pop()
            raise xacro.XacroException(str(error), exc=FileNotFoundError()) from None
        try:
            with self._reported():
                refuse_entities(data, path)
                self._budget.spend(len(data) // 20)
            return _PlacedBuilder(path).parseString(data)
        except expat.ExpatError as error:
            self.place = f"{path}:{error.lineno}:{error.offset}"
            raise UrdfError(expat.errors.messages[error.code]) from None

    def _included(self, filename_spec: str, symbols: Mapping[str, Any]) -> Iterator[str]:
        """Yield the files of an include, whose last part may be a pattern."""
        path = Path(xacro.abs_filename_spec(str(self._eval_text(filename_spec, symbols))))
        if not any(sign in path.name for sign in "*?["):
            yield str(path)
        elif path.parent.is_dir():
            yield from sorted(
                str(file) for file in path.parent.iterdir() if fnmatchcase(file.name, path.name)
            )


class _PlacedBuilder(expatbuilder.ExpatBuilderNS):
    """Builder of documents whose elements know their file and line.

    Args:
        path: File of the document.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._path = path

    def start_element_handler(self, name: str, attributes: Any) -> None:
        super().start_element_handler(name, attributes)
        line = self.getParser().CurrentLineNumber
        self.curNode.setUserData(_PLACE, f"{self._path}:{line}", _CopiedPlace)


class _CopiedPlace:
    """Handler by which a copy, as of a macro's body, keeps the places of its elements."""

    @classmethod
    def handle(cls, _operation: int, key: str, data: str, _source: Any, copy: Any) -> None:
        """Set the place of a copied element."""
        copy.setUserData(key, data, cls)


def _read(path: Path, most: int) -> bytes:
    try:
        return contents(path, most)
    except (OSError, ValueError) as error:
        raise UrdfError(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def _converted(value: str) -> Any:
    """Return an argument as a number or truth value, if it is one."""
    if value.lower() in ("true", "false"):
        return value.lower() == "true"
    for kind in (int, float):
        try:
            return kind(value)
        except ValueError:
            continue
    return value


def _plain(value: Any) -> Any:
    """Return YAML's values as plain dictionaries and lists, without dotted access."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in dict.items(value)}
    if isinstance(value, list):
        return [_plain(part) for part in list.__iter__(value)]
    return value
