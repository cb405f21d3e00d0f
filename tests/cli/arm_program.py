"""A program of one arm that needs no camera, for tests that edit it."""

from __future__ import annotations

TEXT = """\
cbdsl: 1
kind: program
name: raise_arm
robot: sixaxis
stage: sixaxis_bin

controllers:
  ready: {potential: spring, reference: arm.ready, feedback: arm, effector: arm}
  reach:
    potential: spring
    reference: [70 cm, -30 cm, 70 cm]
    feedback: arm.position
    effector: arm.position
  condition:
    potential: manipulability
    feedback: arm
    effector: arm
    gain: 20 /s
    quiescence: {rate: 1e-4, window: 0.3 s}

actions: [ready, reach, condition, condition ◁ reach]

policy:
  XXX: ready
  0XX: ready
  1XX: reach
  X0X: reach
  X1X: condition ◁ reach
  X*0: condition ◁ reach
  X01: condition ◁ reach
"""
