"""Facts of the sources of resources, one record for each type of source."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from enum import Enum, auto
from typing import Any, NamedTuple, TypeVar

from cbdsl.types import resource as sources
from cbdsl.types.casts import CAMERA, RIGID_HOLD, SIGHTING, SIZE_TURN, TRIANGULATION, Chain, chains
from cbdsl.types.resource import Resource, Source
from cbdsl.types.resource_type import FORCE, HEADING, POSITION, configuration

Kind = TypeVar("Kind")


class Carrier(Enum):
    """Bodies that carry a signal's sensors or the sensed object."""

    TIPS = auto()
    CELL = auto()
    CELLS = auto()
    CAMERAS = auto()
    HOLD = auto()
    LINKS = auto()


class Normals(Enum):
    """Bodies along whose normals the forces of a source are defined."""

    FINGERS = auto()
    PALMS = auto()


class Combination(Enum):
    """Combination of the tips of a group."""

    MEAN = auto()
    DIFFERENCE = auto()


class SourceRecord(NamedTuple):
    """Facts of one type of source.

    Attributes:
        place: Path of the declaration in a robot document. An item in braces is an attribute of
            the source.
        owner: Attribute that names the effector, group or hand; empty without one.
        moves: True if the joints of the owner move the signal.
        combines: Combination of the tips of its owner; ``None`` for other sources.
        sums: True if it sums the loads of all fingers of each hand.
        normals: Bodies along whose normals its forces are defined; ``None`` for other sources.
        channels: Attributes that name its visual channels.
        hues: Attribute that lists the possible channels of a mark; empty without one.
        located: True for the position of a seen object, whose radius is measured, too.
        stereo: True for the headings of both cameras, which determine a position.
        compares: True if it compares objects of two channels.
        carriers: Bodies that carry its sensors or the sensed object.
        links: Attribute that lists the links of its sensor; empty without one.
        differs: True if joints that move all its carriers do not change it.
        features: Attribute that lists the resources from which it is computed; empty without one.
        uniform: True for draws from a uniform distribution.
        chains: Chains of casts to the joints; ``None`` for the shortest chain of its type.
    """

    place: tuple[str, ...]
    owner: str = ""
    moves: bool = False
    combines: Combination | None = None
    sums: bool = False
    normals: Normals | None = None
    channels: tuple[str, ...] = ()
    hues: str = ""
    located: bool = False
    stereo: bool = False
    compares: bool = False
    carriers: tuple[Carrier, ...] = ()
    links: str = ""
    differs: bool = False
    features: str = ""
    uniform: bool = False
    chains: tuple[Chain, ...] | None = None


_EFFECTOR, _GROUP = ("effectors", "{effector}"), ("groups", "{group}")
_HAND, _CAMERA, _CAMERAS = ("load_cells", "{hand}"), ("cameras", "{camera}"), ("cameras",)
_TIPS, _CELLS, _EYES = (Carrier.TIPS,), (Carrier.CELLS,), (Carrier.CAMERAS,)
_HELD, _SEEN = (Carrier.HOLD,), (Carrier.CAMERAS, Carrier.HOLD)
_ONE, _TWO = ("channel",), ("channel", "other")
_HOLD: Chain = (RIGID_HOLD, *chains(POSITION, configuration(1))[0])

# ``carriers`` determine the joints that change a signal: all joints above one of these bodies.
# ``differs`` removes the joints above all of them. An arm moves every finger of its hand, and does
# not change their opening. A heading is relative to its cameras, so that it changes with the
# cameras and with a held object. A position is in the world frame, so that only a holding hand
# changes it.
RECORDS: Mapping[type, SourceRecord] = {
    sources.EffectorConfiguration: SourceRecord(_EFFECTOR, "effector", moves=True),
    sources.Tip: SourceRecord(_EFFECTOR, "effector", moves=True, carriers=_TIPS),
    sources.Centroid: SourceRecord(
        _GROUP, "group", moves=True, combines=Combination.MEAN, carriers=_TIPS
    ),
    sources.Separation: SourceRecord(
        _GROUP, "group", moves=True, combines=Combination.DIFFERENCE, carriers=_TIPS
    ),
    sources.FingerLoad: SourceRecord((*_HAND, "{finger}"), "hand", carriers=(Carrier.CELL,)),
    sources.NetLoad: SourceRecord(_HAND, "hand", sums=True, normals=Normals.PALMS, carriers=_CELLS),
    sources.NetForces: SourceRecord(
        _GROUP, "group", sums=True, normals=Normals.PALMS, carriers=_CELLS
    ),
    sources.FingerForces: SourceRecord(_HAND, "hand", normals=Normals.FINGERS, carriers=_CELLS),
    sources.Opening: SourceRecord(_HAND, "hand", carriers=_CELLS, differs=True),
    sources.GraspCentre: SourceRecord(_HAND, "hand", carriers=_CELLS),
    sources.LinkDistance: SourceRecord(
        _EFFECTOR, carriers=(Carrier.LINKS,), links="links", features="features"
    ),
    sources.Heading: SourceRecord(
        _CAMERA, channels=_ONE, carriers=_SEEN, chains=((CAMERA,), (SIGHTING, *_HOLD))
    ),
    sources.Headings: SourceRecord(
        _CAMERAS,
        channels=_ONE,
        stereo=True,
        carriers=_SEEN,
        chains=((CAMERA,), (TRIANGULATION, *_HOLD)),
    ),
    sources.StereoPosition: SourceRecord(
        _CAMERAS, channels=_ONE, located=True, carriers=_HELD, chains=(_HOLD,)
    ),
    sources.BlobSignal: SourceRecord(_CAMERA, channels=_ONE, carriers=_SEEN),
    sources.StereoSignal: SourceRecord(_CAMERAS, channels=_ONE, carriers=_HELD),
    sources.ObjectDistance: SourceRecord(_CAMERAS, channels=_ONE, carriers=_HELD),
    sources.InstanceCount: SourceRecord(_CAMERAS, channels=_ONE),
    sources.SurfacePoint: SourceRecord(_CAMERAS, channels=_ONE),
    sources.NovelHeading: SourceRecord(
        _CAMERAS, channels=_ONE, carriers=_EYES, chains=((CAMERA,),)
    ),
    sources.MarkHeading: SourceRecord(
        _CAMERAS, channels=("channel", "hues"), hues="hues", carriers=_EYES, chains=((CAMERA,),)
    ),
    sources.ConstellationSignal: SourceRecord(
        _CAMERA, channels=_TWO, compares=True, carriers=_EYES
    ),
    sources.StereoOffset: SourceRecord(_CAMERAS, channels=_TWO, compares=True, carriers=_EYES),
    sources.SolidSignal: SourceRecord(
        _CAMERAS, channels=_TWO, compares=True, carriers=_EYES, chains=((SIZE_TURN,),)
    ),
    sources.AffordanceProbability: SourceRecord(_CAMERAS, features="features"),
    sources.PairLikeness: SourceRecord(
        _CAMERAS, compares=True, carriers=_EYES, features="features"
    ),
    sources.SensorSignal: SourceRecord(
        ("sensors", "{sensor}"), carriers=(Carrier.LINKS,), links="links"
    ),
    sources.ModelSignal: SourceRecord(_EFFECTOR, features="features"),
    sources.Posture: SourceRecord((*_EFFECTOR, "postures", "{posture}"), "effector"),
    sources.Turned: SourceRecord(_EFFECTOR, "effector"),
    sources.UniformSample: SourceRecord(_EFFECTOR, "effector", uniform=True),
    sources.GaussianSample: SourceRecord(_EFFECTOR, "effector"),
    sources.KernelSample: SourceRecord(_EFFECTOR, "effector"),
}


