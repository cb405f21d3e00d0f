"""``cb export tree``: policies as behavior trees."""

from cbdsl.extend.command import Policy, Program, With, read_assignments, read_program


def export_tree(program: Program, policy: Policy = None, with_: With = []) -> None:  # noqa: B006
    """Print a program's policy as a behavior tree, XML of BehaviorTree.CPP 4.

    Each use of a program is a separate tree, with the values of its parameters. The model at the
    end names the leaves. Exit 2 if the next action depends on more than the state.
    """
    from cbdsl_trees.behavior_tree import behavior_tree

    print(behavior_tree(read_program(program, policy, read_assignments(with_))), end="")
