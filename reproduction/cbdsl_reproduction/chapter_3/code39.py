"""Code 39: text as bars and gaps of two widths (ISO/IEC 16388)."""

from __future__ import annotations

from itertools import chain

_ALPHABET = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ-. $/+%*"

# Nine elements of a character, bar, gap, ..., bar, as bits from the highest: 1 is a wide element.
# fmt: off
_WIDE = (
    0x034, 0x121, 0x061, 0x160, 0x031, 0x130, 0x070, 0x025, 0x124, 0x064,  # 0 to 9
    0x109, 0x049, 0x148, 0x019, 0x118, 0x058, 0x00D, 0x10C, 0x04C, 0x01C,  # A to J
    0x103, 0x043, 0x142, 0x013, 0x112, 0x052, 0x007, 0x106, 0x046, 0x016,  # K to T
    0x181, 0x0C1, 0x1C0, 0x091, 0x190, 0x0D0, 0x085, 0x184, 0x0C4, 0x0A8,  # U to Z - . blank $
    0x0A2, 0x08A, 0x02A, 0x094,                                            # / + % *
)
# fmt: on


def stripes(text: str, ratio: float = 2.0) -> tuple[float, ...]:
    """Return widths of bar, gap, ..., bar, with start and stop characters, in narrow widths.

    Args:
        text: Text of digits, capitals, blanks and ``-.$/+%``.
        ratio: Ratio of wide to narrow elements; the standard requires 2 to 3.

    Raises:
        ValueError: A character cannot be encoded.
    """
    # The last character of the alphabet, *, is reserved for start and stop.
    for character in text:
        if character not in _ALPHABET[:-1]:
            raise ValueError(f"{character!r} is not in the alphabet of Code 39")
    characters = [_elements(character, ratio) for character in f"*{text}*"]
    # A narrow gap follows every character but the last.
    return tuple(chain.from_iterable((*each, 1.0) for each in characters))[:-1]


def _elements(character: str, ratio: float) -> tuple[float, ...]:
    bits = _WIDE[_ALPHABET.index(character)]
    return tuple(ratio if bits >> place & 1 else 1.0 for place in reversed(range(9)))
