"""Data of a page: a JSON header followed by arrays, compressed."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

# JavaScript's typed arrays begin at multiples of their items' size.
_ALIGNMENT = 8

_NAMES = {"f4": "Float32Array", "f8": "Float64Array", "u1": "Uint8Array", "i2": "Int16Array",
          "u2": "Uint16Array", "i1": "Int8Array"}  # fmt: skip


class Bundle:
    """Collector of arrays; ``add`` returns the reference for the header."""

    def __init__(self) -> None:
        self._content = bytearray()

    def add(self, array: NDArray[Any]) -> Mapping[str, object]:
        """Keep an array unchanged, and return its reference: type, offset and shape."""
        kind = _NAMES[array.dtype.str[1:]]
        place = len(self._content)
        # JavaScript's typed arrays read numbers in the byte order of the reader's processor. All
        # processors with common browsers are little-endian.
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        self._content += np.ascontiguousarray(little).tobytes()
        self._content += bytes(-len(self._content) % _ALIGNMENT)
        return {"array": kind, "at": place, "shape": list(array.shape)}

    def text(self, header: Mapping[str, object]) -> str:
        """Return the header's size, the header and the arrays, compressed and encoded as Base64."""
        plain = json.dumps(header, separators=(",", ":")).encode()
        # JSON ignores trailing blanks. They align the arrays, which follow the header and its size
        # of 4 bytes.
        plain += b" " * (-(4 + len(plain)) % _ALIGNMENT)
        size = len(plain).to_bytes(4, "little")
        packed = zlib.compress(size + plain + bytes(self._content), level=9)
        return base64.b64encode(packed).decode()
