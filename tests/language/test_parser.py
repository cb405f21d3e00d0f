"""Compositions: round trips, and where a text stops being one."""

from __future__ import annotations

from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lark import Lark
from lark.exceptions import UnexpectedInput, UnexpectedToken

from cbdsl.language.expression import Argument, Expression, Span, Term, print_expression
from cbdsl.language.parser import CompositionError, parse

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

# Pieces of which many are compositions, and many more nearly so.
TEXTS = st.lists(st.sampled_from([*"a1_$.(),◁< \n", "b2", "<|", " ◁ ", "f(x)", "é"])).map("".join)


def bare(expression: Expression) -> list[tuple[str, list[str]]]:
    """An expression without its spans."""
    return [(term.name, [a.text for a in term.arguments]) for term in expression.terms]


@cache
def grammar() -> Lark:
    return Lark.open("composition.lark", rel_to=__file__, parser="lalr", start="expression")


@given(TEXTS)
def test_the_parser_accepts_the_language_of_the_grammar(text: str) -> None:
    try:
        tree = grammar().parse(text)
    except UnexpectedInput as error:
        with pytest.raises(CompositionError) as caught:
            parse(text)
        ends = isinstance(error, UnexpectedToken) and error.token.type == "$END"
        where = len(text.rstrip()) if ends else error.pos_in_stream
        assert caught.value.span.start - 1 == where
    else:
        terms = [term.children for term in tree.children]
        expected = [(str(n), [str(a) for a in (c.children if c else ())]) for n, c in terms]
        assert bare(parse(text)) == expected


@given(EXPRESSIONS)
def test_what_is_printed_parses_to_the_same(expression: Expression) -> None:
    assert bare(parse(print_expression(expression))) == bare(expression)


@given(EXPRESSIONS, st.sampled_from(["<|", " <| ", "◁", "  ◁\n"]))
def test_every_spelling_prints_alike(expression: Expression, operator: str) -> None:
    text = operator.join(str(term) for term in expression.terms)
    assert print_expression(parse(text)) == print_expression(expression)


@given(EXPRESSIONS)
def test_spans_are_where_the_names_stand(expression: Expression) -> None:
    text = print_expression(expression)
    for term in parse(text).terms:
        assert text[term.span.start - 1 : term.span.end - 1] == term.name
        for argument in term.arguments:
            assert text[argument.span.start - 1 : argument.span.end - 1] == argument.text


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
        ("", 1, "it ends where a name should follow"),
        ("a ◁", 4, "it ends where a name should follow"),
        ("◁ a", 1, "'◁' where a name should be"),
        ("a b", 3, "'b' where '(' or '◁' or the end should be"),
        ("a ⊲ b", 3, "'⊲' where '◁' or its ASCII spelling '<|' should be"),
        ("a()", 3, "')' where an argument should be"),
        ("a(b", 4, "it ends where ')' or ',' should follow"),
        ("a ◁ 3", 5, "'3' where a name should be"),
    ],
)
def test_errors_say_where_and_what(text: str, column: int, message: str) -> None:
    with pytest.raises(CompositionError) as caught:
        parse(text)
    assert (str(caught.value), caught.value.span.start) == (message, column)
