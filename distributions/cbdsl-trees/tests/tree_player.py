"""An exported tree, executed by BehaviorTree.CPP, with leaves that run a robot."""

from __future__ import annotations

import json
from collections.abc import Generator, Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import behaviortreepy
from behaviortreepy import NodeStatus

import cbdsl
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.policies.policy import DeferredPolicy
from cbdsl.runtime.tick import Tick
from cbdsl.types.state import matches
from cbdsl_trees.behavior_tree import LEAVES


@dataclass
class Run:
    """One use of a program: an episode of its own controllers, and letters of used programs."""

    robot: cbdsl.OpenRobot
    policy: DeferredPolicy
    ticks: Generator[Tick, None, EpisodeResult] | None = None
    tick: Tick | None = None
    used: tuple[int, str] | None = None
    decided_in: str = ""
    changes: int = 0
    last: str = ""

    @property
    def state(self) -> str:
        """State of the program, as conditions of the tree see it."""
        members = self.robot.request.program.members
        state = ["X"] * len(members) if self.tick is None else [*self.tick.run.state]
        if self.used is not None:
            state[self.used[0]] = self.used[1]
        return "".join(state)

    def note(self) -> None:
        """Count a change of state."""
        self.changes += self.state != (self.last or "X" * len(self.state))
        self.last = self.state

    def leave(self) -> None:
        """End the episode of the controllers."""
        if self.ticks is not None:
            self.ticks.close()
        self.ticks = self.tick = None


class TreePlayer:
    """Player of an exported tree; BehaviorTree.CPP decides all that happens.

    Its bindings know no ports, so each leaf has its ports in its name.

    Args:
        xml: The tree.
        robot: Robot of the main program, with a persistent world.
        seed: Seed of all episodes.
    """

    def __init__(self, xml: str, robot: cbdsl.OpenRobot, seed: int) -> None:
        self._robot, self._seed = robot, seed
        self._runs: dict[str, Run] = {}
        self._ticked: set[str] = set()
        self.actions: list[tuple[str, str]] = []
        factory = behaviortreepy.BehaviorTreeFactory()
        conditions = ("Rewarded", "StateMatches", "WithinLimits")
        for name in conditions:
            factory.register_simple_condition(name, self._leaf(name))
        factory.register_simple_action("SetPredicate", self._leaf("SetPredicate"))
        factory.register_simple_stateful_action(
            "RunAction", self._leaf("start"), self._leaf("goes_on"), lambda node: None
        )
        self._tree = factory.create_tree_from_text(with_ports_in_names(xml))

    def play(self, most: int = 20_000) -> NodeStatus:
        """Tick the tree until it has ended."""
        for _ in range(most):
            self._ticked.clear()
            status = self._tree.tick_exactly_once()
            for name, run in self._runs.items():
                if name not in self._ticked:
                    run.leave()
            if status != NodeStatus.RUNNING:
                return status
        raise AssertionError("it never ends")

    def _leaf(self, name: str) -> Any:
        method = getattr(self, f"_{name.lower()}")

        def tick(node: Any) -> NodeStatus:
            ports = json.loads(node.name())
            return method(self._run(ports), ports)

        return tick

    def _run(self, ports: Mapping[str, str]) -> Run:
        name = ports["run"]
        if name not in self._runs:
            pairs = (each.partition("=") for each in ports["with"].split(";") if each)
            request = cbdsl.load(
                ports["program"], values={key: value for key, _, value in pairs},
                stage=self._robot.request.stage.name,
            )  # fmt: skip
            self._runs[name] = Run(self._robot.with_program(request), DeferredPolicy())
        return self._runs[name]

    def _rewarded(self, run: Run, ports: Mapping[str, str]) -> NodeStatus:
        return _status(run.tick is not None and run.tick.run.rewarded)

    def _statematches(self, run: Run, ports: Mapping[str, str]) -> NodeStatus:
        unless = [each for each in ports["unless"].split(";") if each]
        state = run.state
        is_met = matches(ports["pattern"], state)
        return _status(is_met and not any(matches(each, state) for each in unless))

    def _withinlimits(self, run: Run, ports: Mapping[str, str]) -> NodeStatus:
        run.note()
        if ports["transitions"]:
            return _status(run.changes < int(ports["transitions"]))
        time = 0.0 if run.tick is None else run.tick.observation.time
        return _status(time < float(ports["seconds"]))

    def _setpredicate(self, run: Run, ports: Mapping[str, str]) -> NodeStatus:
        run.leave()
        place = run.robot.request.program.members.index(ports["member"])
        run.used = place, ports["predicate"]
        return NodeStatus.SUCCESS

    def _start(self, run: Run, ports: Mapping[str, str]) -> NodeStatus:
        run.used = None
        self.actions.append((ports["run"], ports["action"]))
        if run.ticks is None:
            for other in self._runs.values():
                other.leave()
            run.ticks = run.robot.ticks(self._seed, policy=run.policy)
            run.tick = next(run.ticks)
        return self._goes_on(run, ports)

    def _goes_on(self, run: Run, ports: Mapping[str, str]) -> NodeStatus:
        self._ticked.add(ports["run"])
        assert run.ticks is not None and run.tick is not None
        inner = run.tick.run
        if inner.is_open:
            if inner.transitions and inner.state == run.decided_in:
                return NodeStatus.FAILURE
            run.decided_in = inner.state
            inner.decide(ports["action"])
        if inner.predicate == "-" and inner.state == run.decided_in:
            return NodeStatus.FAILURE
        run.tick = next(run.ticks, run.tick)
        return NodeStatus.RUNNING


def _status(is_met: bool) -> NodeStatus:
    return NodeStatus.SUCCESS if is_met else NodeStatus.FAILURE


def with_ports_in_names(xml: str) -> str:
    """Return the same tree with the ports of each leaf in its name."""
    root = ElementTree.fromstring(xml)
    for tree in root.findall("BehaviorTree"):
        for node in tree.iter():
            if node.tag in LEAVES:
                ports = {key: own for key, own in node.attrib.items() if key != "name"}
                assert set(ports) == set(LEAVES[node.tag][1])
                node.attrib.clear()
                node.set("name", json.dumps(ports))
    return ElementTree.tostring(root, encoding="unicode")
