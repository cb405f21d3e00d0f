"""Nodes: odd interfaces and domains are refused in words, before DDS reads them."""

from __future__ import annotations

import socket
from contextlib import ExitStack

import pytest

pytest.importorskip("cyclonedds")

from cbdsl.backends.backend import BackendError
from cbdsl_ros2 import ros_node
from cbdsl_ros2.ros_node import RosNode, domain_id


@pytest.mark.parametrize(
    "interface", ["nope0", "\x1b[2J", 'lo"/><Nope name="', "lo ", "127.0.0", "999.1.1.1", "é"]
)
def test_node_refuses_an_unknown_interface_without_words_of_dds(
    interface: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "99")
    with pytest.raises(BackendError, match=r"unknown network interface .*known: .*lo"):
        RosNode(interface)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "given",
    ["<foo", "file:///nope.xml", "<CycloneDDS><Domain><Nope>1</Nope></Domain></CycloneDDS>"],
)
def test_node_names_a_configuration_that_dds_cannot_read(
    given: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "99")
    monkeypatch.setenv("CYCLONEDDS_URI", given)
    with pytest.raises(BackendError, match="CYCLONEDDS_URI") as raised:
        RosNode()
    assert given in str(raised.value)


def test_node_without_a_free_port_names_the_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "96")
    ports = (
        "<CycloneDDS><Domain><Discovery><ParticipantIndex>auto</ParticipantIndex>"
        "<MaxAutoParticipantIndex>0</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>"
    )
    monkeypatch.setattr(ros_node, "_LOCAL", ports)
    # The first participant of a domain listens at these ports (DDSI-RTPS, 9.6.1.1).
    first = 7400 + 250 * 96 + 10
    with ExitStack() as stack:
        for port in (first, first + 1):
            taken = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            taken.bind(("", port))
        with pytest.raises(
            BackendError, match=r"cannot open domain 96 at .* 'lo'; .*ROS_DOMAIN_ID"
        ):
            RosNode()


@pytest.mark.parametrize("text", ["233", "-1", "1.0", "x", " 1", "\u0663", "\u00b2", "9" * 5000])
def test_domain_refuses_text_that_is_no_domain(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(BackendError, match="from 0 to 232"):
        domain_id()
