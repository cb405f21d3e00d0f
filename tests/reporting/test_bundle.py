"""Bundles: unpacking by the rules of the page's script restores the packed content."""

from __future__ import annotations

import base64
import json
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_numpy

from cbdsl.reporting.bundle import Bundle

KINDS = {
    "Float32Array": "<f4", "Float64Array": "<f8", "Uint8Array": "u1", "Int8Array": "i1",
    "Int16Array": "<i2", "Uint16Array": "<u2",
}  # fmt: skip
ARRAYS = st.sampled_from(sorted(KINDS.values())).flatmap(
    lambda kind: st_numpy.arrays(kind, st_numpy.array_shapes(max_dims=3, min_side=0))
)


@given(st.lists(ARRAYS, max_size=4), st.text())
def test_bundle_restores_text_and_arrays(arrays: list[np.ndarray], text: str) -> None:
    bundle = Bundle()
    header = {"text": text, "arrays": [bundle.add(array) for array in arrays]}
    plain = zlib.decompress(base64.b64decode(bundle.text(header)))
    size = int.from_bytes(plain[:4], "little")
    told = json.loads(plain[4 : 4 + size])
    assert told["text"] == text
    for array, where in zip(arrays, told["arrays"], strict=True):
        kind = np.dtype(KINDS[where["array"]])
        start = 4 + size + where["at"]
        assert start % kind.itemsize == 0  # otherwise JavaScript refuses the offset
        found = np.frombuffer(plain, kind, array.size, start).reshape(where["shape"])
        assert found.tobytes() == np.ascontiguousarray(array).tobytes()


def test_array_of_an_unsupported_type_is_refused() -> None:
    with pytest.raises(KeyError):
        Bundle().add(np.zeros(2, dtype=complex))
