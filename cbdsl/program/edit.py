"""Edit of a running program: where the edited program goes on."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram


class Continuation(NamedTuple):
    """Step with which an edited program goes on.

    Attributes:
        action: Action of the step; empty for the first step of the program.
        decides: True if the step has ended, and its exits decide; False if it begins again.
        note: Clause about the step.
    """

    action: str
    decides: bool
    note: str


class EditTaken(NamedTuple):
    """Program that was replaced by its edited version during an episode.

    Attributes:
        program: Edited program.
        title: Name of the program and of its use.
        depth: Depth of use; 0 for the main program.
        time: Simulated time, s.
        note: Clause about the step with which it goes on.
    """

    program: CheckedProgram
    title: str
    depth: int
    time: float
    note: str

    def __str__(self) -> str:
        return f"takes up the edited {self.title}: {self.note}"


# Exits of the edited program may judge a state only if it belongs to the step that they are written
# for. A controller or condition that has changed has not been evaluated, so its letter means
# nothing for the exit. The step then begins again, while its unchanged controllers go on.
def continuation(
    before: CheckedProgram,
    after: CheckedProgram,
    action: Action,
    child: CheckedProgram | None,
    *,
    changed: bool,
) -> Continuation:
    """Return where an edited program goes on when the running action ends.

    Args:
        before: Program that runs.
        after: Edited program.
        action: Action that ends.
        child: Program that ran as a part of it, if any.
        changed: False if the action ends without a change of state.
    """
    name = before.steps.get(action.name, action.name)
    steps = after.steps or {each: each for each in after.policy.values()}
    same = next((each for each in after.actions if each.name == action.name in steps), None)
    if same is None:
        new = next((action for action, step in steps.items() if step == name), "")
        if new:
            return Continuation(new, False, f"step '{name}' begins again in its new form")
        return Continuation("", False, f"it has no step '{name}' and begins with its first step")
    title = steps[same.name]
    renamed = "" if title == name else f", which was '{name}',"
    conditions = [(before.conditions[n], after.conditions.get(n)) for n in action.conditions]
    is_same = (
        same._replace(program=child) == action._replace(program=child)
        and same.program == child
        and all(old == new for old, new in conditions)
    )
    if changed and is_same:
        return Continuation(same.name, True, f"the exits of step '{title}'{renamed} decide")
    return Continuation(same.name, False, f"step '{title}'{renamed} begins again")