def record_of(source: Source) -> SourceRecord:
    """Return the record of a source's type."""
    return RECORDS[type(source)]


def sources_of(resources: Iterable[Resource], kind: type[Kind]) -> tuple[Kind, ...]:
    """Return the different sources of one type among the sources of resources, in order."""
    sources = [each.source for each in resources]
    return tuple(dict.fromkeys(source for source in sources if isinstance(source, kind)))


def key_of(source: Source) -> tuple[type, Source]:
    """Return a key of a source; equal fields of sources of different types are not equal."""
    return type(source), source


def is_visual(source: Source) -> bool:
    """Return whether a source is seen, in one channel or in two."""
    return bool(record_of(source).channels)


def compares(source: Source) -> bool:
    """Return whether a source compares objects of two channels."""
    return record_of(source).compares


def channels_of(source: Source) -> Iterator[str]:
    """Yield the channels of a source that the cameras have to look for."""
    for attribute in record_of(source).channels:
        names = getattr(source, attribute)
        yield from (names,) if isinstance(names, str) else names


def channel_of(source: Source) -> str:
    """Return the channel of a source's object, the first one if it compares two objects."""
    return next(channels_of(source), "")


def hues_of(source: Source) -> tuple[str, ...]:
    """Return the possible channels of a mark; empty for other sources."""
    return _listed(source, record_of(source).hues)


def links_of(source: Source) -> tuple[str, ...]:
    """Return the links of the model that carry a declared sensor; empty for other sources."""
    return _listed(source, record_of(source).links)


def features_of(source: Source) -> tuple[Resource, ...]:
    """Return the resources from which a source is computed; empty for a measured one."""
    return _listed(source, record_of(source).features)


def _listed(source: Source, attribute: str) -> tuple[Any, ...]:
    return getattr(source, attribute) if attribute else ()


def owner_of(source: Source) -> str:
    """Return the effector, group or hand of a source; empty without one."""
    record = record_of(source)
    return getattr(source, record.owner) if record.owner else ""


def configured(source: Source) -> str:
    """Return the effector or group whose joint positions a source is; empty for others."""
    record = record_of(source)
    return owner_of(source) if record.moves and not record.carriers else ""


def is_tip(source: Source) -> bool:
    """Return whether a source is the tip of an effector, or the tips of a group one by one."""
    record = record_of(source)
    return Carrier.TIPS in record.carriers and record.combines is None


def is_pressed(source: Source) -> bool:
    """Return whether a source is a load that grows as an arm presses its hand on an object."""
    record = record_of(source)
    return record.sums or Carrier.CELL in record.carriers


def is_located(source: Source) -> bool:
    """Return whether a source is the position of a seen object."""
    return record_of(source).located


def camera_of(resource: Resource) -> str:
    """Return the camera of a heading, ``cyclopean`` for the mean; empty for other signals."""
    is_of_one = resource.type == HEADING and record_of(resource.source).place == _CAMERA
    return declaration_of(resource.source)[1] if is_of_one else ""


def normals_of(resource: Resource) -> Normals | None:
    """Return the bodies along whose normals a resource's forces are defined, or ``None``."""
    return record_of(resource.source).normals if resource.type.name == FORCE.name else None


def declaration_of(source: Source) -> tuple[str, ...]:
    """Return the path of a source's declaration in a robot document."""
    return tuple(
        getattr(source, item[1:-1]) if item.startswith("{") else item
        for item in record_of(source).place
    )


def chains_of(resource: Resource) -> tuple[Chain, ...]:
    """Return the chains from a resource to the joints, whose Jacobians add up to its Jacobian.

    A heading changes as the cameras turn, and as the hands move that hold its target.
    """
    known = record_of(resource.source).chains
    return chains(resource.type, configuration(1))[:1] if known is None else known
