"""Mistakes that cause YAML syntax errors, often before the place that libyaml reports."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import yaml

from cbdsl.yaml_text import characters
from cbdsl.yaml_text.repair.layout import find_shift

_NO_COLON = "could not find expected ':'"
_NO_MAPPING = "mapping values are not allowed in this context"
_NO_KEY = "did not find expected key"
_NO_ITEM = "did not find expected '-' indicator"
_NO_CONTENT = "did not find expected node content"
_NO_START = "did not find expected <document start>"
_NO_DIRECTIVE = "could not find expected directive name"
_NO_TOKEN = "found character that cannot start any token"
_ALIAS = "while scanning an alias"
# Errors that libyaml reports behind the mistake.
_OPEN = "found unexpected end of stream"
_LATE = (_NO_COLON, _OPEN)
_OPENED = {
    "did not find expected ',' or ']'": ("[", "]"),
    "did not find expected ',' or '}'": ("{", "}"),
}

_KEY = re.compile(r"\s*(?:- +)*(?P<key>[^\s:#][^:#]*):\s")
_TIGHT = re.compile(r"\s*(?:- +)*(?P<key>\w+):(?P<value>(?:[^\s:/]|/(?!/)).*)")
_FIRST = re.compile(r"\s*(?:- +)*(?P<key>\S+)")
_LONE_KEY = re.compile(r"\s*(?:- +)*(?P<key>\w+):\s*")
_OPENS = re.compile(r"\s*(?:- +)*\w+:? *(?:&\w+ +)?[{\[]")
_EQUALS = re.compile(r"\s*(?:- +)*(?P<key>[\w*-]+)\s*(?P<sign>:=|=>|->|=|;)\s*(?P<value>.*)")
_COMMENT = re.compile(r"\s*(?P<sign>//|--|;|%)\s*(?P<text>.*)")
_STATE_IN_BRACKETS = re.compile(r"\s*(?P<state>[\[({][X01*,\s-]+[\])}])\s*:(?=\s)")
_UNQUOTED_KEY = re.compile(r"(?P<text>[^\s:#]+)(?=\s*:(?:\s|$))")
_UNQUOTED = re.compile(r"(?P<text>[^,\[\]{}#]*[^,\[\]{}#\s])")
_ROW = re.compile(r"\[[^\[\]{}]*\]")
_BEGINS = re.compile(r"\s*(?:- |---|\.\.\.|(?:- +)*['\"]?[\w$*-]+['\"]?:(?:\s|$))")
_FENCE = re.compile(r"\s*(?:```|~~~)\w*\s*\Z")
# Most words of a line that may be a key and its value.
_LONGEST_ENTRY = 7
_NO_PROSE = re.compile(r"[\[{◁]|<\|")


class TextCorrection(NamedTuple):
    """Probable mistake in a text.

    Attributes:
        problem: Message, as a clause.
        line: Line number, from 1.
        column: Column of its first character, from 1.
        code: Code in the catalogue of diagnostics.
        lines: Corrected lines by number from 1, if the correction is certain.
    """

    problem: str
    line: int
    column: int
    code: str = "CB104"
    lines: Mapping[int, str] = {}

    def mended(self, lines: Sequence[str]) -> list[str]:
        """Return all lines of the text with the mistake corrected."""
        return [self.lines.get(number, line) for number, line in enumerate(lines, 1)]


class _ReportedError(NamedTuple):
    """Syntax error as libyaml reports it.

    Attributes:
        problem: Message of libyaml.
        context: Context that libyaml reports.
        lines: Lines of the text.
        line: Line number, from 1.
        column: Column, from 1.
        opened: Line and column at which the enclosing structure begins, from 1.
    """

    problem: str
    context: str
    lines: Sequence[str]
    line: int
    column: int
    opened: tuple[int, int]

    @property
    def text(self) -> str:
        """Text of the line."""
        return self.lines[self.line - 1]

    @property
    def before(self) -> str:
        """Text in front of the place in its line."""
        return self.text[: self.column - 1]

    @property
    def rest(self) -> str:
        """Text from the place to the end of its line."""
        return self.text[self.column - 1 :]

    @property
    def above(self) -> int:
        """Number of the nearest non-blank, non-comment line above, or 0."""
        numbers = range(self.line - 1, 0, -1)
        return next((n for n in numbers if not re.match(r"\s*(#|$)", self.lines[n - 1])), 0)

    @property
    def at_end(self) -> bool:
        """True if only comments and empty lines follow in the text."""
        left = [self.rest, *self.lines[self.line :]]
        return all(re.match(r"\s*(#|$)", line) for line in left)

    @property
    def is_outside(self) -> bool:
        """True if an entry begins on this line and is indented too little to be within brackets."""
        row = self.opened[0]
        indents = [len(text) - len(text.lstrip()) for text in (self.text, self.lines[row - 1])]
        return row < self.line and indents[0] <= indents[1] and _BEGINS.match(self.text) is not None

    def instead(self, line: str) -> Mapping[int, str]:
        """Return the correction that replaces this line by another."""
        return {self.line: line}


def find_correction(error: yaml.MarkedYAMLError, lines: Sequence[str]) -> TextCorrection:
    """Return the mistake that causes a syntax error, or else libyaml's message.

    Args:
        error: Error of libyaml.
        lines: Lines of the text.
    """
    # libyaml may report an error after the last line.
    reported = _trouble(error, [*lines, ""])
    corrections = (
        (explain(reported) for explain in _EXPLANATIONS) if reported.line <= len(lines) + 1 else ()
    )
    correction = next((correction for correction in corrections if correction is not None), None)
    return correction or TextCorrection(reported.problem, reported.line, reported.column)


def _trouble(error: yaml.MarkedYAMLError, lines: Sequence[str]) -> _ReportedError:
    problem = error.problem or error.context or "no YAML"
    start = error.context_mark or error.problem_mark
    # A key that lacks its colon is noticed only on the next line, an open quote at the end.
    mark = start if problem in _LATE else error.problem_mark or start
    place = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    opened = (start.line + 1, start.column + 1) if start else place
    return _ReportedError(problem, error.context or "", lines, *place, opened)


def _tab(reported: _ReportedError) -> TextCorrection | None:
    if reported.rest[:1] != "\t":
        return None
    return TextCorrection("a tab", reported.line, reported.column, "CB117")


def _look_alike(reported: _ReportedError) -> TextCorrection | None:
    """Detect a look-alike of a space, a bullet or a colon, in this line or the one above."""
    for number in (reported.line, reported.above):
        line = reported.lines[number - 1]
        suggestion = characters.suggested_line(line) if number else None
        if suggestion is not None:
            problem = characters.look_alike_message(line, suggestion)
            column = characters.first_look_alike(line) + 1
            return TextCorrection(problem, number, column, "CB123", {number: suggestion})
    return None


def _fence(reported: _ReportedError) -> TextCorrection | None:
    if not _FENCE.match(reported.text):
        return None
    problem = "this line marks a block of code in a text, and is not a part of it; delete it"
    fences = (n for n, line in enumerate(reported.lines, 1) if _FENCE.match(line))
    return TextCorrection(problem, reported.line, 1, lines=dict.fromkeys(fences, ""))


def _unquoted(reported: _ReportedError) -> TextCorrection | None:
    """Detect an unquoted text that begins with a sign of YAML."""
    if reported.context == _ALIAS:
        line, column = reported.opened
    elif reported.problem == _NO_TOKEN:
        line, column = reported.line, reported.column
    else:
        return None
    text = reported.lines[line - 1]
    before, rest = text[: column - 1], text[column - 1 :]
    if state := _STATE_IN_BRACKETS.match(text):
        return _state_in_brackets(state, line)
    key = _UNQUOTED_KEY.match(rest)
    match = key or _UNQUOTED.match(rest)
    if match is None:
        return None
    quoted = f"'{match['text'].strip('`')}'"
    problem = f"a text that begins with '{rest[0]}' must be quoted; write {quoted}"
    # Only the schema can decide whether a value may begin with such a sign.
    is_certain = key is not None or rest[0] == "`"
    mended = {line: before + quoted + rest[match.end() :]} if is_certain else {}
    return TextCorrection(problem, line, column, "CB124", mended)


def _state_in_brackets(state: re.Match[str], line: int) -> TextCorrection:
    letters = re.sub(r"[^X01*-]", "", state["state"])
    text = f"{state.string[: state.start('state')]}'{letters}'{state.string[state.end('state') :]}"
    problem = f"a state has no brackets and no commas; write '{letters}'"
    return TextCorrection(problem, line, state.start("state") + 1, "CB124", {line: text})


def _after_the_end(reported: _ReportedError) -> TextCorrection | None:
    """Detect text after a bracket or a quote that closes a value."""
    before, rest = reported.before.rstrip(), reported.rest.rstrip()
    if reported.problem not in (_NO_KEY, _NO_ITEM) or before[-1:] not in ("]", "}", "'", '"'):
        return None
    if rest in (",", ";"):
        problem = f"leave out the '{rest}' at the end of the line"
        return TextCorrection(
            problem, reported.line, reported.column, lines=reported.instead(before)
        )
    if set(rest) <= {"]", "}"}:
        problem = f"unmatched '{rest}'; remove it"
        return TextCorrection(
            problem, reported.line, reported.column, lines=reported.instead(before)
        )
    problem = (
        f"'{rest}' cannot follow the '{before[-1]}', which ends the value; a unit stands behind "
        "each number, and a comment behind ' #'"
    )
    return TextCorrection(problem, reported.line, reported.column)


def _row_in_text(reported: _ReportedError) -> TextCorrection | None:
    """Detect a text within braces that holds a row, such as a displaced reference."""
    if reported.problem not in _OPENED:
        return None
    row = _ROW.match(reported.rest)
    # Text that continues with a row, as a displaced reference does.
    text = reported.before[_after_signs(reported.before) :].lstrip()
    if row is None or len(text.rstrip(" ")) < 2 or text.rstrip(" ")[-1] not in "+-":
        return None
    start = len(reported.before) - len(text)
    quoted = f'"{text}{row[0]}"'
    line = reported.before[:start] + quoted + reported.rest[row.end() :]
    problem = f"within braces, a text with brackets must be quoted; write {quoted}"
    return TextCorrection(problem, reported.line, start + 1, "CB124", reported.instead(line))


def _after_signs(text: str) -> int:
    """Return the place behind the last sign of YAML that ends a text within braces."""
    return max(text.rfind(sign) for sign in ",[]{}:") + 1


def _within_brackets(reported: _ReportedError) -> TextCorrection | None:
    """Detect an unclosed bracket, or a missing comma within brackets."""
    if reported.problem not in _OPENED:
        return None
    opening, closing = _OPENED[reported.problem]
    line, column = reported.opened
    at = reported.rest[:1]
    if at in ("]", "}"):
        problem = f"this '{at}' does not close the '{opening}' in line {line}; write '{closing}'"
        return TextCorrection(problem, reported.line, reported.column)
    # In [${gain}], the brace begins a mapping within the text.
    if reported.before.endswith("$"):
        problem = "a parameter is written without braces, as $name"
        return TextCorrection(problem, reported.line, reported.column)
    if reported.at_end or reported.is_outside:
        problem = f"this '{opening}' is never closed; a '{closing}' is missing"
        return TextCorrection(problem, line, column)
    problem = "a ',' is missing before this"
    if at == ":":
        problem += " key, or the text before it holds ': ' and needs quotes"
    if ";" in reported.before:
        problem = "in brackets values are parted by ',', not by ';'"
    return TextCorrection(problem, reported.line, reported.column)


def _open_quote(reported: _ReportedError) -> TextCorrection | None:
    if reported.problem != _OPEN:
        return None
    return TextCorrection("this quote is never closed", reported.line, reported.column)


def _directive(reported: _ReportedError) -> TextCorrection | None:
    return _comment(reported) if reported.problem == _NO_DIRECTIVE else None


def _comment(reported: _ReportedError) -> TextCorrection | None:
    """Detect a line that is a comment in other languages."""
    match = _COMMENT.match(reported.text)
    if match is None:
        return None
    problem = f"comments begin with '#', not with '{match['sign']}'; write '# {match['text']}'"
    return TextCorrection(
        problem, reported.line, match.start("sign") + 1, lines=reported.instead("")
    )


def _colon(reported: _ReportedError) -> TextCorrection | None:
    """Detect a key without its colon, or a colon without its space."""
    if reported.problem == _NO_COLON:
        return _comment(reported) or _no_colon(reported.lines, reported.line)
    if reported.problem != _NO_KEY:
        return None
    rows = [
        n for n in (reported.line, reported.line - 1) if n and _OPENS.match(reported.lines[n - 1])
    ]
    corrections = (_no_colon(reported.lines, n) for n in rows)
    return next(
        (correction for correction in corrections if correction), None
    ) or _colon_before_comment(reported)


def _colon_before_comment(reported: _ReportedError) -> TextCorrection | None:
    """Detect a line that lacks its colon before a comment, which ends a text."""
    number = reported.above
    between = reported.lines[number : reported.line - 1]
    text, sign, _ = reported.lines[number - 1].partition(" #") if number else ("", "", "")
    is_commented = bool(sign) or any(line.lstrip()[:1] == "#" for line in between)
    if not is_commented or not text.strip() or _KEY.match(f"{text} "):
        return None
    return _no_colon([*reported.lines[: number - 1], text], number)


def _no_colon(lines: Sequence[str], line: int) -> TextCorrection | None:
    """Detect a line whose key lacks its colon or the space after it."""
    return _sign_of_key(lines[line - 1], line) or _bare_word(lines, line)


def _sign_of_key(text: str, line: int) -> TextCorrection | None:
    """Detect a colon without its space, or another sign in its place."""
    if tight := _TIGHT.match(text):
        key, value = tight["key"], tight["value"].strip()
        problem = f"a space is missing after the ':' of '{key}'; write '{key}: {value}'"
        return TextCorrection(problem, line, tight.end("key") + 1)
    if equals := _EQUALS.match(text):
        key, sign, value = equals["key"], equals["sign"], equals["value"].strip()
        problem = f"a ':' is missing after '{key}'; write '{key}: {value}', without '{sign}'"
        return TextCorrection(problem, line, equals.end("key") + 1)
    return None


def _bare_word(lines: Sequence[str], line: int) -> TextCorrection | None:
    """Detect a word without a sign after it: a key, an item, or the continuation of a text."""
    text = lines[line - 1]
    first = _FIRST.match(text)
    if first is None or first["key"].endswith(":"):
        return None
    word, start = first["key"], first.start("key") + 1
    if re.match(r"-\w", word):
        return TextCorrection(
            f"a space is missing after the '-'; write '- {word[1:]}'", line, start
        )
    if _is_prose(text):
        problem = "a text over several lines begins with '>-' behind its key, and is indented below"
        return TextCorrection(problem, line, start)
    above = _LONE_KEY.fullmatch(lines[line - 2]) if line > 1 else None
    value = f", or '{text.strip()}' belongs behind '{above['key']}:'" if above else ""
    return TextCorrection(f"a ':' is missing after '{word}'{value}", line, first.end("key") + 1)


def _is_prose(line: str) -> bool:
    """Return whether a line continues a text: it is indented and has more words than an entry."""
    words = line.partition(" #")[0].split()
    return line[:1] == " " and len(words) > _LONGEST_ENTRY and not _NO_PROSE.search(line)


def _second_colon(reported: _ReportedError) -> TextCorrection | None:
    """Detect a text on the line of its key that holds a colon and a space."""
    if reported.problem != _NO_MAPPING:
        return None
    line, text = reported.line, reported.text
    key = _KEY.match(reported.before)
    if key is None:
        return _no_colon(reported.lines, line) if _TIGHT.match(text) else None
    first, _, rest = key["key"].partition(" ")
    if re.match(r"(&\w+ +)?[{\[]", rest):
        return TextCorrection(
            f"a ':' is missing after '{first}'", line, key.start("key") + len(first) + 1
        )
    if re.match(r"= *[{\[]", rest):
        return _no_colon(reported.lines, line)
    value = text[key.end() :].strip()
    if value.startswith("(") and value.endswith(")"):
        problem = f"a mapping is written in braces; write '{key['key']}: {{{value[1:-1]}}}'"
        return TextCorrection(problem, line, key.end() + 1)
    return _two_keys(reported, key, value)


def _two_keys(reported: _ReportedError, key: re.Match[str], value: str) -> TextCorrection:
    problem = f"a text that holds ': ' needs quotes; write '{key['key']}: \"{value}\"'"
    # In "arm: left gain: 3", the word before the second colon is probably a key.
    if second := re.fullmatch(r"\s*\S+?,?\s+(?P<key>[a-z_]+)", reported.before[key.end() :]):
        name = second["key"]
        problem = f"two keys are in one line: '{name}' begins a line of its own, or {problem[2:]}"
    return TextCorrection(problem, reported.line, reported.column)


def _indentation(reported: _ReportedError) -> TextCorrection | None:
    """Detect a line that is indented differently from its neighbours."""
    if reported.problem not in (_NO_KEY, _NO_ITEM, _NO_MAPPING):
        return None
    shift = find_shift(reported.lines, reported.line)
    return shift and TextCorrection(shift.problem, shift.line, shift.column, "CB121", shift.lines)


def _colon_above(reported: _ReportedError) -> TextCorrection | None:
    """Detect a line that lacks its colon and is read as a continuation of the text above it."""
    number = reported.above
    is_no_key = number and not _KEY.match(f"{reported.lines[number - 1]} ")
    is_text = reported.problem == _NO_MAPPING and is_no_key
    return _no_colon(reported.lines, number) if is_text else None


def _never_closed(reported: _ReportedError) -> TextCorrection | None:
    """Detect an unclosed bracket at the end of a text."""
    line = reported.above
    before = reported.lines[line - 1].partition(" #")[0].rstrip()
    closing = {"[": "]", "{": "}"}.get(before[-1:])
    if closing is None:
        return None
    problem = f"this '{before[-1]}' is never closed; a '{closing}' is missing"
    return TextCorrection(problem, line, len(before))


def _missing_value(reported: _ReportedError) -> TextCorrection | None:
    if reported.problem != _NO_CONTENT:
        return None
    if reported.at_end:
        return _never_closed(reported)
    at = reported.rest[:1]
    problem = f"a value is missing before this '{at}', or the '{at}' is one too many"
    return TextCorrection(problem, reported.line, reported.column)


def _before_the_document(reported: _ReportedError) -> TextCorrection | None:
    """Detect a line before or after the document that forms a second document."""
    if reported.problem != _NO_START:
        return None
    number = reported.above or reported.line
    if reported.lines[number - 1].startswith("..."):
        return TextCorrection("'...' ends the document; leave it out", number, 1)
    problem = "only a comment can stand before or behind the keys of a document; delete this line"
    return TextCorrection(problem, number, 1)


# Each function tests one hypothesis about the mistake, and the first one that applies is reported.
# The order matters. Signs that are wrong in every context come first. Functions for the same
# messages of libyaml go from the specific to the general, such as from a row in a text to any
# bracket. Indentation comes late, because most syntax errors disturb the levels of the lines around
# them.
_EXPLANATIONS = (
    _tab,
    _look_alike,
    _fence,
    _unquoted,
    _directive,
    _colon,
    _after_the_end,
    _row_in_text,
    _within_brackets,
    _open_quote,
    _second_colon,
    _colon_above,
    _indentation,
    _missing_value,
    _before_the_document,
)
