"""Write the tables of docs/reference.md: the parts of programs, documents and ``cb``.

The build of the site inserts them (docs/site_hooks.py). Equal code gives equal tables.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import typer

from cbdsl.cli.commands import COMMANDS
from cbdsl.cli.main import build_app
from cbdsl.diagnostics.entry import Entry
from cbdsl.documents.json_schema import json_schema, meaning, properties
from cbdsl.documents.kinds import entries, models
from cbdsl.documents.robot import RobotDocument
from cbdsl.learning.learner import LEARNERS, LearnerClass, first_line
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.resources import resources
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.types.casts import CASTS, Cast
from cbdsl.types.potential import POTENTIALS, PotentialType
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import TYPES
from cbdsl.types.unit import UNITS
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[1]

Rows = Iterable[Sequence[object]]


def page() -> str:
    """Return the generated part of the page."""
    parts = (_types, _potentials, _dexter, _units, _commands, _learners, _documents, _diagnostics)
    return "\n".join(part() for part in parts)


def _section(level: int, title: str, *parts: str) -> str:
    return "\n".join([f"{'#' * level} {title}\n", *parts])


def _table(head: Sequence[str], rows: Rows) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(map(_cell, line)) + " |\n" for line in lines)


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else ""
    return str(value).replace("|", "\\|").replace("*(", "\\*(")


def _code(text: object) -> str:
    return f"`{text}`"


def _types() -> str:
    types = ((_code(t.name), t.space, t.dimension or "n", t.unit) for t in TYPES.values())
    casts = (
        (_factors(cast), cast.name, cast.target, _carried(cast), cast.equation) for cast in CASTS
    )
    return "\n".join(
        [
            _section(
                2,
                "Types and casts",
                "The types of signals (Table 3.1), and the casts between them.\n",
                _table(("type", "space", "components", "unit"), types),
            ),
            _table(("from", "cast", "to", "carries", "defined by"), casts),
        ]
    )


def _factors(cast: Cast) -> str:
    return cast.source if cast.factors == 1 else f"{cast.source} x {cast.factors}"


def _carried(cast: Cast) -> str:
    return "values" if cast.value else "displacements"


def _potentials() -> str:
    head = ("potential", "defined by", "feedback", "reference", "minimum is 0")
    navigation = ("potential", "analytic", "polar", "admissible", "Morse", "for")
    signatures = (
        (
            _code(each.name),
            f"{each.symbol}, {each.equation}",
            _accepted(each),
            each.reference,
            each.zero_minimum,
        )
        for each in POTENTIALS.values()
    )
    conditions = ((_code(each.name), *each.navigation) for each in POTENTIALS.values())
    return "\n".join(
        [
            _section(2, "Potentials", _table(head, signatures)),
            "Which conditions of a navigation function each meets, and for which feedback:\n",
            _table(navigation, conditions),
        ]
    )


def _accepted(potential: PotentialType) -> str:
    """Return the types that a potential is defined on, in the order of Table 3.1."""
    if potential.accepts == set(TYPES):
        return "any"
    several = f" x {potential.factors}" if (potential.factors or 1) > 1 else ""
    return ", ".join(f"{name}{several}" for name in TYPES if name in potential.accepts)


def _dexter() -> str:
    """Dexter's resources by pattern: each name that differs in one kind of word only."""
    library = Library(ROOT)
    file = library.locate(RobotDocument, "dexter")
    robot = library.read(file, RobotDocument).document
    model = read_urdf(file.parent / robot.model)
    words = _placeholders(robot)
    patterns: dict[str, list[Resource]] = {}
    for resource in resources(robot, model).values():
        pattern = ".".join(_placeholder(word, words) for word in resource.name.split("."))
        patterns.setdefault(pattern, []).append(resource)
    head = ("resource", "type", "unit", "origin", "can be moved", "how many")
    rows = (
        (
            _code(pattern),
            ", ".join(dict.fromkeys(_any_size(str(each.type)) for each in found)),
            found[0].type.unit,
            found[0].origin.value,
            found[0].movable,
            len(found),
        )
        for pattern, found in patterns.items()
    )
    names = ((_code(f"<{word}>"), ", ".join(map(_code, each))) for word, each in words.items())
    return "\n".join(
        [
            _section(
                2,
                "Resources of Dexter",
                "`cb show resources` lists every name, `--robot NAME` those of another robot.\n",
                _table(head, rows),
            ),
            _table(("word", "stands for"), names),
        ]
    )


