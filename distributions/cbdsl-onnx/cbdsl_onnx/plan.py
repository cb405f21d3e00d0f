"""Checked network: constants of its inputs, its output and their times."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.extend.document import Resource

#: Types of feedbacks whose values can be subtracted.
SUBTRACTED = ("configuration", "position", "heading", "length", "force", "torque")


class Normalisation(NamedTuple):
    """Normalisation (value - mean) / deviation, SI units; empty for none."""

    mean: tuple[float, ...]
    deviation: tuple[float, ...]


class InputPlan(NamedTuple):
    """Input of the model.

    Attributes:
        name: Name in the model.
        resources: Signals, one after another.
        scale: Normalisation of their components.
        history: Number of observations, oldest first.
        shape: Shape of the tensor.
        dtype: Type of its numbers, as of numpy.
        camera: Camera of an image; empty for signals.
        size: Height and width of the image, px.
        channels_first: True if its channels precede its height.
    """

    name: str
    resources: tuple[Resource, ...]
    scale: Normalisation
    history: int
    shape: tuple[int, ...]
    dtype: str
    camera: str = ""
    size: tuple[int, int] = (0, 0)
    channels_first: bool = True


class OutputPlan(NamedTuple):
    """Output of the model.

    Attributes:
        name: Name in the model.
        feedback: Signal that it is for.
        gives: ``target``, ``displacement`` or ``velocity``.
        scale: Normalisation of its components.
        steps: Number of actions of its chunk.
        executed: Number of actions after which the next chunk takes over.
    """

    name: str
    feedback: Resource
    gives: str
    scale: Normalisation
    steps: int
    executed: int


class NetworkPlan(NamedTuple):
    """Network that can run.

    Attributes:
        file: Path of the model.
        sha256: Digest of the model.
        inputs: Inputs.
        output: Output.
        period: Time between two actions, s.
        deadline: Time from an observation to the moment at which its output takes effect, s.
    """

    file: str
    sha256: str
    inputs: tuple[InputPlan, ...]
    output: OutputPlan
    period: float
    deadline: float
