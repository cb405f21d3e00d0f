"""Drivers of a robot's document: names, units, rates, and addresses that their kinds can use."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

from cbdsl.checking.robot.limits import is_of_another_kind
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown, all_known
from cbdsl.documents.driver import Driver, absolute
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.driver_addresses import addresses
from cbdsl.robot.driver_kind import DRIVERS
from cbdsl.robot.stopping_time import ACCEPTED, speeds, stopping_time
from cbdsl.robot.urdf import UrdfJoint, UrdfModel
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
# Longest times, s: a robot must not move on for longer without its program. A robot whose clock is
# behind begins each trajectory later.
_LONGEST = {"deadline": 1.0, "horizon": 1.0, "stop_deadline": 1.0, "skew": 0.15}
# Streams that several drivers may read.
_SHARED = ("states", "stop", "description")


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
        self._uninstalled: set[str] = set()

    def all(self) -> None:
        for name, driver in self._robot.drivers.items():
            self._kind(name, driver)
            self._names(name, driver)
            self._times(name, driver)
            self._stop(name, driver)
            self._stopping(name, driver)
            self._pairs(name, driver)
            self._distances(name, driver)
            self._units(name, driver)
        self._cover()
        self._shared()
        self._named_once()

    def _kind(self, name: str, driver: Driver) -> None:
        """Report an unknown kind, and the values that a known kind cannot use."""
        if driver.kind not in DRIVERS:
            self._unknown_kind(driver.kind, self._source.place("drivers", name, "kind"))
            return
        try:
            kind = DRIVERS.get(driver.kind)
        except UsageError as error:
            self._problem(name, ("kind",), str(error))
            return
        for steps, problem in kind.problems(driver):
            self._problem(name, steps, problem)

    def _unknown_kind(self, kind: str, place: Place) -> None:
        """Report an unknown kind, or once a kind whose distribution is not installed."""
        message = DRIVERS.missing().get(kind)
        if message is None:
            self._diagnostics.add("CB321", place, names=list(DRIVERS.names()), name=kind)
        elif kind not in self._uninstalled:
            self._uninstalled.add(kind)
            self._diagnostics.add("CB324", place, reason=message)

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

    def _modelled(self, driver: Driver) -> list[UrdfJoint]:
        models = {} if self._model is None else self._model.joints
        return [models[joint] for joint in self._reported(driver) if joint in models]

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
        """Report times that are shorter than a control period, or unsafely long."""
        control = self._source.known(self._robot.control, "control")
        least = 0.0 if isinstance(control, Unknown) else 1.5 / control.rate
        for key, longest in _LONGEST.items():
            value = getattr(driver, key)
            if value is not None and value > longest:
                self._problem(name, (key,), f"{value:.4g} s are more than {longest:g} s")
            elif value is not None and key != "skew" and value < least:
                problem = f"one and a half control periods, {1e3 * least:.4g} ms"
                self._problem(name, (key,), f"{1e3 * value:.4g} ms are less than {problem}")

    def _stop(self, name: str, driver: Driver) -> None:
        """Report an emergency stop whose death or silence would stay unnoticed."""
        if driver.stop is None:
            for key in ("stop_deadline", "stop_repeats"):
                if self._source.holds("drivers", name, key):
                    self._problem(name, (key,), "it has no 'stop'")
        elif driver.stop_repeats and driver.stop_deadline is None:
            self._problem(
                name,
                ("stop",),
                "it needs 'stop_deadline', such as 250 ms, the longest time between two messages "
                "of a button. State 'stop_repeats: false' if it sends changes alone: a dead or "
                "hung button then stays unnoticed for up to 20 s, and pressing it has no effect",
            )
        elif not driver.stop_repeats and driver.stop_deadline is not None:
            self._problem(
                name, ("stop_deadline",), "'stop_repeats: false' leaves it without effect"
            )

    def _distances(self, name: str, driver: Driver) -> None:
        """Report bounds that no joint ever exceeds."""
        control = self._source.known(self._robot.control, "control")
        if isinstance(control, Unknown) or not driver.moves:
            return
        short = [j for j in self._modelled(driver) if driver.tracking >= j.upper - j.lower]
        problem = ""
        if short:
            problem = (
                f"joint '{short[0].name}' moves by {short[0].upper - short[0].lower:.4g} "
                f"{short[0].unit} at most, so that it is never farther than 'tracking', "
                f"{driver.tracking:g}, from its reference; state less"
            )
        elif driver.tracking >= control.lead:
            problem = (
                f"'tracking', {driver.tracking:g}, has no effect: 'control.lead' keeps references "
                f"within {control.lead:g} of the measured positions; state less than that"
            )
        if problem:
            self._problem(name, ("tracking",), problem)

    def _stopping(self, name: str, driver: Driver) -> None:
        """Report a robot that moves on for long without its program."""
        model = self._model
        if model is None or not self._are_known("drivers", "effectors", "groups", "control"):
            return
        times = driver.deadline, driver.horizon or 0.0
        members = {m for e in driver.moves for m in self._robot.members(e)}
        if not members or not self._robot.effectors.keys() >= members or max(times) > 1.0:
            return
        if not model.joints.keys() >= set(self._reported(driver)):
            return
        self._first(name, driver, model)
        longest = max(stopping_time(self._robot, model, name))
        if longest > ACCEPTED + 5e-4:  # as printed
            place = self._source.key("drivers", name)
            details = {"time": f"{1e3 * longest:.0f}", "accepted": f"{1e3 * ACCEPTED:.0f}"}
            self._diagnostics.add("CB325", place, name=name, **details)

    def _first(self, name: str, driver: Driver, model: UrdfModel) -> None:
        """Report a ``start`` that holds fast motion at its first reference."""
        joint, _, speed = max(speeds(self._robot, model, name), key=lambda each: each[2])
        step = speed / self._robot.control.rate
        if driver.start < step - 1e-9:
            problem = (
                f"joint '{joint}' moves by {step:.3g} in its first control period at {speed:g}/s, "
                f"and 'start', {driver.start:g}, would hold it; state at least "
                f"{math.ceil(1e3 * step - 1e-6) / 1e3:g}"
            )
            self._problem(name, ("start",), problem)

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
        if driver.start > driver.tracking:
            key = "tracking" if self._source.holds("drivers", name, "tracking") else "start"
            problem = f"'start', {driver.start:g}, is more than 'tracking', {driver.tracking:g}"
            self._problem(name, (key,), problem)

    def _units(self, name: str, driver: Driver) -> None:
        """Report distances and accelerations that do not fit the joints' positions."""
        units = {joint.unit for joint in self._modelled(driver)}
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
        """Report addresses with two roles or writers, and sensors that two drivers read."""
        streams: dict[tuple[str, str], tuple[str, Steps]] = {}
        sensors: dict[Steps, str] = {}
        clashing: set[tuple[str, str]] = set()
        for name, driver in self._robot.drivers.items():
            for steps, address in addresses(driver):
                stream = driver.kind, absolute(address)
                owner, path = streams.setdefault(stream, (name, steps))
                if stream in clashing:
                    continue
                if path[0] != steps[0]:
                    clashing.add(stream)
                    problem = f"driver '{owner}' has '{address}' as its '{path[0]}' already"
                    self._problem(name, steps, problem)
                elif steps[0] in _SHARED:
                    continue
                elif (owner, path) != (name, steps):
                    self._problem(name, steps, f"driver '{owner}' has it already")
                elif len(steps) > 1 and sensors.setdefault(steps, name) != name:
                    self._problem(name, steps, f"driver '{sensors[steps]}' has it already")

    def _named_once(self) -> None:
        """Report joints that have one name in one stream of joint states."""
        named: dict[tuple[str, str, str], str] = {}
        for name, driver in self._robot.drivers.items():
            stream = driver.kind, absolute(driver.states or driver.commands or "")
            for joint in self._reported(driver):
                theirs = driver.joints.get(joint, joint)
                other = named.setdefault((*stream, theirs), joint)
                if not theirs.strip():
                    self._problem(name, ("joints", joint), "its name in messages is empty")
                elif other != joint:
                    problem = f"'{theirs}' is the name of '{other}' too"
                    self._problem(name, ("joints", joint), problem)

    def _problem(self, name: str, steps: Iterable[Step], problem: str) -> None:
        path = ("drivers", name, *steps)
        source = self._source
        place = source.place(*path) if source.holds(*path) else source.key("drivers", name)
        self._diagnostics.add("CB322", place, name=name, problem=problem)
