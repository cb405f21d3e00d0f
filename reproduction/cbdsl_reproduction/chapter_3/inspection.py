"""Looks of the robot at a printed box: on the table, and in both of its hands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from cbdsl.api.control import Floats, localizability_potential
from cbdsl.api.documents import BoxForm
from cbdsl.api.sensing import EpisodeListeners, Headings, Image, NetForces, Signals, Tick
from cbdsl_reproduction.chapter_3.barcode import Barcode
from cbdsl_reproduction.simulation_fixture import SimulationFixture, simulation_fixture

#: Factor by which the pictures exceed 640 x 480 pixels, along each axis.
FINENESS = 4

_FEATURE, _BOX, _CAMERA, _ARMS = "int_10", "box", "left", "arms"
_WIDTH = 640
# Displacement in the hands below which a box counts as held, m.
_SLIP = 0.03


@dataclass(frozen=True)
class Look:
    """View of the left camera's lens, and the distance of the box.

    Attributes:
        picture: RGB, with ``FINENESS`` times 640 x 480 pixels along each axis, without noise.
        depth: Depth of the printed side along the camera's axis, by the simulator, m.
        phi: Localizability by the robot's own headings, m^2/rad^2; NaN unless both cameras see
            the whole box.
    """

    picture: Image
    depth: float
    phi: float


@dataclass
class InspectionRun:
    """Episode of taking a box in both hands and bringing it nearer.

    Attributes:
        held: Look when both hands have grasped the box, or ``None`` if they never did.
        optimum: Look at the end.
        phis: Localizability in every tick between the two looks, m^2/rad^2.
        forces: Forces along the palms' normals in each of those ticks, N.
        slip: Displacement of the box in the hands, by the simulator, m.
    """

    held: Look | None = None
    optimum: Look | None = None
    phis: list[float] = field(default_factory=list)
    forces: list[Floats] = field(default_factory=list)
    slip: float = math.inf

    @property
    def is_held(self) -> bool:
        """True if the box stayed in the hands to the end."""
        return self.held is not None and self.slip < _SLIP


class Inspection:
    """Inspection of boxes with barcodes by Dexter."""

    def __init__(self, table: SimulationFixture, hands: SimulationFixture) -> None:
        self._table = table
        self._hands = hands
        self._looker, self._handler = table.runner(), hands.runner()
        #: Period of the control ticks, s.
        self.period = hands.backend.control_period

    def on_table(self, barcode: Barcode, seed: int) -> Look:
        """Return the look when the head has the box in the middle of its images."""
        stage = barcode.printed_on(self._table.stage, _BOX)
        last: list[Tick] = []

        def note(tick: Tick) -> None:
            last[:] = [tick]

        self._looker.run(stage, seed, observer=EpisodeListeners(on_tick=note))
        return _look(self._table, last[0].signals)

    def in_hands(self, barcode: Barcode, seed: int) -> InspectionRun:
        """Take the box, and bring it to the place of best resolution (Eq 3.44)."""
        stage = barcode.printed_on(self._hands.stage, _BOX)
        record = InspectionRun()
        at_first: list[Floats] = []
        last: list[Tick] = []

        def note(tick: Tick) -> None:
            last[:] = [tick]
            localizability = next(
                run for run in tick.run.runs if run.controller.name == "localizability"
            )
            # Localizability is undefined until the box is held and both cameras see all of it.
            if math.isnan(localizability.phi):
                return
            if record.held is None:
                record.held = _look(self._hands, tick.signals)
                at_first.append(_place_in_hands(self._hands, tick.signals))
            record.phis.append(localizability.phi)
            record.forces.append(_forces(tick.signals))

        self._handler.run(stage, seed, observer=EpisodeListeners(on_tick=note))
        if at_first:
            record.optimum = _look(self._hands, last[0].signals)
            moved = _place_in_hands(self._hands, last[0].signals) - at_first[0]
            record.slip = float(np.linalg.norm(moved))
        return record


@contextmanager
def inspection() -> Iterator[Inspection]:
    """Set up both experiments on the simulator.

    Raises:
        BackendError: The simulator cannot embody the robot.
    """
    feature = {"feature": _FEATURE}
    with (
        simulation_fixture("searchtrack", feature, "barcode_on_table") as table,
        simulation_fixture("bimanualinspect", feature) as hands,
    ):
        yield Inspection(table, hands)


def _look(lab: SimulationFixture, signals: Signals) -> Look:
    view = lab.backend.cameras.views()[_CAMERA]
    times = FINENESS * _WIDTH // view.camera.width
    box = lab.stage.things[_BOX].form
    assert isinstance(box, BoxForm)
    pose = lab.backend.truth.pose(_BOX)
    side = pose.position - pose.rotation[:, 0] * box.size[0][0] / 2
    depth = float((side - view.pose.position) @ view.pose.rotation[:, 0])
    return Look(lab.backend.cameras.resolve(times)[_CAMERA], depth, _phi(signals))


def _phi(signals: Signals) -> float:
    headings = signals.sight.headings(Headings(_FEATURE), ())
    if headings is None:
        return math.nan
    potential = localizability_potential(signals.sight.cameras())
    return potential.evaluate(headings.value, np.zeros(0), 4)[0]


def _place_in_hands(lab: SimulationFixture, signals: Signals) -> Floats:
    """Return the box's position relative to the middle between the hands, m."""
    tips = [signals.tips.point(arm).position for arm in lab.robot.members(_ARMS)]
    centroid = np.mean(tips, axis=0)
    place: Floats = lab.backend.truth.pose(_BOX).position - centroid
    return place


def _forces(signals: Signals) -> Floats:
    """Return the forces along each palm's normal, N."""
    return signals.touch.palm_forces(NetForces("hands")).value
