"""What the type checker knows of each artificial potential (Omega_phi, Eq 3.7)."""

from typing import NamedTuple


class PotentialType(NamedTuple):
    """The signature of a potential.

    Attributes:
        name: its name in programs.
        symbol: its symbol in the source.
        equation: where the source defines it.
        accepts: names of the resource types it is defined on.
        reference: whether it compares its feedback with a reference.
        zero_minimum: whether its minimum is known to be 0, so that a Newton step applies.
    """

    name: str
    symbol: str
    equation: str
    accepts: frozenset[str]
    reference: bool
    zero_minimum: bool


POTENTIALS: dict[str, PotentialType] = {
    potential.name: potential
    for potential in (
        PotentialType(
            "spring",
            "φ_s",
            "Eq 3.1",
            frozenset(
                {
                    "configuration",
                    "position",
                    "orientation",
                    "pose",
                    "heading",
                    "force",
                    "torque",
                    "wrench",
                }
            ),
            reference=True,
            zero_minimum=True,
        ),
        PotentialType(
            "range",
            "φ_r",
            "Eq 3.3",
            frozenset({"configuration"}),
            reference=False,
            zero_minimum=True,
        ),
    )
}
