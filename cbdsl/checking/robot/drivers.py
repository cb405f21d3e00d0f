"""Drivers of a robot's document: names, units, rates, and addresses that their kinds can use."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from cbdsl.checking.robot.limits import is_of_another_kind
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown, all_known
from cbdsl.documents.driver import Driver
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.driver_addresses import addresses
from cbdsl.robot.driver_kind import DRIVERS
from cbdsl.robot.urdf import UrdfModel
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

Steps = tuple[Step, ...]

# Sections of a robot that define the names in a driver's section.
_SECTIONS: dict[Step, tuple[str, ...]] = {
    "moves": ("effectors", "groups"),
    "joints": ("effectors", "groups"),
    "wrenches": ("load_cells",),
    "images": ("cameras",),
    "camera_info": ("cameras",),
    "regions": ("cameras",),
}
# Units in messages about accelerations of revolute and prismatic joints.
_ACCELERATIONS = {"rad": "rad/s^2", "m": "m/s^2"}


def check_drivers(
    loaded: Loaded[RobotDocument], model: UrdfModel | None, diagnostics: Diagnostics
) -> None:
    """Check the drivers of a robot.

    Args:
        loaded: Robot.
        model: URDF of the robot; ``None`` if it cannot be read.
        diagnostics: Diagnostics so far.
    """
    if loaded.document.drivers:
        _DriverCheck(loaded, model, diagnostics).all()


class _DriverCheck:
    def __init__(
        self, loaded: Loaded[RobotDocument], model: UrdfModel | None, diagnostics: Diagnostics
    ) -> None:
        self._robot, self._source, self._diagnostics = loaded.document, loaded.source, diagnostics
        self._model = model

    def all(self) -> None:
        for name, driver in self._robot.drivers.items():
            self._kind(name, driver)
            self._names(name, driver)
            self._times(name, driver)
            self._pairs(name, driver)
            self._units(name, driver)
        self._cover()
        self._shared()

    def _kind(self, name: str, driver: Driver) -> None:
        """Report an unknown kind, and the values that a known kind cannot use."""
        if driver.kind not in DRIVERS:
            place = self._source.place("drivers", name, "kind")
            self._diagnostics.add("CB321", place, names=list(DRIVERS.names()), name=driver.kind)
            return
        try:
            kind = DRIVERS.get(driver.kind)
        except UsageError as error:
            self._problem(name, ("kind",), str(error))
            return
        for steps, problem in kind.problems(driver):
            self._problem(name, steps, problem)

    def _names(self, name: str, driver: Driver) -> None:
        """Report effectors, joints, load cells and cameras that the robot lacks."""
        robot = self._robot
        for i, effector in enumerate(driver.moves):
            names = [*robot.effectors, *robot.groups]
            self._known(name, ("moves", i), effector, names, "effector")
        for joint in driver.joints:
            self._known(name, ("joints", joint), joint, self._reported(driver), "joint of 'moves'")
        # A hand of the load cells that is no effector may be meant for one of these.
        are_hands = robot.load_cells.keys() <= robot.effectors.keys()
        for hand, fingers in driver.wrenches.items() if are_hands else ():
            self._known(name, ("wrenches", hand), hand, robot.load_cells, "hand with load cells")
            cells = robot.load_cells.get(hand)
            for finger in fingers if cells is not None else ():
                what = f"finger of '{hand}'"
                self._known(name, ("wrenches", hand, finger), finger, cells or (), what)
        for key in ("images", "camera_info", "regions"):
            for camera in getattr(driver, key):
                self._known(name, (key, camera), camera, robot.cameras, "camera")

    def _reported(self, driver: Driver) -> list[str]:
        """Return the joints whose states a driver reports."""
        robot = self._robot
        moved = [e for e in driver.moves if all(m in robot.effectors for m in robot.members(e))]
        return [joint for effector in moved or robot.effectors for joint in robot.joints(effector)]

    def _known(
        self, driver: str, steps: Steps, name: str, names: Collection[str], what: str
    ) -> None:
        source, path = self._source, ("drivers", driver, *steps)
        if name not in names and self._are_known(*_SECTIONS[steps[0]]):
            place = source.place(*path) if isinstance(steps[-1], int) else source.key(*path)
            self._diagnostics.add("CB308", place, names=list(names), name=name, what=what)

    def _are_known(self, *sections: str) -> bool:
        """Return whether no part of some sections is unknown."""
        robot = self._robot
        parts = (self._source.known(getattr(robot, name), name) for name in sections)
        return all_known(parts) is not UNKNOWN

    def _times(self, name: str, driver: Driver) -> None:
        """Report times that are shorter than a control period."""
        control = self._source.known(self._robot.control, "control")
        if isinstance(control, Unknown):
            return
        period = 1.0 / control.rate
        times = {"deadline": driver.deadline, "horizon": driver.horizon}
        for key, value in times.items():
            if value is not None and value < 1.5 * period:
                self._problem(
                    name,
                    (key,),
                    f"{1e3 * value:.4g} ms are less than one and a half control periods, "
                    f"{1.5e3 * period:.4g} ms",
                )

    def _pairs(self, name: str, driver: Driver) -> None:
        """Report keys that need another key."""
        if driver.moves and driver.commands is None:
            self._problem(name, ("moves",), "it has no 'commands' to move them by")
        if driver.commands is not None and not driver.moves:
            self._problem(name, ("commands",), "it has no effectors to move; name them in 'moves'")
        if driver.moves and driver.states is None:
            self._problem(name, ("moves",), "it has no 'states' of the joints that it moves")
        if not list(addresses(driver)):
            self._problem(name, (), "it has no address, such as 'states'")
        for other, names in _doubled(driver.joints.items()):
            self._problem(name, ("joints", names[-1]), f"'{other}' is the name of '{names[0]}' too")

    def _units(self, name: str, driver: Driver) -> None:
        """Report distances and accelerations of another kind than the joints' positions."""
        joints = () if self._model is None else self._reported(driver)
        units = {
            self._model.joints[joint].unit
            for joint in joints
            if self._model is not None and joint in self._model.joints
        }
        if len(units) != 1:
            return
        (unit,) = units
        for key in ("tracking", "start", "acceleration"):
            path = ("drivers", name, key)
            if self._source.holds(*path):
                node = self._source.node(path)
                expected = _ACCELERATIONS[unit] if key == "acceleration" else unit
                if is_of_another_kind(node.value, expected):
                    self._problem(name, (key,), f"the joints that it moves have {expected}")

    def _cover(self) -> None:
        """Report effectors that no driver moves, or that several move."""
        robot = self._robot
        if not self._are_known("drivers", "effectors", "groups"):
            return
        named = {effector for driver in robot.drivers.values() for effector in driver.moves}
        if not named <= {*robot.effectors, *robot.groups}:
            return  # an unknown name may be meant for the remaining effectors
        movers: dict[str, list[str]] = {name: [] for name in robot.effectors}
        for name, driver in robot.drivers.items():
            for effector in driver.moves:
                for member in robot.members(effector):
                    movers.setdefault(member, []).append(name)
        for effector, names in movers.items():
            if not names:
                place = self._source.key("drivers")
                self._diagnostics.add("CB323", place, name=effector)
            elif len(names) > 1:
                problem = f"driver '{names[0]}' moves effector '{effector}' already"
                self._problem(names[-1], ("moves",), problem)

    def _shared(self) -> None:
        """Report addresses that two drivers write, and sensors that two drivers read."""
        taken: dict[tuple[str, ...], str] = {}
        for name, driver in self._robot.drivers.items():
            for steps, address in addresses(driver):
                # Several drivers may read one stream of joint states, one description and one
                # emergency stop.
                if steps[0] in ("states", "stop", "description"):
                    continue
                keys = {steps if len(steps) > 1 else (), (steps[0], driver.kind, address)} - {()}
                for key in keys:
                    if key in taken:
                        self._problem(name, steps, f"driver '{taken[key]}' has it already")
                        break
                    taken[key] = name

    def _problem(self, name: str, steps: Iterable[Step], problem: str) -> None:
        path = ("drivers", name, *steps)
        source = self._source
        place = source.place(*path) if source.holds(*path) else source.key("drivers", name)
        self._diagnostics.add("CB322", place, name=name, problem=problem)


def _doubled(pairs: Iterable[tuple[str, str]]) -> Iterator[tuple[str, list[str]]]:
    """Yield each value that several keys have, and these keys."""
    keys: dict[str, list[str]] = {}
    for key, value in pairs:
        keys.setdefault(value, []).append(key)
    yield from ((value, names) for value, names in keys.items() if len(names) > 1)
