"""CB62n: policies that were learned."""

from __future__ import annotations

from cbdsl.errors.codes.example import SEARCH, program
from cbdsl.errors.entry import Entry

_LOOKING = program("actions: [track]\n", track=SEARCH).replace("example", "looking")
_PROGRAMS = {"programs/looking.yaml": _LOOKING}
_MODEL = (
    "cbdsl: 1\nkind: model\nname: window\nrobot: dexter\neffector: head\n"
    "density: {form: gaussian, mean: [0.1, 1], deviation: [0.3, 0.2]}\n"
)
_HAND = _MODEL.replace("head", "right_hand").replace("[0.1, 1]", "[0, 1, 1, 1]")
_MODELS = {
    "knowledge/models/window.yaml": _MODEL,
    "knowledge/models/grip.yaml": _HAND.replace("window", "grip").replace(
        "[0.3, 0.2]", "[0.1, 0.2, 0.2, 0.2]"
    ),
}
_POLICY = (
    "cbdsl: 1\nkind: policy\nname: example\nprogram: looking\npredicates: [track]\n"
    'policy: {"*": track}\n'
)
_DIGEST = "0123456789abcdef" * 4
_LEARNED = f"""provenance:
  command: cb learn looking --stage table_right --out example.yaml
  program: {{name: looking, sha256: {_DIGEST}}}
  robot: {{name: dexter, sha256: {_DIGEST}}}
  stage: {{name: table_right, sha256: {_DIGEST}}}
  actions: [track]
  algorithm: accommodate
  constants: {{gamma: 0.8, alpha: 0.1, epsilon: 0.2}}
  seed: 1
  episodes: 50
  backend: bullet
  renderer: tiny
  versions: {{cbdsl: 0.1.0}}
"""

_POLICIES = {
    "programs/other.yaml": _LOOKING.replace("looking", "other"),
    "knowledge/policies/looking_learned.yaml": _POLICY.replace("example", "looking_learned"),
    "knowledge/policies/other_learned.yaml": _POLICY.replace("example", "other_learned").replace(
        "program: looking", "program: other"
    ),
}
_USER = program("actions: [track, looking]\nuse: {looking: {program: looking, policy: %s}}\n")

POLICIES = (
    Entry(
        "CB622",
        "policy of a program that has changed",
        "program '{program}' is not what it was when this was learned; again: {command}",
        "What was learned of a program need not hold after its controllers or actions changed. "
        "Learn it again, or take `provenance` away to vouch for the policy yourself.",
        _POLICY + _LEARNED,
        "knowledge/policies/example.yaml",
        _PROGRAMS,
        good=_POLICY,
    ),
    Entry(
        "CB623",
        "model that the program has no use for",
        "program '{program}' draws from no internal model '{name}'",
        "`models` gives other densities to internal models that references of the program's "
        "controllers name, such as `head.uniform`.",
        _POLICY + "models: {head.unform: window}\n",
        "knowledge/policies/example.yaml",
        _PROGRAMS | _MODELS,
        good=_POLICY + "models: {head.uniform: window}\n",
    ),
    Entry(
        "CB624",
        "model of another effector",
        "model '{model}' is of '{other}', and '{name}' of '{effector}'",
        "Only a density over the configurations of the same effector can take a model's place.",
        _POLICY + "models: {head.uniform: grip}\n",
        "knowledge/policies/example.yaml",
        _PROGRAMS | _MODELS,
        good=_POLICY + "models: {head.uniform: window}\n",
    ),
    Entry(
        "CB625",
        "unknown policy",
        "there is no policy '{name}'{hint}",
        "A policy is `knowledge/policies/<name>.yaml`, next to this document, here, or shipped.",
        _USER % "lokking_learned",
        beside=_PROGRAMS | _POLICIES,
        good=_USER % "looking_learned",
    ),
    Entry(
        "CB626",
        "policy of another program",
        "policy '{name}' serves program '{other}', and not '{program}'",
        "A program can be used under a policy that was written or learned for it.",
        _USER % "other_learned",
        beside=_PROGRAMS | _POLICIES,
        good=_USER % "looking_learned",
    ),
)
