"""Goals: motion by the actions of a controller, beside the references on its topic.

A controller of ros2_control moves the same joints by its topic and by its actions. Each client of
an action is a commander, and so is a goal that goes on after its client has ended.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any

from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.ros_node import Remote, RosNode

# Requests of goals, which clients write; and states of goals, which servers write.
_REQUESTS = re.compile(r"(?P<action>(?P<controller>.*)/[^/]+)/_action/send_goalRequest")
_STATES = re.compile(r"(?P<action>(?P<controller>.*)/[^/]+)/_action/status")
# States of action_msgs/GoalStatus in which a goal moves joints.
_ACTIVE = {1: "accepted", 2: "executing", 3: "canceling"}
_MOST = 64


def client_action(remote: Remote) -> tuple[str, str] | None:
    """Return the controller and the action whose goals a remote writer requests, if any."""
    match = _REQUESTS.fullmatch(remote.topic) if remote.writes else None
    return (match["controller"], match["action"]) if match else None


class Goals:
    """Active goals of the actions of some controllers.

    Args:
        node: Node that reads their states.
        controllers: Namespaces of the controllers, such as ``/gripper_controller``.
    """

    def __init__(self, node: RosNode, controllers: Iterable[str]) -> None:
        self._node, self._controllers = node, frozenset(controllers)
        # Reader and active goals of each action; goals are by server.
        self._readers: dict[tuple[str, str], Any] = {}
        self._active: dict[tuple[str, str], dict[int, dict[bytes, str]]] = {}

    def look(self, remotes: Iterable[Remote]) -> None:
        """Read the actions of living servers, and forget the others."""
        servers: dict[tuple[str, str], set[int]] = {}
        for remote in remotes:
            match = _STATES.fullmatch(remote.topic) if remote.writes else None
            if match and match["controller"] in self._controllers:
                servers.setdefault((match["controller"], match["action"]), set()).add(remote.handle)
        for ended in self._readers.keys() - servers.keys():
            del self._readers[ended], self._active[ended]
        for action, handles in servers.items():
            if action not in self._readers:
                topic = f"{action[1]}/_action/status"
                self._readers[action] = self._node.reader(topic, msg.GoalStatusArray, lasting=True)
            known = self._active.get(action, {})
            self._active[action] = {h: goals for h, goals in known.items() if h in handles}

    def begun(self) -> Iterator[tuple[str, str]]:
        """Yield the controller of each goal that became active since last time, and a clause."""
        for action, reader in self._readers.items():
            for message in reader.take(_MOST):
                if not message.sample_info.valid_data:
                    continue
                goals = {
                    bytes(each.goal_info.goal_id.uuid): _ACTIVE[each.status]
                    for each in message.status_list
                    if each.status in _ACTIVE
                }
                server = int(message.sample_info.publication_handle)
                before = self._active[action].get(server, {})
                self._active[action][server] = goals
                for goal in goals.keys() - before.keys():
                    yield action[0], _clause(action[1], goals[goal])

    def active(self, controller: str) -> list[str]:
        """Return a clause for each active goal of a controller."""
        return [
            _clause(action[1], state)
            for action, servers in self._active.items()
            if action[0] == controller
            for goals in servers.values()
            for state in goals.values()
        ]

    def close(self) -> None:
        """Read no more actions."""
        self._readers.clear()


def _clause(action: str, state: str) -> str:
    return f"a goal of action {action} is {state}"