def _placeholders(robot: RobotDocument) -> dict[str, list[str]]:
    """Return the words that each placeholder in the names of a robot's resources stands for."""
    effectors = robot.effectors
    postures = [name for effector in effectors.values() for name in effector.postures]
    fingers = [finger for cells in robot.load_cells.values() for finger in cells]
    channels = [*channel_names(robot.vision.channels), *robot.vision.channels.aliases]
    hands = list(robot.load_cells)
    words = {
        "arm": [name for name, effector in effectors.items() if effector.tip],
        "hand": hands,
        "group": list(robot.groups),
        "posture": postures,
        "finger": fingers,
        "camera": list(robot.cameras),
        "channel": channels,
    }
    return {word: list(dict.fromkeys(names)) for word, names in words.items()}


def _placeholder(word: str, words: Mapping[str, Sequence[str]]) -> str:
    return next((f"<{name}>" for name, known in words.items() if word in known), word)


def _any_size(kind: str) -> str:
    return re.sub(r"\[\d+\]", "[n]", kind)


def _units() -> str:
    dimensions = dict.fromkeys(unit.dimension for unit in UNITS.values())
    rows = []
    for dimension in dimensions:
        si, *others = (unit for unit in UNITS.values() if unit.dimension == dimension)
        written = (
            _code(u.symbol) if u.factor == 1 else f"`{u.symbol}` ({u.factor:.6g})" for u in others
        )
        rows.append((dimension, _code(si.symbol), ", ".join(written)))
    return _section(
        2,
        "Units",
        "A number without a unit is in the first one; in brackets, how much of it others are.\n",
        _table(("quantity", "unit", "others"), rows),
    )


def _commands() -> str:
    app = typer.main.get_command(build_app(COMMANDS.builtins))
    parts = [_command(name, command) for name, command in _leaves("cb", app)]
    words = (
        "Each has `--help`. Brackets hold optional arguments and defaults.\n"
        "Other packages [add commands](how_to/new_command.md), such as `cb reproduce` and "
        "`cb judge` of cbdsl-reproduction.\n"
    )
    return _section(2, "Commands", words, *parts)


def _leaves(name: str, command: Any) -> Iterator[tuple[str, Any]]:
    """Yield all commands without subcommands, with their full names."""
    if not hasattr(command, "commands"):
        yield name, command
        return
    for word, each in command.commands.items():
        yield from _leaves(f"{name} {word}", each)


def _command(name: str, command: Any) -> str:
    given = [each for each in command.params if each.name != "help"]
    typed = [_typed(each) for each in given if each.param_type_name == "argument"]
    paragraphs = (textwrap.fill(part, 110) for part in (command.help or "").split("\n\n"))
    words = "".join(f"{part}\n\n" for part in paragraphs)
    rows = [(_code(_typed(each)), each.help, _preset(each)) for each in given]
    return _section(
        3, _code(" ".join([name, *typed])), words + _table(("argument", "meaning", "default"), rows)
    )


def _typed(parameter: Any) -> str:
    """Return an argument as a word in capitals, or all spellings of an option."""
    if parameter.param_type_name == "option":
        return ", ".join([*parameter.opts, *parameter.secondary_opts])
    word = parameter.metavar or parameter.name.upper()
    word += "..." if parameter.nargs == -1 else ""
    return word if parameter.required else f"[{word}]"


def _preset(parameter: Any) -> str:
    """Return the default value of an option."""
    value = getattr(parameter.default, "value", parameter.default)
    if parameter.required:
        return "required"
    if value is None or value is False or value == [] or callable(value):
        return ""
    return _code(parameter.opts[0] if value is True else value)


