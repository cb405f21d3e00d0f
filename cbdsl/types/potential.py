"""Properties of each artificial potential, for the type checker (Omega_phi, Eq 3.7)."""

from collections.abc import Iterator, Mapping
from enum import Enum
from typing import NamedTuple

from cbdsl.types.registry import PluginError, Registry
from cbdsl.types.resource_type import TYPES


class Condition(Enum):
    """Degree to which a potential meets a condition."""

    MET = "met"
    ROBOT = "depends on the robot"
    NOT_MET = "not met"

    def __str__(self) -> str:
        return self.value


class Navigation(NamedTuple):
    """Conditions of a navigation function (Koditschek and Rimon 1990; Section 3.1).

    The conditions concern phi as a function of its feedback, on the named domain. They do not
    consider the map from joint positions to the feedback.

    Attributes:
        analytic: Infinite differentiability.
        polar: Convergence of the gradient flow to one minimum.
        admissible: Boundedness of the gradient.
        morse: Regularity of the Hessian at all zeros of the gradient.
        domain: Domain of the feedback for which the conditions hold, as a clause.
    """

    analytic: Condition
    polar: Condition
    admissible: Condition
    morse: Condition
    domain: str


class PotentialType(NamedTuple):
    """Signature of a potential.

    Attributes:
        name: Name in programs.
        symbol: Symbol in the source.
        equation: Equation of the source that defines it.
        accepts: Names of the resource types on which it is defined.
        reference: True if it compares its feedback with a reference.
        zero_minimum: True if its minimum is known to be 0, so that a Newton step applies.
        residual: True if it is half the square of a residual; otherwise it has a gradient only.
        navigation: Conditions of a navigation function, with the degree to which each is met.
        factors: Number of signals of such a type in its feedback; ``None`` for any number.
        implementation: ``module:function`` that builds a controller's potential.
        field: True if it is solved on a grid; the solution's displacement replaces a residual or
            a gradient.
        compares: Type name of its reference; ``None`` for the feedback's type.
        task: Type name of its error, gain and bounds; ``None`` for the feedback's type.
        total: True if it is defined for all values of its signals.
    """

    name: str
    symbol: str
    equation: str
    accepts: frozenset[str]
    reference: bool
    zero_minimum: bool
    residual: bool
    navigation: Navigation
    implementation: str
    factors: int | None = None
    field: bool = False
    compares: str | None = None
    task: str | None = None
    total: bool = False

    @property
    def scalar(self) -> bool:
        """True if phi itself is the only task coordinate."""
        return not (self.residual or self.field)


_MET, _ROBOT, _NOT_MET = Condition.MET, Condition.ROBOT, Condition.NOT_MET

_SPRING_TYPES = frozenset({
    "configuration", "position", "orientation", "pose", "heading", "force", "torque", "wrench",
    "constellation", "offset", "length",
})  # fmt: skip

