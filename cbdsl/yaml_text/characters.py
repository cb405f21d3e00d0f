"""Invisible characters, and look-alikes of ASCII characters."""

from __future__ import annotations

import re

from cbdsl.types.unit import is_quantity

# Patterns are compiled where they are used: most texts have no such characters.

# Excluded by YAML 1.2 (5.1): C0 controls except tab and line ends, DEL, surrogates and
# noncharacters; in addition, C1 controls except NEL.
_CONTROL = r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff]"
# Zero-width characters, byte order marks and direction marks.
_INVISIBLE = r"[\u200b\u200e\u200f\u202a-\u202e\u2060\u2066-\u2069\ufeff]"

_SPACES = "\xa0\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u202f\u205f\u3000"
_DASHES = "\u2010\u2011\u2012\u2013\u2014\u2015\u2212\ufe58\ufe63"
_BULLETS = "\u2022\u2023\u25aa\xb7"
_QUOTES = "\u201c\u201d\u201e\u201f\u2018\u2019\u201a\u201b\xab\xbb\xb4"
_CYRILLIC = "\u0430\u0435\u043e\u0440\u0441\u0443\u0445\u0456\u0458\u0455"
_CYRILLIC_CAPITALS = "\u0410\u0412\u0415\u041a\u041c\u041d\u041e\u0420\u0421\u0422\u0425\u0406"
_GREEK = "\u03bf\u0391\u0392\u0395\u0396\u0397\u0399\u039a\u039c\u039d\u039f\u03a1\u03a4\u03a7"
_MEANT: dict[str, str] = {
    **dict.fromkeys(_SPACES, " "),
    **dict.fromkeys(_DASHES + _BULLETS, "-"),
    **dict.fromkeys(_QUOTES, '"'),
    **dict(zip(_CYRILLIC, "aeopcyxijs", strict=True)),
    **dict(zip(_CYRILLIC_CAPITALS, "ABEKMHOPCTXI", strict=True)),
    **dict(zip(_GREEK, "oABEZHIKMNOPTX", strict=True)),
    **{chr(full): chr(full - 0xFEE0) for full in range(0xFF01, 0xFF5F)},
    "\u2217": "*",
    "\u2236": ":",
    "\u3001": ",",
    "\xb0": " deg",
    "\xb2": "^2",
    "\xad": "",
    "\u200c": "",
    "\u200d": "",
}
_TABLE = str.maketrans(_MEANT)
_WORD = r"(?a:[\w$.]+)"
_INDENTATION = rf"^ *[{_SPACES}]\s*"
_BULLET = rf"^(\s*)[{_BULLETS}{_DASHES}]\s+(?=\S)"
_COLON = rf"(?a:^(\s*(?:- +)*[\w.$*-]+)(?:[\uff1a\u2236]\s*|:[{_SPACES}]\s*))"


# Beginnings of lines that a merge conflict or a diff leaves behind.
_MARKS = ("<<<<<<<", "|||||||", "=======", ">>>>>>>", "\n+")


def is_suspect(text: str) -> bool:
    """Return whether a text may hold a merge conflict or invisible characters."""
    return any(mark in text for mark in _MARKS) or invisible_in(text) is not None


def control_in(text: str) -> re.Match[str] | None:
    """Return the first character that YAML excludes."""
    return None if _is_visible(text) else re.search(_CONTROL, text)


def invisible_in(text: str) -> re.Match[str] | None:
    """Return the first zero-width character or direction mark."""
    return None if _is_visible(text) else re.search(_INVISIBLE, text)


def without_invisible(text: str) -> str:
    """Return a text without its invisible characters."""
    return re.sub(_INVISIBLE, "", text)


def escaped_invisible(text: str) -> str:
    """Return a text whose invisible characters, all within quotes, are escaped."""
    return re.sub(_INVISIBLE, lambda character: f"\\u{ord(character[0]):04x}", text)


def _is_visible(text: str) -> bool:
    """Return whether a text consists only of printable characters and line feeds."""
    # This fast test is false for every invisible character. It is also false for others, such as
    # no-break spaces, so the slower patterns decide in that case.
    return text.replace("\n", "").isprintable()


def plain(text: str) -> str:
    """Return a text with its look-alikes replaced by ASCII characters."""
    if text.isascii():
        return text
    known = text.translate(_TABLE)
    # Decimal digits of other scripts, such as Arabic-Indic ones, are too many for the table.
    return "".join(str(int(c)) if c > "\x7f" and c.isdecimal() else c for c in known)


def suggested_value(text: str) -> str | None:
    """Return the quantity or name that a text resembles, or ``None`` if it is ordinary text."""
    suggestion = plain(text)
    if suggestion == text:
        return None
    # A word only of Cyrillic or Greek letters is ordinary text. A mixture with Latin letters is
    # not.
    is_word = re.fullmatch(_WORD, suggestion) and re.search(r"[A-Za-z]", text)
    return suggestion if is_word or is_quantity(suggestion) else None


def suggested_key(key: str) -> str | None:
    """Return the ASCII key that a text resembles, without typographic quotes, or ``None``."""
    suggestion = plain(key).strip(' "')
    return suggestion if suggestion.isascii() and not key.isascii() else None


def suggested_line(line: str) -> str | None:
    """Return a line with look-alike indentation, bullet and colon corrected, or ``None``."""
    mended = re.sub(_INDENTATION, lambda match: " " * len(match[0]), line, count=1)
    mended = re.sub(_COLON, r"\1: ", re.sub(_BULLET, r"\1- ", mended, count=1), count=1)
    return mended if mended != line else None


def first_look_alike(text: str) -> int:
    """Return the index of the first look-alike character of a text, from 0."""
    return next(index for index, character in enumerate(text) if plain(character) != character)


def look_alike_message(text: str, suggestion: str) -> str:
    """Return the message about a text with a look-alike character."""
    character = spelled(text[first_look_alike(text)])
    return f"{character} looks like another character; write '{' '.join(suggestion.split())}'"


def spelled(character: str) -> str:
    """Return a character, its number and its name, such as ``'-' (U+002D, hyphen-minus)``."""
    import unicodedata  # only a fault needs it

    number, name = f"U+{ord(character):04X}", unicodedata.name(character, "").lower()
    if character.isprintable():
        return f"'{character}' ({number}, {name})"
    return f"{number} ({name})" if name else number
