"""The model document: a density over configurations or positions, to draw references from."""

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import Coordinate, Document, Extent, Name, NonNegative, Section
from cbdsl.documents.kind import Kind


# A density is a mixture of normal distributions with diagonal covariances. A Gaussian has one
# centre, and a kernel density has one for each sample, all of equal weight. With probability
# ``uniform``, a sample is drawn between the joint limits instead. A positive share keeps
# configurations possible that were never rewarded. Samples beyond the joint limits are drawn again,
# so that the density within the limits keeps its shape.
class Gaussian(Section):
    """Independent normal distributions, one per joint or axis."""

    form: Literal["gaussian"]
    """Form of the density: Gaussian."""
    mean: Annotated[tuple[Coordinate, ...], Field(min_length=1)]
    """Mean angle of each joint, or the mean position."""
    deviation: Annotated[tuple[Extent, ...], Field(min_length=1)]
    """Standard deviation of each joint, or along each axis."""
    uniform: NonNegative = 0.0
    """Share of samples drawn uniformly between the joint limits instead; 0 for positions."""


class Kernel(Section):
    """Gaussian kernels around samples that were rewarded."""

    form: Literal["kernel"]
    """Form of the density: a sum of kernels."""
    samples: Annotated[tuple[tuple[Coordinate, ...], ...], Field(min_length=1)]
    """Configurations with an angle per joint, or positions."""
    bandwidth: Annotated[tuple[Extent, ...], Field(min_length=1)]
    """Standard deviation of the kernels along each joint or axis."""
    uniform: NonNegative = 0.0
    """Share of samples drawn uniformly between the joint limits instead; 0 for positions."""


class ModelDocument(Document):
    """Internal model: density of references that are likely to be rewarded."""

    kind: Literal["model"]
    """Kind of this document: a model."""
    robot: Name
    """Robot of the configurations."""
    effector: Name
    """Effector or group of the joint angles, in their order, or of the tip that moves to the
    positions."""
    space: Literal["configuration", "position"] = "configuration"
    """Space of the density: joint angles of the effector, or positions of targets in the world
    frame."""
    channel: Name | None = None
    """Channel tracked in these configurations of the head: its background. A program that names the
    model has `novel.<channel>`, the heading to regions elsewhere."""
    density: Annotated[Gaussian | Kernel, Field(discriminator="form")]
    """Probability density of configurations or positions; samples stay within the joint limits."""


MODEL = Kind(
    ModelDocument,
    folder="knowledge/models",
    checker="cbdsl.checking.knowledge.model:examine_model",
    unknown="CB632",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown"},
    resources="cbdsl.checking.knowledge.model:model_resources",
)
