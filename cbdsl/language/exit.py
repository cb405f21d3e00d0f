"""Exits of a step: the letters of its members for which another step follows.

when: way ("or" way)* | "otherwise"
way: part ("and" part)*
part: "not" CONDITION | TERM [["not"] WORD]

to: STEP | "succeed" | "end" | "fail" [REASON]
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

from cbdsl.language.expression import Span, Term
from cbdsl.language.parser import read_term
from cbdsl.language.scanner import CompositionError, Scanner
from cbdsl.types.state import LETTERS

#: Words for the letters of a member, by its kind.
WORDS: Mapping[str, Mapping[str, str]] = {
    "controller": {"undefined": "-", "moving": "0", "at rest": "1s", "arrived": "1", "stuck": "s"},
    "program": {"failed": "-", "running": "0", "succeeded": "1"},
    "condition": {"undefined": "-", "false": "0", "true": "1"},
}
#: Letters of each kind of member; only a controller has a tolerance.
OF_KIND = {"controller": LETTERS, "program": "-01", "condition": "-01"}
OTHERWISE = "otherwise"
#: Ends of a program by the words of a target.
ENDS = {"succeed": "success", "fail": "failure", "end": "end"}

_AND, _OR, _NOT = (re.compile(rf"{word}\b") for word in ("and", "or", "not"))
_OTHERWISE = re.compile(rf"{OTHERWISE}\s*\Z")
_WORD = re.compile(
    "|".join(sorted({w for words in WORDS.values() for w in words}, reverse=True)).replace(
        " ", r"\s+"
    )
    + r"\b"
)
_TO = re.compile(r"(?P<to>[A-Za-z][A-Za-z0-9_]*)(?:\s+(?P<reason>.*\S))?\s*", re.DOTALL)


class Clause(NamedTuple):
    """Letters of one member.

    Attributes:
        term: Member.
        word: Word for its letter; empty for a condition that holds.
        negated: True if the member has another letter.
        span: Span of the part.
    """

    term: Term
    word: str
    negated: bool
    span: Span

    def letters(self, kind: str) -> str | None:
        """Return the letters of a member of a kind; ``None`` if it has none of that word."""
        word = "true" if kind == "condition" and not self.word else self.word
        letter = WORDS[kind].get(word)
        if letter is None or not self.negated:
            return letter
        # A condition that does not hold is false; an undefined one is neither.
        if kind == "condition" and not self.word:
            return WORDS[kind]["false"]
        return "".join(other for other in OF_KIND[kind] if other not in letter)


#: Ways in which an exit holds, each a conjunction; one without parts always holds.
When = tuple[tuple[Clause, ...], ...]


class Target(NamedTuple):
    """Target of an exit.

    Attributes:
        name: Next step, or ``succeed``, ``fail`` or ``end``.
        reason: Reason of a failure, as a clause; may be empty.
    """

    name: str
    reason: str = ""

    def __str__(self) -> str:
        return f"{self.name} {self.reason}".rstrip()


@lru_cache(maxsize=1_000)
def parse_when(text: str) -> When:
    """Read the condition of an exit such as ``lift undefined and heavy not at rest``.

    Raises:
        CompositionError: The text is no such condition; the error has the place.
    """
    scanner = Scanner(text)
    if scanner.take(_OTHERWISE):
        return ((),)
    ways = [_way(scanner)]
    while scanner.take(_OR):
        ways.append(_way(scanner))
    if not scanner.is_at_end:
        words = (
            ()
            if ways[-1][-1].word
            else tuple(f"'{w}'" for w in (*WORDS["controller"], "failed", "running", "succeeded"))
        )
        raise scanner.error(*words, "'and'", "'or'", "the end")
    return tuple(ways)


def _way(scanner: Scanner) -> tuple[Clause, ...]:
    parts = [_part(scanner)]
    while scanner.take(_AND):
        parts.append(_part(scanner))
    return tuple(parts)


def _part(scanner: Scanner) -> Clause:
    start = scanner.next
    is_not = scanner.take(_NOT) is not None
    term = read_term(scanner)
    word = ""
    if not is_not:
        is_not = scanner.take(_NOT) is not None
        match = scanner.take(_WORD)
        if match is None and is_not:
            raise scanner.error(*(f"'{word}'" for word in WORDS["controller"]))
        word = " ".join(match[0].split()) if match else ""
    return Clause(term, word, is_not, Span(start + 1, scanner.read + 1))


def when_text(
    members: Sequence[str], box: Sequence[str], values: Sequence[str], kinds: Mapping[str, str]
) -> str:
    """Return the condition that members have some of their letters.

    Args:
        members: Members of a step.
        box: Letters of each of them.
        values: Letters that each of them can have at all.
        kinds: Kinds of the members; by default, they are controllers.
    """
    parts = []
    for member, letters, possible in zip(members, box, values, strict=True):
        if set(possible) <= set(letters):
            continue
        kind = kinds.get(member, "controller")
        word = _word(set(letters).intersection(possible), possible, kind)
        parts.append({"true": member, "false": f"not {member}"}.get(word, f"{member} {word}"))
    return " and ".join(parts) or OTHERWISE


def _word(letters: set[str], possible: str, kind: str) -> str:
    """Return the word for some of the letters that a member can have."""
    words = {word: set(own).intersection(possible) for word, own in WORDS[kind].items()}
    phrases = words | {f"not {word}": set(possible) - own for word, own in words.items()}
    return next(phrase for phrase, own in phrases.items() if own == letters)


def parse_target(text: str) -> Target:
    """Read the target of an exit such as ``carry`` or ``fail too heavy for the hand``.

    Raises:
        CompositionError: The text is no target; the error has the place.
    """
    match = _TO.fullmatch(text.strip())
    if match is None:
        raise Scanner(text).error("a step", "'succeed'", "'fail' with a reason", "'end'")
    to, reason = match["to"], " ".join((match["reason"] or "").split())
    if reason and to != "fail":
        start = text.index(reason.split()[0], text.index(to) + len(to)) + 1
        raise CompositionError("only 'fail' has a reason", Span(start, len(text) + 1))
    return Target(to, reason)
