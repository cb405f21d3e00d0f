"""Values that a decimal comma split keep their sign and their digits."""

from __future__ import annotations

import pytest

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
