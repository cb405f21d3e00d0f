"""Properties of each artificial potential that the type checker knows (Omega_phi, Eq 3.7)."""

from collections.abc import Iterator, Mapping
from enum import Enum
from typing import NamedTuple

from cbdsl.types.registry import PluginError, Registry
from cbdsl.types.resource_type import TYPES


class Condition(Enum):
    """Whether a potential meets a condition."""

    MET = "met"
    ROBOT = "depends on the robot"
    NOT_MET = "not met"

    def __str__(self) -> str:
        return self.value


class Navigation(NamedTuple):
    """Conditions of a navigation function (Koditschek and Rimon 1990; Section 3.1).

    They are those of phi as a function of its feedback, on the named domain; what the joints make
    of the feedback is another matter.

    Attributes:
        analytic: infinitely differentiable.
        polar: its gradient leads to one minimum.
        admissible: its gradient is bounded.
        morse: its Hessian is regular wherever its gradient vanishes.
        domain: the feedback that this is said of, as a clause.
    """

    analytic: Condition
    polar: Condition
    admissible: Condition
    morse: Condition
    domain: str


class PotentialType(NamedTuple):
    """The signature of a potential.

    Attributes:
        name: its name in programs.
        symbol: its symbol in the source.
        equation: where the source defines it.
        accepts: names of the resource types it is defined on.
        reference: whether it compares its feedback with a reference.
        zero_minimum: whether its minimum is known to be 0, so that a Newton step applies.
        residual: whether it is half the square of a residual; otherwise it has a gradient only.
        navigation: which conditions of a navigation function it meets.
        factors: how many signals of such a type make up its feedback; ``None`` for any number.
        implementation: ``module:function`` that makes a controller's potential.
        field: whether it is solved for on a grid, and moves by the displacement that this gives
            instead of a residual or a gradient of its own.
        compares: name of its reference's type; ``None`` for that of the feedback.
        task: name of the type that its error, gain and bounds are those of; ``None`` for that of
            the feedback.
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

    @property
    def scalar(self) -> bool:
        """Whether phi itself is the only task coordinate."""
        return not (self.residual or self.field)


_MET, _ROBOT, _NOT_MET = Condition.MET, Condition.ROBOT, Condition.NOT_MET

_BUILT_IN = (
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
                "constellation",
                "offset",
            }
        ),
        reference=True,
        zero_minimum=True,
        residual=True,
        navigation=Navigation(
            _MET, _MET, _MET, _MET, "bounded errors, turned by less than half a turn"
        ),
        implementation="cbdsl.control.spring:build",
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
        implementation="cbdsl.control.look_at:build",
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
        implementation="cbdsl.control.range:build",
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
        implementation="cbdsl.control.manipulability:build",
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
        implementation="cbdsl.control.localizability:build",
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
        implementation="cbdsl.control.harmonic:build",
        factors=1,
        field=True,
    ),
)


def _validate(name: str, entry: object) -> PotentialType:
    """A potential that another package declares.

    Raises:
        PluginError: it is no ``PotentialType``, or claims what does not fit together.
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
    """The potentials by name: built-in ones, and those of packages that can be used.

    Packages are looked at only for a name that is not built in, or to list all potentials.
    """

    def __init__(self) -> None:
        self._built_in = {potential.name: potential for potential in _BUILT_IN}
        places = {name: f"{__name__}:{name}" for name in self._built_in}
        self.registry: Registry[PotentialType] = Registry(
            "potential", "cbdsl.potentials", places, _validate
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
