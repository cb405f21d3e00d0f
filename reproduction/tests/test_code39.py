"""Code 39, checked against another library."""

from __future__ import annotations

import numpy as np
import pytest
import zxingcpp

from cbdsl_reproduction.chapter_3 import code39


def _drawn(stripes: tuple[float, ...], narrow: int = 4, quiet: int = 60) -> np.ndarray:
    row = [np.full(quiet, 255)]
    for index, width in enumerate(stripes):
        row.append(np.full(round(width * narrow), 255 * (index % 2)))
    row.append(np.full(quiet, 255))
    return np.tile(np.concatenate(row).astype(np.uint8), (60, 1))


@pytest.mark.parametrize("ratio", [2.0, 2.5, 3.0])
@pytest.mark.parametrize(
    "text", ["A", "B", "C", "ROBOT", "DEXTER", "AMHERST", *(c * 3 for c in code39._ALPHABET[:-1])]
)
def test_zxing_decodes_encoded_text(text: str, ratio: float) -> None:
    (found,) = zxingcpp.read_barcodes(
        _drawn(code39.stripes(f"X{text}X", ratio)), formats=zxingcpp.BarcodeFormat.Code39
    )
    assert found.text == f"X{text}X"


def test_every_character_has_three_wide_elements_of_nine_and_a_code_of_its_own() -> None:
    codes = [code39.stripes(character)[10:19] for character in code39._ALPHABET[:-1]]
    assert len(set(codes)) == len(codes) == 43
    assert all(sorted(code) == [1.0] * 6 + [2.0] * 3 for code in codes)


@pytest.mark.parametrize("text", ["a", "*", "A*", "Ä"])
def test_text_outside_of_the_alphabet_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="not in the alphabet"):
        code39.stripes(text)
