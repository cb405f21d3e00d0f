"""The model document: a density over configurations, which programs draw references from."""

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import Coordinate, Document, Extent, Name, NonNegative, Section
from cbdsl.documents.kind import Kind


class Gaussian(Section):
    """Independent normal distributions, one a joint."""

    form: Literal["gaussian"]
    """Says that the density is Gaussian."""
    mean: Annotated[tuple[Coordinate, ...], Field(min_length=1)]
    """Mean angle of each joint."""
    deviation: Annotated[tuple[Extent, ...], Field(min_length=1)]
    """Standard deviation of each joint."""
    uniform: NonNegative = 0.0
    """Share of the draws that are uniform between the joint limits instead."""


class Kernel(Section):
    """A Gaussian kernel around each of the configurations that were found good."""

    form: Literal["kernel"]
    """Says that the density is a sum of kernels."""
    samples: Annotated[tuple[tuple[Coordinate, ...], ...], Field(min_length=1)]
    """The configurations, each with one angle a joint."""
    bandwidth: Annotated[tuple[Extent, ...], Field(min_length=1)]
    """Standard deviation of the kernels along each joint."""
    uniform: NonNegative = 0.0
    """Share of the draws that are uniform between the joint limits instead."""


class ModelDocument(Document):
    """An internal model: where a controller's reference is likely to be rewarded."""

    kind: Literal["model"]
    """Says that this document is a model."""
    robot: Name
    """Robot whose configurations it is about."""
    effector: Name
    """Effector or group whose joints it has angles for, in their order."""
    density: Annotated[Gaussian | Kernel, Field(discriminator="form")]
    """How likely configurations are; draws keep within the joint limits."""


MODEL = Kind(
    ModelDocument,
    folder="knowledge/models",
    checker="cbdsl.checking.knowledge.model:examine_model",
    unknown="CB632",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown"},
)
