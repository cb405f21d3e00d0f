"""Facts of the sources of resources, one record for each type of source."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum, auto
from typing import NamedTuple

from cbdsl.types.casts import (
    CAMERA,
    RIGID_HOLD,
    SIGHTING,
    SIZE_TURN,
    TRIANGULATION,
    Chain,
    chains,
)
from cbdsl.types.resource import (
    AffordanceProbability,
    BlobSignal,
    Centroid,
    ConstellationSignal,
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    GaussianSample,
    GraspCentre,
    Heading,
    Headings,
    InstanceCount,
    KernelSample,
    MarkHeading,
    NetForces,
    NetLoad,
    NovelHeading,
    ObjectDistance,
    Opening,
    PairLikeness,
    Posture,
    Resource,
    SensorSignal,
    Separation,
    SolidSignal,
    Source,
    StereoOffset,
    StereoPosition,
    StereoSignal,
    SurfacePoint,
    Tip,
    UniformSample,
)
from cbdsl.types.resource_type import POSITION, configuration


class Carrier(Enum):
    """Bodies that carry a signal's sensors or the sensed object."""

    TIPS = auto()
    CELL = auto()
    CELLS = auto()
    CAMERAS = auto()
    HOLD = auto()
    LINKS = auto()


class SourceRecord(NamedTuple):
    """Facts of one type of source.

    Attributes:
        place: Path of the declaration in a robot document. An item in braces is an attribute of
            the source.
        owner: Attribute that names the effector, group or hand; empty without one.
        moves: True if the joints of the owner move the signal.
        channels: Attributes that name its visual channels.
        compares: True if it compares objects of two channels.
        carriers: Bodies that carry its sensors or the sensed object.
        differs: True if joints that move all its carriers do not change it.
        chains: Chains of casts to the joints; ``None`` for the shortest chain of its type.
    """

    place: tuple[str, ...]
    owner: str = ""
    moves: bool = False
    channels: tuple[str, ...] = ()
    compares: bool = False
    carriers: tuple[Carrier, ...] = ()
    differs: bool = False
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
    EffectorConfiguration: SourceRecord(_EFFECTOR, "effector", moves=True),
    Tip: SourceRecord(_EFFECTOR, "effector", moves=True, carriers=_TIPS),
    Centroid: SourceRecord(_GROUP, "group", moves=True, carriers=_TIPS),
    Separation: SourceRecord(_GROUP, "group", moves=True, carriers=_TIPS),
    FingerLoad: SourceRecord((*_HAND, "{finger}"), "hand", carriers=(Carrier.CELL,)),
    NetLoad: SourceRecord(_HAND, "hand", carriers=_CELLS),
    NetForces: SourceRecord(_GROUP, "group", carriers=_CELLS),
    FingerForces: SourceRecord(_HAND, "hand", carriers=_CELLS),
    Opening: SourceRecord(_HAND, "hand", carriers=_CELLS, differs=True),
    GraspCentre: SourceRecord(_HAND, "hand", carriers=_CELLS),
    Heading: SourceRecord(
        _CAMERA, channels=_ONE, carriers=_SEEN, chains=((CAMERA,), (SIGHTING, *_HOLD))
    ),
    Headings: SourceRecord(
        _CAMERAS, channels=_ONE, carriers=_SEEN, chains=((CAMERA,), (TRIANGULATION, *_HOLD))
    ),
    StereoPosition: SourceRecord(_CAMERAS, channels=_ONE, carriers=_HELD, chains=(_HOLD,)),
    BlobSignal: SourceRecord(_CAMERA, channels=_ONE, carriers=_SEEN),
    StereoSignal: SourceRecord(_CAMERAS, channels=_ONE, carriers=_HELD),
    ObjectDistance: SourceRecord(_CAMERAS, channels=_ONE, carriers=_HELD),
    InstanceCount: SourceRecord(_CAMERAS, channels=_ONE),
    SurfacePoint: SourceRecord(_CAMERAS, channels=_ONE),
    NovelHeading: SourceRecord(_CAMERAS, channels=_ONE, carriers=_EYES, chains=((CAMERA,),)),
    MarkHeading: SourceRecord(
        _CAMERAS, channels=("channel", "hues"), carriers=_EYES, chains=((CAMERA,),)
    ),
    ConstellationSignal: SourceRecord(_CAMERA, channels=_TWO, compares=True, carriers=_EYES),
    StereoOffset: SourceRecord(_CAMERAS, channels=_TWO, compares=True, carriers=_EYES),
    SolidSignal: SourceRecord(
        _CAMERAS, channels=_TWO, compares=True, carriers=_EYES, chains=((SIZE_TURN,),)
    ),
    AffordanceProbability: SourceRecord(_CAMERAS),
    PairLikeness: SourceRecord(_CAMERAS, compares=True, carriers=_EYES),
    SensorSignal: SourceRecord(("sensors", "{sensor}"), carriers=(Carrier.LINKS,)),
    Posture: SourceRecord((*_EFFECTOR, "postures", "{posture}"), "effector"),
    UniformSample: SourceRecord(_EFFECTOR, "effector"),
    GaussianSample: SourceRecord(_EFFECTOR, "effector"),
    KernelSample: SourceRecord(_EFFECTOR, "effector"),
}


def record_of(source: Source) -> SourceRecord:
    """Return the record of a source's type."""
    return RECORDS[type(source)]


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


def owner_of(source: Source) -> str:
    """Return the effector, group or hand of a source; empty without one."""
    record = record_of(source)
    return getattr(source, record.owner) if record.owner else ""


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
