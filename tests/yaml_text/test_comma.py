"""Numbers and calls that a comma split keep all their parts."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.yaml_text.comma import decimal_comma
from cbdsl.yaml_text.composer import compose


@pytest.mark.parametrize(
    ("written", "meant"), [("1,5", 1.5), ("-1,5", -1.5), ("-0,5", -0.5), ("+1,50", 1.5)]
)
def test_compose_of_a_decimal_comma_keeps_the_number(written: str, meant: float) -> None:
    composed = compose(f"{{gain: {written}}}", "a.yaml")
    assert composed.root.plain() == {"gain": meant}
    (found,) = composed.diagnostics
    assert f"write '{written.replace(',', '.')}'" in found.message


def test_compose_of_a_truth_value_and_a_number_proposes_a_list() -> None:
    (found,) = compose("{gain: true,5}", "a.yaml").diagnostics
    assert "[true, 5]" in found.message


@pytest.mark.parametrize(("row", "message"), [("[-0,5]", "'-0.5'"), ("[1,05]", "'1.05'")])
def test_decimal_comma_of_a_list_names_the_number_as_written(row: str, message: str) -> None:
    assert message in str(decimal_comma(compose(row, "a.yaml").root))


ARGUMENTS = st.lists(st.sampled_from(["$arm", "red", "3", "-2 cm", "0.5 m/s^2"]), min_size=2)
SPLIT = {
    "{do: CALL, then: end}": {"do": "CALL", "then": "end"},
    "{then: end, do: CALL}": {"then": "end", "do": "CALL"},
    "[stay, CALL, end]": ["stay", "CALL", "end"],
    "[CALL at rest: end, CALL: stay]": [{"CALL at rest": "end"}, {"CALL": "stay"}],
}


def with_call(value: object, call: str) -> object:
    """Return a value with a call in the place of its name, in keys, too."""
    if isinstance(value, dict):
        return {key.replace("CALL", call): with_call(each, call) for key, each in value.items()}
    if isinstance(value, list):
        return [with_call(each, call) for each in value]
    return str(value).replace("CALL", call)


@given(ARGUMENTS, st.sampled_from([*SPLIT]), st.sampled_from(["{}", "{} ◁ stay", "look ◁ {}"]))
def test_compose_of_a_call_without_quotes_keeps_it_whole(
    arguments: list[str], text: str, around: str
) -> None:
    call = around.format(f"lift({', '.join(arguments)})")
    composed = compose(text.replace("CALL", call), "a.yaml")
    assert composed.root.plain() == with_call(SPLIT[text], call)
    assert len(composed.diagnostics) == text.count("CALL")
    assert all(f'"{call}' in found.message for found in composed.diagnostics)


@pytest.mark.parametrize("text", ['{do: "lift(a", then: end}', "{do: lift(a), then: end}"])
def test_compose_of_a_call_without_commas_finds_nothing(text: str) -> None:
    assert not compose(text, "a.yaml").diagnostics


def test_compose_of_a_call_without_its_end_names_it() -> None:
    (found,) = compose("{do: lift(a, b, then: end}", "a.yaml").diagnostics
    assert found.message == "the ')' of 'lift(a, b' is missing"
