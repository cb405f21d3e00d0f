"""Digests of contents."""

import hashlib

from cbdsl.diagnostics.legible_text import encoded


def digest_of_text(text: str) -> str:
    """Return the SHA-256 of a text, in hexadecimal."""
    return digest_of_bytes(encoded(text))


def digest_of_bytes(contents: bytes) -> str:
    """Return the SHA-256 of bytes, in hexadecimal."""
    return hashlib.sha256(contents).hexdigest()
