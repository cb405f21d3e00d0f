"""Model files in the ONNX format: read as data, checked, and loaded by onnxruntime.

No part of a file is executed before its structure is checked: it is one file without references
to others, its weights are finite, and onnxruntime knows its operators. A dry run on zeros then
gives the shapes of the outputs.
"""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl_onnx.wire import FLOATS, fields, parts

#: Types of inputs and outputs of onnxruntime, with those of numpy.
TYPES = {
    "tensor(float)": "float32",
    "tensor(double)": "float64",
    "tensor(float16)": "float16",
    "tensor(uint8)": "uint8",
}

#: Words of onnxruntime about an opset that it does not know.
_NEWER_OPSET = re.compile(r"Opset (\d+) is under development.*till opset (\d+)")
#: First bytes of pickles, and of the archives in which torch stores them.
_PICKLES = (b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05", b"PK\x03\x04")
#: Time after which a dry run is stopped, s.
_DRY_RUN = 10.0
#: Most numbers of an input.
_MOST_NUMBERS = 10_000_000
_MODEL_GRAPH, _MODEL_FUNCTIONS = 7, 25
_GRAPH_NODE, _GRAPH_TENSOR, _GRAPH_SPARSE = 1, 5, 15
_NODE_ATTRIBUTE, _FUNCTION_NODE, _FUNCTION_ATTRIBUTE = 5, 7, 11
_ATTRIBUTE_TENSORS, _ATTRIBUTE_GRAPHS, _ATTRIBUTE_SPARSE = (5, 10), (6, 11), (22, 23)
# Data types of tensors that hold floats, with the field of unpacked numbers and its type.
_UNPACKED = {1: (4, "<f4"), 11: (10, "<f8")}


class ModelFileError(Exception):
    """Fault of a model file.

    Attributes:
        fault: ``format``, ``external``, ``weights`` or ``runtime``.
    """

    def __init__(self, fault: str, reason: str) -> None:
        super().__init__(reason)
        self.fault = fault


class TensorFacts(NamedTuple):
    """Input or output of a model.

    Attributes:
        shape: Sizes; 1 in place of a size that varies.
        dtype: Type of its numbers, as of numpy; empty for other types than floats and bytes.
    """

    shape: tuple[int, ...]
    dtype: str


class ModelFacts(NamedTuple):
    """Inputs and outputs of a model, by name."""

    inputs: Mapping[str, TensorFacts]
    outputs: Mapping[str, TensorFacts]


def examine(data: bytes) -> ModelFacts:
    """Return the facts of a model after a dry run.

    Raises:
        ModelFileError: The model cannot be used; the message says why.
    """
    _require_whole(data)
    session = load(data)
    inputs = {each.name: _facts(each.shape, each.type) for each in session.get_inputs()}
    for name, facts in inputs.items():
        if math.prod(facts.shape) > _MOST_NUMBERS:
            raise ModelFileError("runtime", f"its input '{name}' has the shape {facts.shape}")
    feeds = {
        name: np.zeros(facts.shape, facts.dtype) for name, facts in inputs.items() if facts.dtype
    }
    outputs = {each.name: _facts(each.shape, each.type) for each in session.get_outputs()}
    if len(feeds) < len(inputs):
        return ModelFacts(inputs, outputs)
    results = _dry_run(session, feeds)
    shapes = (result.shape if isinstance(result, np.ndarray) else () for result in results)
    return ModelFacts(
        inputs,
        {
            name: facts._replace(shape=shape)
            for (name, facts), shape in zip(outputs.items(), shapes, strict=True)
        },
    )


def load(data: bytes) -> Any:
    """Return the session of a model: one thread, without optimisations that compute its constants.

    Raises:
        ModelFileError: onnxruntime cannot load it, for example because of an unknown operator.
    """
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
    try:
        return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    except Exception as error:
        raise ModelFileError("runtime", _reason(error)) from error


def _dry_run(session: Any, feeds: Mapping[str, NDArray[Any]]) -> Sequence[Any]:
    import onnxruntime

    options = onnxruntime.RunOptions()
    timer = threading.Timer(_DRY_RUN, lambda: setattr(options, "terminate", True))
    timer.start()
    try:
        results: Sequence[Any] = session.run(None, dict(feeds), options)
    except Exception as error:
        raise ModelFileError("runtime", f"a dry run on zeros fails: {_reason(error)}") from error
    finally:
        timer.cancel()
    return results


def _reason(error: Exception) -> str:
    """Return the reason of an error of onnxruntime without its number and its file."""
    lines = [line for line in str(error).splitlines() if line.strip()]
    text = lines[0] if lines else type(error).__name__
    if newer := _NEWER_OPSET.search(text):
        return f"its opset {newer[1]} is newer than {newer[2]}, the newest of this onnxruntime"
    return text.rsplit(" : ", 1)[-1].strip()[:300]


def _facts(shape: Sequence[Any], kind: str) -> TensorFacts:
    sizes = tuple(size if isinstance(size, int) and size > 0 else 1 for size in shape)
    return TensorFacts(sizes, TYPES.get(kind, ""))


def _require_whole(data: bytes) -> None:
    """Require a model without data in other files, and with finite weights.

    Raises:
        ModelFileError: It is not a model, it refers to another file, or a weight is not finite.
    """
    if data.startswith(_PICKLES):
        reason = "it is a pickle or an archive, which may hold code; export it in the ONNX format"
        raise ModelFileError("format", reason)
    try:
        for tensor in _tensors(memoryview(data)):
            _require_sound(tensor)
        is_model = any(number == _MODEL_GRAPH for number, _ in fields(memoryview(data)))
    except (ValueError, RecursionError) as error:
        raise ModelFileError("format", f"it is not an ONNX model: {error}") from error
    if not is_model:
        raise ModelFileError("format", "it is not an ONNX model: it has no graph")


def _tensors(model: memoryview) -> Iterator[memoryview]:
    """Yield all tensors of a model: weights, and those in attributes of nodes."""
    for graph in parts(model, _MODEL_GRAPH):
        yield from _of_graph(graph)
    for function in parts(model, _MODEL_FUNCTIONS):
        for node in parts(function, _FUNCTION_NODE):
            yield from _of_node(node)
        for attribute in parts(function, _FUNCTION_ATTRIBUTE):
            yield from _of_attribute(attribute)


def _of_graph(graph: memoryview) -> Iterator[memoryview]:
    yield from parts(graph, _GRAPH_TENSOR)
    for sparse in parts(graph, _GRAPH_SPARSE):
        yield from _of_sparse(sparse)
    for node in parts(graph, _GRAPH_NODE):
        yield from _of_node(node)


def _of_node(node: memoryview) -> Iterator[memoryview]:
    for attribute in parts(node, _NODE_ATTRIBUTE):
        yield from _of_attribute(attribute)


def _of_attribute(attribute: memoryview) -> Iterator[memoryview]:
    for number, value in fields(attribute):
        if not isinstance(value, memoryview):
            continue
        if number in _ATTRIBUTE_TENSORS:
            yield value
        elif number in _ATTRIBUTE_GRAPHS:
            yield from _of_graph(value)
        elif number in _ATTRIBUTE_SPARSE:
            yield from _of_sparse(value)


def _of_sparse(sparse: memoryview) -> Iterator[memoryview]:
    """Yield the values and the indices of a sparse tensor."""
    yield from parts(sparse, 1)
    yield from parts(sparse, 2)


def _require_sound(tensor: memoryview) -> None:
    raw, name, unpacked = memoryview(b""), "", []
    values = list(fields(tensor))
    kind = next((v for n, v in values if n == 2 and isinstance(v, int)), 0)
    number, dtype = _UNPACKED.get(kind, (-1, "<f4"))
    for field, value in values:
        if field == 13 or (field == 14 and value == 1):
            raise ModelFileError("external", "its weights are in another file")
        if isinstance(value, memoryview):
            if field == 8:
                name = bytes(value).decode("utf-8", "replace")
            elif field == 9:
                raw = value
            elif field == number:
                unpacked.append(np.frombuffer(value, dtype))
    if kind not in FLOATS:
        return
    arrays = [np.frombuffer(raw, FLOATS[kind]), *unpacked]
    if not all(np.isfinite(array).all() for array in arrays):
        raise ModelFileError("weights", f"'{name or 'a constant'}' has numbers that are not finite")