# Navigation functions (Section 3.1) are analytic, polar, admissible and Morse. The gradient flow of
# such a function ends at its only minimum, with bounded commands. Springs and ranges meet all four
# conditions on their domains. The gradient of a harmonic function is not fit as a command; control
# follows its direction and shapes its magnitude. A bound is flat where it is met. Its minima fill a
# region, and its curvature jumps at the edge of this region. The minima of manipulability depend on
# the mechanism. Localizability falls to 0 towards each camera and thus has no minimum within its
# domain.
_BUILT_IN = (
    PotentialType(
        "spring",
        "φ_s",
        "Eq 3.1",
        _SPRING_TYPES,
        reference=True,
        zero_minimum=True,
        residual=True,
        navigation=Navigation(
            _MET, _MET, _MET, _MET, "bounded errors, turned by less than half a turn"
        ),
        implementation="cbdsl.control.potentials.spring:build",
        total=True,
    ),
    *(
        PotentialType(
            name,
            "φ_b",
            "after Eq 3.1",
            frozenset({"position", "force", "torque", "length", "likeness"}),
            reference=True,
            zero_minimum=True,
            residual=True,
            navigation=Navigation(
                _NOT_MET, _NOT_MET, _MET, _NOT_MET, "bounds, beside which all values are minima"
            ),
            implementation=f"cbdsl.control.potentials.bound:{builder}",
            total=True,
        )
        for name, builder in (("at_most", "build_upper"), ("at_least", "build_lower"))
    ),
    PotentialType(
        "look_at",
        "φ_v",
        "after Eq 3.1",
        frozenset({"pose"}),
        reference=True,
        zero_minimum=True,
        residual=True,
        navigation=Navigation(
            _MET, _NOT_MET, _NOT_MET, _NOT_MET, "tips away from the point, and not turned from it"
        ),
        implementation="cbdsl.control.potentials.look_at:build",
        factors=1,
        compares="position",
        task="orientation",
    ),
    PotentialType(
        "range",
        "φ_r",
        "Eq 3.3",
        frozenset({"configuration"}),
        reference=False,
        zero_minimum=True,
        residual=True,
        navigation=Navigation(_MET, _MET, _MET, _MET, "between the joint limits"),
        implementation="cbdsl.control.potentials.range:build",
        total=True,
    ),
    PotentialType(
        "manipulability",
        "φ_m",
        "Eq 3.5",
        frozenset({"configuration"}),
        reference=False,
        zero_minimum=False,
        residual=False,
        navigation=Navigation(_MET, _ROBOT, _MET, _ROBOT, "postures that are not singular"),
        implementation="cbdsl.control.potentials.manipulability:build",
    ),
    PotentialType(
        "localizability",
        "φ_l",
        "Eq 3.6",
        frozenset({"heading"}),
        reference=False,
        zero_minimum=True,
        residual=False,
        navigation=Navigation(
            _MET, _NOT_MET, _NOT_MET, _NOT_MET, "lines of sight that meet in front of the cameras"
        ),
        implementation="cbdsl.control.potentials.localizability:build",
        factors=2,
    ),
    PotentialType(
        "harmonic",
        "φ_h",
        "Eq 3.2",
        frozenset({"configuration", "position"}),
        reference=True,
        zero_minimum=True,
        residual=False,
        navigation=Navigation(
            _MET, _MET, _NOT_MET, _NOT_MET, "free space that is connected with the goal"
        ),
        implementation="cbdsl.control.potentials.harmonic:build",
        factors=1,
        field=True,
    ),
)


def _validate(name: str, entry: object) -> PotentialType:
    """Return a potential that another package declares, after validation.

    Raises:
        PluginError: The entry is not a ``PotentialType``, or its fields are inconsistent.
    """
    if not isinstance(entry, PotentialType):
        raise PluginError(f"is a {type(entry).__name__}, not a PotentialType")
    if entry.name != name:
        raise PluginError(f"calls itself '{entry.name}'")
    unknown = sorted(entry.accepts - TYPES.keys())
    if unknown or not entry.accepts:
        raise PluginError(f"accepts {', '.join(unknown) or 'no type'}; types: {', '.join(TYPES)}")
    if entry.implementation.count(":") != 1:
        raise PluginError(f"has the implementation '{entry.implementation}', not module:function")
    return entry


class PotentialTable(Mapping[str, PotentialType]):
    """Potentials by name: built-in ones, and those of usable packages.

    Package metadata are read only for a name that is not built in, or to list all potentials.
    """

    def __init__(self) -> None:
        self._built_in = {potential.name: potential for potential in _BUILT_IN}
        self.registry: Registry[PotentialType] = Registry(
            "potential",
            "cbdsl.potentials",
            {},
            _validate,
            self._built_in,
            {"learned": "cbdsl[onnx]"},
        )

    def __getitem__(self, name: str) -> PotentialType:
        built_in = self._built_in.get(name)
        if built_in is not None:
            return built_in
        if name not in self.registry:
            raise KeyError(name)
        return self.registry.get(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.registry.usable_names())

    def __len__(self) -> int:
        return len(self.registry.usable_names())

    def __contains__(self, name: object) -> bool:
        return name in self._built_in or name in self.registry


POTENTIALS = PotentialTable()
