"""The documents that bad examples are made from."""

from __future__ import annotations

HEAD = "cbdsl: 1\nkind: program\nname: example\nrobot: dexter\n"
SEARCH = "{potential: spring, reference: head.uniform, feedback: head, effector: head}"
TRACK = "{potential: spring, reference: [0 rad, 0 rad], feedback: cyclopean.motion, effector: head}"
URDF = """<robot name="example">
  <link name="base"/>
  <link name="neck"/>
  <link name="eye"/>
  <joint name="pan" type="revolute">
    <parent link="base"/><child link="neck"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
  </joint>
  <joint name="tilt" type="revolute">
    <parent link="neck"/><child link="eye"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
  </joint>
</robot>
"""


def program(body: str, *, head: str = HEAD, track: str = TRACK) -> str:
    """A program with a controller ``track``; ``body`` follows it."""
    return f"{head}controllers:\n  track: {track}\n{body}"


def controller(fields: str) -> str:
    """A program whose only controller has these fields."""
    return program("actions: [track]\n", track=f"{{{fields}}}")


def robot(effectors: str = "  head: {joints: [pan]}\n", more: str = "", *, base: str = "") -> str:
    """A robot with one joint, ``pan``."""
    head = base or "cbdsl: 1\nkind: robot\nname: example\nmodel: example.urdf\nbase: base\n"
    return f"{head}effectors:\n{effectors}control: {{rate: 120 Hz, tasks: {{}}}}\n{more}"


def stage(contexts: str, *, robot: str = "dexter") -> str:
    """A stage with one thing, ``ball``."""
    return (
        f"cbdsl: 1\nkind: stage\nname: example\nrobot: {robot}\n"
        "things:\n  ball: {form: {shape: ball, radius: 4 cm}, mass: 100 g}\n"
        f"contexts:\n{contexts}"
    )
