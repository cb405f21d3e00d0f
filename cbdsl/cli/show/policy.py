"""``cb show policy``: the actions of a policy as text, as data, or as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.checking.program import check_program
from cbdsl.cli.arguments.options import Above
from cbdsl.cli.output.terminal import print_json
from cbdsl.cli.show.formats import Format, Json, drawing, read_format
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.reporting.drawing.policy_graph import policy_graph
from cbdsl.reporting.drawing.policy_transitions import (
    decisions,
    policy_transitions,
    require_legible,
)
from cbdsl.reporting.text.policy_text import policy_text
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.reader import read_document

if TYPE_CHECKING:
    from cbdsl.reporting.drawing.policy_transitions import Decision, PolicyTransitions

Policy = Annotated[
    str,
    typer.Argument(
        metavar="FILE|NAME", help="Policy, or program with a written policy: file or name."
    ),
]
All = Annotated[
    bool,
    typer.Option("--all", help="Draw all states, including those without an incoming transition."),
]
FormatOption = Annotated[
    str,
    typer.Option(
        "--format",
        help="Output format: text or json; dot, mermaid or svg for the transition diagram.",
    ),
]


def show_policy(
    name: Policy,
    above: Above = 0.2,
    all_: All = False,
    format_: FormatOption = "text",
    as_json: Json = False,
) -> None:
    """Show the action of a policy in every state, and the states that follow.

    A learned policy also has action values, numbers of trials, and the transitions with a relative
    frequency of more than --above. The formats dot, mermaid and svg draw a diagram of these.
    """
    form = read_format(format_, as_json)
    policy, kinds = _read(name)
    programs = [member for member, kind in kinds.items() if kind == "program"]
    transitions = policy_transitions(policy, above, all_, programs)
    if form is Format.JSON:
        print_json(policy_data(policy, transitions))
    elif form is Format.TEXT:
        print(policy_text(policy, transitions, kinds), end="")
    else:
        print(drawing(policy_graph(transitions), form), end="")


def _read(name: str) -> tuple[PolicyDocument, dict[str, str]]:
    """Return a policy, and the kinds of those members of its program that are no controllers.

    Raises:
        UsageError, DiagnosticsError: The policy does not exist or has errors.
    """
    library = Library()
    try:
        # Policies precede programs of the same name: a learned policy often has the name of its
        # program.
        path = library.locate(PolicyDocument, name)
    except UsageError:
        # The error about policies is the better one, because it lists the known names.
        if library.find(ProgramDocument, name, library.here / name) is None:
            raise
        path = library.locate(ProgramDocument, name)
    document = read_document(path).document
    served: Path | None = path
    if isinstance(document, ProgramDocument):
        policy = _written(document, path)
    else:
        policy = library.read(path, PolicyDocument).document
        require_legible(policy, path)
        served = library.find(ProgramDocument, policy.program, path)
    if served is None:
        return policy, {}
    program = library.read(served, ProgramDocument).document
    programs = dict.fromkeys(program.use, "program")
    return policy, programs | dict.fromkeys(program.conditions, "condition")


def _written(document: object, path: Path) -> PolicyDocument:
    """Return the policy that is written in a program, as a separate document."""
    program = check_program(str(path), {})
    return PolicyDocument(
        cbdsl=1,
        kind="policy",
        name=program.name,
        program=program.name,
        predicates=program.members,
        policy=dict(program.policy),
    )


def policy_data(policy: PolicyDocument, transitions: PolicyTransitions) -> dict[str, object]:
    """Return a policy as data of JSON: all known states, and the arcs of its diagram."""
    return {
        "name": policy.name,
        "program": policy.program,
        "state": list(policy.predicates),
        "models": dict(policy.models),
        "states": [_state(policy, decision) for decision in decisions(policy)],
        "above": transitions.above,
        "arcs": [arc._asdict() for arc in transitions.arcs],
        "provenance": policy.provenance and policy.provenance.model_dump(mode="json"),
    }


def _state(policy: PolicyDocument, decision: Decision) -> dict[str, object]:
    return {
        "state": decision.state,
        "action": decision.action,
        "value": decision.value,
        "values": dict(policy.values.get(decision.state, {})),
        "tried": decision.tried,
        "met": decision.met,
        "started": decision.started,
        "ended": decision.ended,
        "after": {state: decision.share(state) for state in decision.after},
    }
