"""Keys without their colon, or with another sign in its place."""

from __future__ import annotations

import re
from collections.abc import Sequence

from cbdsl.yaml_text.repair.reported_error import (
    NO_COLON,
    NO_KEY,
    NO_MAPPING,
    ReportedError,
    TextCorrection,
)

KEY = re.compile(r"\s*(?:- +)*(?P<key>[^\s:#][^:#]*):\s")
_TIGHT = re.compile(r"\s*(?:- +)*(?P<key>\w+):(?P<value>(?:[^\s:/]|/(?!/)).*)")
_FIRST = re.compile(r"\s*(?:- +)*(?P<key>\S+)")
_LONE_KEY = re.compile(r"\s*(?:- +)*(?P<key>\w+):\s*")
_OPENS = re.compile(r"\s*(?:- +)*\w+:? *(?:&\w+ +)?[{\[]")
_EQUALS = re.compile(r"\s*(?:- +)*(?P<key>[\w*-]+)\s*(?P<sign>:=|=>|->|=|;)\s*(?P<value>.*)")
_COMMENT = re.compile(r"\s*(?P<sign>//|--|;|%)\s*(?P<text>.*)")
# Most words of a line that may be a key and its value.
_LONGEST_ENTRY = 7
# Signs of compositions, comparisons and references.
_NO_PROSE = re.compile(r"[\[{◁<>$]")


def foreign_comment(reported: ReportedError) -> TextCorrection | None:
    """Detect a line that is a comment in other languages."""
    match = _COMMENT.match(reported.text)
    if match is None:
        return None
    problem = f"comments begin with '#', not with '{match['sign']}'; write '# {match['text']}'"
    return TextCorrection(
        problem, reported.line, match.start("sign") + 1, lines=reported.instead("")
    )


def missing_colon(reported: ReportedError) -> TextCorrection | None:
    """Detect a key without its colon, or a colon without its space."""
    if reported.problem == NO_COLON:
        return foreign_comment(reported) or no_colon(reported.lines, reported.line)
    if reported.problem != NO_KEY:
        return None
    rows = [
        n for n in (reported.line, reported.line - 1) if n and _OPENS.match(reported.lines[n - 1])
    ]
    corrections = (no_colon(reported.lines, n) for n in rows)
    return next(
        (correction for correction in corrections if correction), None
    ) or _colon_before_comment(reported)


def _colon_before_comment(reported: ReportedError) -> TextCorrection | None:
    """Detect a line that lacks its colon before a comment, which ends a text."""
    number = reported.above
    between = reported.lines[number : reported.line - 1]
    text, sign, _ = reported.lines[number - 1].partition(" #") if number else ("", "", "")
    is_commented = bool(sign) or any(line.lstrip()[:1] == "#" for line in between)
    if not is_commented or not text.strip() or KEY.match(f"{text} "):
        return None
    return no_colon([*reported.lines[: number - 1], text], number)


def no_colon(lines: Sequence[str], line: int) -> TextCorrection | None:
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


def second_colon(reported: ReportedError) -> TextCorrection | None:
    """Detect a text on the line of its key that holds a colon and a space."""
    if reported.problem != NO_MAPPING:
        return None
    line, text = reported.line, reported.text
    key = KEY.match(reported.before)
    if key is None:
        return no_colon(reported.lines, line) if _TIGHT.match(text) else None
    first, _, rest = key["key"].partition(" ")
    if re.match(r"(&\w+ +)?[{\[]", rest):
        return TextCorrection(
            f"a ':' is missing after '{first}'", line, key.start("key") + len(first) + 1
        )
    if re.match(r"= *[{\[]", rest):
        return no_colon(reported.lines, line)
    value = text[key.end() :].strip()
    if value.startswith("(") and value.endswith(")"):
        problem = f"a mapping is written in braces; write '{key['key']}: {{{value[1:-1]}}}'"
        return TextCorrection(problem, line, key.end() + 1)
    return _two_keys(reported, key, value)


def _two_keys(reported: ReportedError, key: re.Match[str], value: str) -> TextCorrection:
    problem = f"a text that holds ': ' needs quotes; write '{key['key']}: \"{value}\"'"
    # In "arm: left gain: 3", the word before the second colon is probably a key.
    if second := re.fullmatch(r"\s*\S+?,?\s+(?P<key>[a-z_]+)", reported.before[key.end() :]):
        name = second["key"]
        problem = f"two keys are in one line: '{name}' begins a line of its own, or {problem[2:]}"
    return TextCorrection(problem, reported.line, reported.column)


def colon_above(reported: ReportedError) -> TextCorrection | None:
    """Detect a line that lacks its colon and is read as a continuation of the text above it."""
    number = reported.above
    is_no_key = number and not KEY.match(f"{reported.lines[number - 1]} ")
    is_text = reported.problem == NO_MAPPING and is_no_key
    return no_colon(reported.lines, number) if is_text else None
