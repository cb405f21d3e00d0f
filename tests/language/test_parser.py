"""Compositions: round trips, and where a text stops being one."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.language.expression import Argument, Expression, Span, Term
from cbdsl.language.parser import parse
from cbdsl.language.scanner import CompositionError

NAMES = st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,8}", fullmatch=True)
ARGUMENTS = st.from_regex(
    r"\$?[A-Za-z][A-Za-z0-9_]{0,5}(\.\$?[A-Za-z0-9_]{1,5}){0,2}", fullmatch=True
)
NOWHERE = Span(1, 1)
TERMS = st.builds(
    lambda name, arguments: Term(name, tuple(Argument(a, NOWHERE) for a in arguments), NOWHERE),
    NAMES,
    st.lists(ARGUMENTS, max_size=3),
)
EXPRESSIONS = st.builds(
    lambda terms: Expression(tuple(terms)), st.lists(TERMS, min_size=1, max_size=5)
)


def bare(expression: Expression) -> list[tuple[str, list[str]]]:
    """Return an expression without its spans."""
    return [(term.name, [a.text for a in term.arguments]) for term in expression.terms]


@given(EXPRESSIONS)
def test_printed_composition_parses_to_itself(expression: Expression) -> None:
    assert bare(parse(str(expression))) == bare(expression)


@given(EXPRESSIONS, st.sampled_from(["<|", " <| ", "◁", "  ◁\n"]))
def test_every_spelling_prints_the_same_composition(expression: Expression, operator: str) -> None:
    text = operator.join(str(term) for term in expression.terms)
    assert str(parse(text)) == str(expression)


@given(EXPRESSIONS)
def test_spans_cover_the_names_in_the_text(expression: Expression) -> None:
    text = str(expression)
    for term in parse(text).terms:
        assert text[term.span.start - 1 : term.span.end - 1] == term.name
        for argument in term.arguments:
            assert text[argument.span.start - 1 : argument.span.end - 1] == argument.text


NAME, ARGUMENT = r"[A-Za-z]\w*", r"\$?[A-Za-z]\w*(\.\$?\w+)*"
TERM = rf"\s*{NAME}\s*(\(\s*{ARGUMENT}\s*(,\s*{ARGUMENT}\s*)*\)\s*)?"
COMPOSITION = re.compile(rf"{TERM}((◁|<\|){TERM})*", re.ASCII)
# Pieces of compositions in any order: mostly none, often nearly one.
PIECES = st.lists(
    st.sampled_from(
        ["a", "b1", "_", "1", "$x", "p.q", ".", "(", ")", ",", "◁", "<|", "<", " ", "\n"]
    ),
    max_size=8,
).map("".join)


@given(EXPRESSIONS.map(str) | PIECES)
def test_language_is_that_of_one_regular_expression(text: str) -> None:
    try:
        parse(text)
    except CompositionError as error:
        assert not COMPOSITION.fullmatch(text), error
    else:
        assert COMPOSITION.fullmatch(text)


@given(st.text(max_size=12))
def test_any_other_text_is_a_located_error(text: str) -> None:
    try:
        parse(text)
    except CompositionError as error:
        assert 1 <= error.span.start <= len(text) + 1
        assert error.span.start < error.span.end


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("", 1, "expected a name at the end"),
        ("a ◁", 4, "expected a name at the end"),
        ("◁ a", 1, "expected a name, found '◁'"),
        ("a b", 3, "expected '(' or '◁' or the end, found 'b'"),
        ("a ⊲ b", 3, "'⊲' is not the subject-to operator: write '◁', or '<|' in ASCII"),
        ("a << b", 3, "'<<' is not the subject-to operator: write '◁', or '<|' in ASCII"),
        (
            "a |> b",
            3,
            "'|>' is not the subject-to operator: 'b ▷ a' is written 'a ◁ b', or 'a <| b' in ASCII",
        ),
        ("⊲ b", 1, "expected a name, found '⊲'"),
        ("a()", 3, "expected an argument, found ')'"),
        ("a(b", 4, "expected ')' or ',' at the end"),
        ("a ◁ 3", 5, "expected a name, found '3'"),
        ("a.b ◁ c", 2, "expected '(' or '◁' or the end, found '.'"),
        ("a(b) c.d", 6, "expected '◁' or the end, found 'c.d'"),
        ("a(b c)", 5, "expected ')' or ',', found 'c'"),
        ("a(b,) ", 5, "expected an argument, found ')'"),
        ("a(b <| c", 5, "expected ')' or ',', found '<|'"),
        ("a ◁ \n", 4, "expected a name at the end"),
    ],
)
def test_parse_error_states_message_and_place(text: str, column: int, message: str) -> None:
    with pytest.raises(CompositionError) as caught:
        parse(text)
    assert (str(caught.value), caught.value.span.start) == (message, column)
