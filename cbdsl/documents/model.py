"""The model document: a density over configurations or positions, to draw references from."""

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import Coordinate, Document, Extent, Name, NonNegative, Section
from cbdsl.documents.kind import Kind


class Gaussian(Section):
    """Independent normal distributions, one a joint or axis."""

    form: Literal["gaussian"]
    """Says that the density is Gaussian."""
    mean: Annotated[tuple[Coordinate, ...], Field(min_length=1)]
    """Mean angle of each joint, or the mean position."""
    deviation: Annotated[tuple[Extent, ...], Field(min_length=1)]
    """Standard deviation of each joint, or along each axis."""
    uniform: NonNegative = 0.0
    """Share of the draws that are uniform between the joint limits instead; positions have none."""


class Kernel(Section):
    """A Gaussian kernel around each of the samples that were found good."""

    form: Literal["kernel"]
    """Says that the density is a sum of kernels."""
    samples: Annotated[tuple[tuple[Coordinate, ...], ...], Field(min_length=1)]
    """The configurations, each with one angle a joint; or the positions."""
    bandwidth: Annotated[tuple[Extent, ...], Field(min_length=1)]
    """Standard deviation of the kernels along each joint or axis."""
    uniform: NonNegative = 0.0
    """Share of the draws that are uniform between the joint limits instead; positions have none."""


class ModelDocument(Document):
    """An internal model: where a controller's reference is likely to be rewarded."""

    kind: Literal["model"]
    """Says that this document is a model."""
    robot: Name
    """Robot whose configurations it is about."""
    effector: Name
    """Effector or group whose joints it has angles for, in their order; or whose tip goes there."""
    space: Literal["configuration", "position"] = "configuration"
    """Space of the density: the effector's joint angles, or positions of targets in the world
    frame."""
    channel: Name | None = None
    """Channel that was tracked in these configurations of the head: its background. A program
    that names the model has `novel.<channel>`, the heading to regions elsewhere."""
    density: Annotated[Gaussian | Kernel, Field(discriminator="form")]
    """How likely configurations are, or positions; draws keep within the joint limits."""


MODEL = Kind(
    ModelDocument,
    folder="knowledge/models",
    checker="cbdsl.checking.knowledge.model:examine_model",
    unknown="CB632",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown"},
)
