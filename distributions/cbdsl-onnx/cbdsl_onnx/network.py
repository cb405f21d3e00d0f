"""The network document: a trained model, its inputs, and the output that controllers follow."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from cbdsl.extend.document import (
    Document,
    Duration,
    Entry,
    FileSection,
    Kind,
    Name,
    PositiveCount,
    Section,
)
from cbdsl_onnx.examples import EXAMPLES

Numbers = tuple[float, ...]


class NormalisedSection(Section):
    """Tensor whose numbers are normalised: (value - mean) / deviation in SI units."""

    mean: Numbers = ()
    """Mean of each component in SI units; 0 if omitted."""
    deviation: tuple[Annotated[float, Field(gt=0)], ...] = ()
    """Standard deviation of each component in SI units; 1 if omitted."""


class InputSection(NormalisedSection):
    """Input of the model."""

    of: Annotated[tuple[str, ...], Field(min_length=1)]
    """Signals of the robot, one after another, in SI units. An orientation is a rotation matrix row
    by row, and a pose begins with its position. An image of a camera, such as `left.image`, stands
    alone: RGB, as bytes, or as floats from 0 to 1, normalised by one number per channel."""
    size: tuple[PositiveCount, PositiveCount] | None = None
    """Height and width to which an image is resized, px. The channels come first or last, as in the
    shape of the model's input."""
    history: PositiveCount = 1
    """Number of observations, one per period, oldest first. The first one of an episode is repeated
    until there are enough."""


class OutputSection(NormalisedSection):
    """Output of the model."""

    name: str
    """Name of the output in the model."""
    of: str
    """Feedback that the output is for, such as `right_arm.position`."""
    gives: Literal["target", "displacement", "velocity"]
    """Meaning of the output: a value of the feedback, a displacement from the value at which the
    action begins, or a rate of change per second."""
    steps: PositiveCount = 1
    """Number of actions of one output: its chunk."""
    execute: PositiveCount | None = None
    """Number of actions after which the next output takes over; all of them if omitted."""

    @property
    def executed(self) -> int:
        """Number of actions between outputs."""
        return self.steps if self.execute is None else self.execute


class NetworkDocument(FileSection, Document):
    """Trained model in the ONNX format, with its inputs and its output."""

    most_bytes: ClassVar[int] = 500_000_000

    kind: Literal["network"]
    """Kind of this document: a network."""
    robot: Name
    """Robot of the signals."""
    file: Annotated[str, Field(min_length=1)]
    """File of the model, relative to the document's folder: in the ONNX format, or
    `model.safetensors` in the folder of a policy of LeRobot."""
    inputs: Annotated[dict[str, InputSection], Field(min_length=1)]
    """Inputs of the model by their names."""
    output: OutputSection
    """Output that controllers follow; others are ignored."""
    period: Duration = 0.1
    """Time between two actions."""
    deadline: Duration = 0.02
    """Time from an observation to the moment at which its output takes effect. An output that is
    later, or not finite, makes the controller undefined until the next one."""
    card: Mapping[Name, str] = {}
    """Facts about the training, such as its data, its licence and its command."""


_HEAD = "cbdsl: 1\nkind: network\nname: example\nrobot: dexter\n"
_FOLDER = "knowledge/networks"


def _sample(
    file: str = "example",
    of: str = "[right_arm.position]",
    more: str = "",
    output: str = "of: right_arm.position, gives: displacement",
    end: str = "",
) -> str:
    inputs = f"inputs: {{x: {{of: {of}{more}}}}}"
    return f"{_HEAD}file: {file}.onnx\n{inputs}\noutput: {{name: y, {output}}}\n{end}"


def _entry(code: str, title: str, message: str, explanation: str, bad: str) -> Entry:
    models = {f"{_FOLDER}/{name}.onnx": data for name, data in EXAMPLES.items()}
    path = f"{_FOLDER}/example.yaml"
    return Entry(code, title, message, explanation, bad, path, models, good=_sample())


UNREADABLE = _entry(
    "NET101",
    "unreadable model file",
    "the model {file} cannot be read: {reason}",
    "A model is one file in the ONNX format of at most 500 MB. It is read as data.",
    _sample("text"),
)
EXTERNAL = _entry(
    "NET102",
    "model with data in other files",
    "the model {file} keeps weights in other files; export it as one file",
    "The digest of a recording covers one file, and a reference to another file may lead anywhere. "
    "Exporters have an option for it, such as `external_data=False` of torch.onnx.export.",
    _sample("external"),
)
REFUSED = _entry(
    "NET103",
    "model that cannot run",
    "the model {file} cannot run: {reason}",
    "The model has an operator, a version of the operators or a type that this version of "
    "onnxruntime does not know, or it fails on inputs of zeros. Export it for an older opset. A "
    "policy of LeRobot needs a Python that has lerobot.",
    _sample("unknown_operator"),
)
NOT_FINITE = _entry(
    "NET104",
    "weights that are not finite",
    "the model {file} has wrong weights: {reason}",
    "Numbers such as NaN come from a training that diverged, and all outputs would be undefined.",
    _sample("not_finite"),
)
TENSOR = _entry(
    "NET105",
    "input or output that does not fit the model",
    "{problem}",
    "Names, types and shapes of the document's inputs and output must be those of the model. An "
    "input has one row per observation of its history, an output one row per action of its chunk.",
    _sample(of="[right_arm.position, left_arm.position]"),
)
SIGNAL = _entry(
    "NET106",
    "signal that a network cannot use",
    "{problem}",
    "Inputs are measured signals of the robot, or an image of a camera with its size. An output is "
    "for a feedback whose values can be subtracted: a configuration, a position, a heading, a "
    "length, a force or a torque.",
    _sample(of="[right_arm.place]"),
)
NUMBERS = _entry(
    "NET107",
    "normalisation of another size",
    "{problem}",
    "A mean and a deviation have one number per component of their signals, in SI units, or per "
    "channel of an image of floats.",
    _sample(more=", mean: [1, 2]"),
)
TIMING = _entry(
    "NET108",
    "output that cannot be in time",
    "{problem}",
    "The next output takes over after the executed actions. They are part of the chunk, and the "
    "next output must be due by then.",
    _sample(end="deadline: 0.2 s\n"),
)

NETWORK = Kind(
    NetworkDocument,
    folder=_FOLDER,
    checker="cbdsl_onnx.checker:check",
    unknown="CB632",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown"},
    entries=(UNREADABLE, EXTERNAL, REFUSED, NOT_FINITE, TENSOR, SIGNAL, NUMBERS, TIMING),
    resources="cbdsl_onnx.checker:resources",
    brought=Path(__file__).parent / "shipped",
)
