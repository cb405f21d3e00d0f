"""A schema as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.diagnostics.counting import count
from cbdsl.documents.schema import ChoiceQuestion, ChoiceTree, RewardQuestion, SchemaDocument


def schema_text(schema: SchemaDocument) -> str:
    """Text of a schema: its features and allocations, and its trees."""
    return "\n".join(_lines(schema)) + "\n"


def _lines(schema: SchemaDocument) -> Iterator[str]:
    yield f"{schema.name}, a schema of {schema.program} under policy {schema.policy}"
    for name, action in schema.actions.items():
        yield f"  action      {name} = a({action.potential}, {action.in_}, {action.out})"
    for name, signal in schema.features.items():
        yield f"  feature     {name} is {signal}"
    for name, values in schema.allocations.items():
        yield f"  allocation  {name}: {', '.join(f'{key} {v}' for key, v in values.items())}"
    if schema.provenance is not None:
        known = schema.provenance
        where = f"{known.stage.name} ({known.backend})"
        yield f"  learned     {count(known.episodes, 'episode')} on {where}, seed {known.seed}"
    if schema.reward is not None:
        yield f"\nReward is likely? Below {schema.least_reward:g} nothing is begun"
        yield from _tree(schema.reward, "  ")
        if schema.tried:
            yield "  unknown, and tried, outside of these ranges by a tenth of them:"
        for name, (low, high) in schema.tried.items():
            yield f"    {name} from {low:g} to {high:g}"
    yield "\nWhich resources first?"
    yield from _tree(schema.choose, "  ")
    yield f"  where a feature is undefined: {_answer(schema.otherwise)}"


def _tree(tree: ChoiceTree | RewardQuestion | float, margin: str) -> Iterator[str]:
    """Yield the lines of a question with both of its branches, or of an answer."""
    if not isinstance(tree, (ChoiceQuestion, RewardQuestion)):
        yield f"{margin}{_answer(tree)}"
        return
    for word, below in ((f"{tree.if_}:", tree.then), ("else:", tree.else_)):
        if isinstance(below, (ChoiceQuestion, RewardQuestion)):
            yield f"{margin}{word}"
            yield from _tree(below, f"{margin}  ")
        else:
            yield f"{margin}{word} {_answer(below)}"


def _answer(answer: str | float | tuple[str, ...]) -> str:
    if isinstance(answer, float):
        return f"{100 * answer:.0f} %"
    return answer if isinstance(answer, str) else ", then ".join(answer) or "any"