def _learners() -> str:
    words = "Learners of `cb learn --learner`, with the constants of each for `--set`.\n"
    return _section(2, "Learners", words, *(_learner(*each) for each in LEARNERS.all().items()))


def _learner(name: str, learner: LearnerClass) -> str:
    rows = (
        (_code(key), *_meaning(value), _filled(value, needed=False))
        for key, value in properties(learner.Constants).items()
    )
    table = _table(("constant", "meaning", "unit", "default"), rows)
    return _section(3, f"Learner {name}", first_line(learner) + "\n", table)


def _documents() -> str:
    words = "Every key of every kind, with links to the keys of its sections.\n"
    return _section(2, "Documents", words, *(_kind(kind) for kind in models()))


def _kind(kind: str) -> str:
    schema = _schema(kind)
    sections = {
        name: each for name, each in schema["$defs"].items() if each.get("type") == "object"
    }
    parts = [_keys(4, f"{kind}: {each['title']}", each, kind) for each in sections.values()]
    return "\n".join([_keys(3, f"Kind {kind}", schema, kind), *parts])


@cache
def _schema(kind: str) -> dict[str, Any]:
    return json_schema(models()[kind])


def _keys(level: int, title: str, schema: Mapping[str, Any], kind: str) -> str:
    needed = schema.get("required", ())
    rows = (
        (_code(key), *_meaning(value), _shape(value, kind), _filled(value, key in needed))
        for key, value in schema["properties"].items()
    )
    head = ("key", "meaning", "unit", "value", "default")
    return _section(level, title, schema["description"] + "\n", _table(head, rows))


def _meaning(value: Mapping[str, Any]) -> tuple[str, str]:
    """Return the description of a key, and its SI units."""
    words, symbols = meaning(value)
    return words, ", ".join(map(_code, symbols.split(", "))) if symbols else ""


def _filled(value: Mapping[str, Any], needed: bool) -> str:
    if needed:
        return "required"
    default = value.get("default")
    return "" if default in (None, "", {}, []) else _code(json.dumps(default))


_WORDS = {"string": "text", "boolean": "`true`, `false`", "integer": "whole number"}


def _shape(value: Mapping[str, Any], kind: str) -> str:
    """Return the form of a value: a word, a list of words, or a link to a section."""
    if "$ref" in value:
        return _named(value["$ref"].rpartition("/")[2], kind)
    for one_of in ("anyOf", "oneOf"):
        if one_of in value:
            given = (each for each in value[one_of] if each != {"type": "null"})
            return " or ".join(dict.fromkeys(_shape(each, kind) for each in given))
    if "const" in value or "enum" in value:
        return ", ".join(map(_code, value.get("enum") or [value["const"]]))
    if "type" not in value:
        return "any value"
    if value["type"] == "array":
        count, item = value.get("maxItems"), _shape(value["items"], kind)
        item = f"({item})" if " or " in item else item
        return f"list of {f'{count} x ' if count else ''}{item}"
    if value["type"] == "object":
        return f"mapping to {_shape(value['additionalProperties'], kind)}"
    return _WORDS.get(value["type"], "number")


def _named(definition: str, kind: str) -> str:
    """Return a definition: a section of this kind, a name, or else a quantity."""
    schema = _schema(kind)["$defs"][definition]
    if schema.get("type") == "object":
        title = schema["title"]
        return f"[{title}](#{anchor(f'{kind}: {title}')})"
    return "name" if definition == "Name" else "quantity"


def _diagnostics() -> str:
    by_code = sorted(entries().values(), key=lambda entry: entry.code)
    rows = ((_diagnostic(entry), entry.title, entry.severity.value) for entry in by_code)
    words = "`cb explain CODE` explains one, with an example.\n"
    return _section(2, "Findings", words, _table(("code", "diagnostic", "severity"), rows))


def _diagnostic(entry: Entry) -> str:
    return f"[{entry.code}](diagnostics.md#{entry.code.lower()})"


def anchor(heading: str) -> str:
    """Return the anchor of a heading, which may state it as ``{#anchor}``."""
    if stated := re.search(r" \{#([\w-]+)\}$", heading):
        return stated[1]
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")
