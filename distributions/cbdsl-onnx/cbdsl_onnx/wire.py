"""Protocol-buffer messages of ONNX files: their fields are read and written without a library.

A message is a sequence of fields, each a key and a value. The key holds the field's number and the
form of its value: a varint (0), eight bytes (1), bytes with a length (2) or four bytes (5).
Messages within messages are bytes with a length. Numbers of fields are those of ``onnx.proto``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

_FIXED = {1: 8, 5: 4}
_LONGEST_VARINT = 10

#: Types of tensors by their number in ONNX, as far as networks may have them as inputs.
FLOATS = {1: "<f4", 10: "<f2", 11: "<f8"}


def fields(data: memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Yield the fields of a message: their numbers and values.

    Raises:
        ValueError: The bytes are not a message.
    """
    place = 0
    while place < len(data):
        key, place = _varint(data, place)
        form = key & 7
        if form == 0:
            value, place = _varint(data, place)
            yield key >> 3, value
            continue
        size = _FIXED.get(form, 0)
        if form == 2:
            size, place = _varint(data, place)
        elif not size:
            raise ValueError(f"field {key >> 3} has the unknown form {form}")
        if place + size > len(data):
            raise ValueError("it ends within a field")
        yield key >> 3, data[place : place + size]
        place += size


def parts(data: memoryview, number: int) -> Iterator[memoryview]:
    """Yield the values of a field that are bytes."""
    yield from (
        value for key, value in fields(data) if key == number and isinstance(value, memoryview)
    )


def _varint(data: memoryview, place: int) -> tuple[int, int]:
    value = 0
    for count in range(_LONGEST_VARINT):
        if place >= len(data):
            raise ValueError("it ends within a number")
        byte = data[place]
        place += 1
        value |= (byte & 0x7F) << (7 * count)
        if byte < 0x80:
            return value, place
    raise ValueError("a number is too long")


def message(*pairs: tuple[int, int | bytes | str]) -> bytes:
    """Return a message of fields (number, value)."""
    return b"".join(_field(number, value) for number, value in pairs)


def _field(number: int, value: int | bytes | str) -> bytes:
    if isinstance(value, int):
        return _written(number << 3) + _written(value)
    data = value.encode() if isinstance(value, str) else value
    return _written(number << 3 | 2) + _written(len(data)) + data


def _written(value: int) -> bytes:
    data = bytearray()
    while value > 0x7F:
        data.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*data, value))


def tensor(name: str, shape: Sequence[int], raw: bytes) -> bytes:
    """Return a ``TensorProto`` of float32 numbers in little-endian order."""
    return message(*((1, size) for size in shape), (2, 1), (8, name), (9, raw))


def node(kind: str, inputs: Iterable[str], output: str) -> bytes:
    """Return a ``NodeProto`` without attributes."""
    return message(*((1, name) for name in inputs), (2, output), (4, kind))


def value_info(name: str, shape: Sequence[int]) -> bytes:
    """Return a ``ValueInfoProto`` of a float32 tensor."""
    dims = message(*((1, message((1, size))) for size in shape))
    return message((1, name), (2, message((1, message((1, 1), (2, dims))))))


def model(
    nodes: Iterable[bytes],
    constants: Iterable[bytes],
    inputs: Iterable[bytes],
    outputs: Iterable[bytes],
    opset: int = 17,
) -> bytes:
    """Return a ``ModelProto`` of one graph.

    Args:
        nodes: Nodes in the order of their execution.
        constants: Tensors of the weights.
        inputs: Values of the inputs.
        outputs: Values of the outputs.
        opset: Version of the operators.
    """
    graph = message(
        *((1, each) for each in nodes),
        (2, "network"),
        *((5, each) for each in constants),
        *((11, each) for each in inputs),
        *((12, each) for each in outputs),
    )
    return message((1, 8), (2, "cbdsl"), (7, graph), (8, message((1, ""), (2, opset))))
