"""Which episodes a picture of a policy shows."""

from __future__ import annotations

import pytest

from cbdsl.reproduction.checks import Check
from cbdsl.reproduction.series import REACHTOUCH
from cbdsl.reproduction.transition_diagrams import _typical
from tests.conftest import Checked
from tests.reproduction.series import experience

FOUND = [("XXX", "reach ◁ touch", "X0-"), ("X0-", "reach ◁ touch", "X11")]
CIRCLE = [("XXX", "reach ◁ touch", "X1-"), *[("X1-", "searchtrack", "X1-")] * 90]


@pytest.mark.parametrize(
    ("contexts", "shown"), [(("presented", "absent"), "X11"), (("absent",), "X1-")]
)
def test_a_picture_leaves_out_where_nothing_can_be_rewarded_unless_that_is_all(
    checked: Checked, contexts: tuple[str, ...], shown: str
) -> None:
    held_out = tuple(
        experience(*(CIRCLE if name == "absent" else FOUND), context=name) for name in contexts
    )
    diagram = _typical("fig", REACHTOUCH, checked("reachtouch"), [Check(25, held_out)])
    targets = {arc.target for arc in diagram.graph.arcs}
    assert shown in targets
    assert ("X1-" in targets) == (shown == "X1-")
