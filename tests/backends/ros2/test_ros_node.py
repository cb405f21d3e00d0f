"""Nodes: odd interfaces and domains are refused in words, before DDS reads them."""

from __future__ import annotations

import pytest

pytest.importorskip("cyclonedds")

from cbdsl.backends.backend import BackendError
from cbdsl.backends.ros2.ros_node import RosNode, domain_id


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


@pytest.mark.parametrize("text", ["233", "-1", "1.0", "x", " 1", "\u0663", "\u00b2", "9" * 5000])
def test_domain_refuses_text_that_is_no_domain(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(BackendError, match="from 0 to 232"):
        domain_id()
