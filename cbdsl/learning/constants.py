"""Constants of learning algorithms, as they are declared and read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, TypeVar

from pydantic import ValidationError

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document import Count, Section, quantity

Form = Literal["kernel", "gaussian"]
C = TypeVar("C", bound=Section)


class DensityConstants(Section):
    """Constants of the densities of rewarded configurations."""

    density: Form = "kernel"
    """Form of the internal models: kernel or gaussian."""
    bandwidth: Annotated[float, quantity("angle", gt=0, le=100)] = 0.1
    """Standard deviation of their kernels, smallest one of their Gaussians."""
    prior: Annotated[float, quantity(ge=0, le=1e9)] = 10.0
    """As how many samples the uniform density counts in them."""


class ValueConstants(Section):
    """Constants of Algorithm 1, line 3."""

    gamma: Annotated[float, quantity(ge=0, lt=1)] = 0.8
    """Discount."""
    alpha: Annotated[float, quantity(gt=0, le=1)] = 0.1
    """Learning rate."""
    epsilon: Annotated[float, quantity(ge=0, le=1)] = 0.2
    """Share of actions chosen at random."""
    exploring_episodes: Count | None = None
    """Number of episodes with exploration; later ones act greedily and are also learned from
    [all]."""


# The fields of the last base come first.
class AccommodateConstants(DensityConstants, ValueConstants):
    """Constants of Algorithm 1, and of the densities that it learns."""


def read_constants(model: type[C], given: Mapping[str, str | float], learner: str) -> C:
    """Return constants of a learner from numbers in SI, or from text with units.

    Args:
        model: Section type of the learner's constants.
        given: Values by name; other constants keep their defaults.
        learner: Name of the learner, for messages.

    Raises:
        UsageError: If the learner has no such constant, or a text is not a valid value.
    """
    for name in given:
        if name not in model.model_fields:
            raise UsageError.unknown(f"constant of learner '{learner}',", name, model.model_fields)
    try:
        return model.model_validate(dict(given))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        name = str(first["loc"][0])
        raise UsageError(f"constant {name} = {given[name]}: {first['msg'].lower()}") from error
