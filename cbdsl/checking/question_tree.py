"""Decision trees of documents: whether their questions compare known features with quantities."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.relations import RelationQuestion
from cbdsl.documents.schema import ChoiceQuestion, RewardQuestion
from cbdsl.types.decision_tree import Leaf, Split, Tree
from cbdsl.types.unit import QuantityError, parse_quantity
from cbdsl.yaml_text.source_map import SourceMap, Step

_COMPARISON = re.compile(r"^\s*([A-Za-z_][\w.]*)\s*(>|<)\s*(.+?)\s*$")
_QUESTIONS = (ChoiceQuestion, RewardQuestion, RelationQuestion)
Steps = tuple[Step, ...]
Answer = TypeVar("Answer")
_Spans = Mapping[str, tuple[float, float]]


class QuestionTrees:
    """Reader of the trees of one document.

    Args:
        source: Source map of the document.
        diagnostics: Diagnostics so far.
        units: SI unit of each feature that questions may compare; empty for a bare number.
        most: Features that count objects, with the largest number that can be distinguished.
        reported: Features with a diagnostic, which questions about them do not repeat; extended.
    """

    def __init__(
        self,
        source: SourceMap,
        diagnostics: Diagnostics,
        units: Mapping[str, str],
        most: Mapping[str, int],
        reported: set[str] | None = None,
    ) -> None:
        self._source, self._diagnostics = source, diagnostics
        self._reported = set() if reported is None else reported
        self._units, self._most = units, most

    def read(
        self,
        tree: object,
        steps: Steps,
        leaf: Callable[[Any, Steps], Answer],
        spans: _Spans | None = None,
    ) -> Tree[Answer]:
        """Return a tree as programs run it.

        Args:
            tree: Tree in the document.
            steps: Path of the tree.
            leaf: Reader of a leaf's answer.
            spans: Remaining range of each feature after the questions above, by feature.
        """
        if not isinstance(tree, _QUESTIONS):
            return Leaf(leaf(tree, steps))
        known = spans or {}
        feature, threshold, is_above = self._question(tree.if_, (*steps, "if"))
        low, high = known.get(feature, (-math.inf, math.inf))
        # Below ``x > 2``, the question ``x > 1`` has only one possible answer.
        if feature and not low < threshold < high:
            self._diagnostics.add("CB642", self._source.place(*steps, "if"), feature=feature)
        above, below = {**known, feature: (threshold, high)}, {**known, feature: (low, threshold)}
        then, other = (tree.then, "then"), (tree.else_, "else")
        over, under = (then, other) if is_above else (other, then)
        return Split(
            feature,
            threshold,
            self.read(over[0], (*steps, over[1]), leaf, above),
            self.read(under[0], (*steps, under[1]), leaf, below),
        )

    def _question(self, text: str, steps: Steps) -> tuple[str, float, bool]:
        """Return the feature, the threshold in SI units, and whether it asks for larger values."""
        match, place = _COMPARISON.match(text), self._source.place(*steps)
        if match is None:
            self._diagnostics.add("CB637", place, text=text)
            return "", 0.0, True
        feature, sign, limit = match.groups()
        if feature not in self._units:
            self.report_unknown(feature, place)
            return "", 0.0, True
        threshold = self._threshold(limit, self._units[feature], steps)
        self._occurs(feature, threshold, sign, steps)
        if sign == "<":
            # A split asks for larger values: not below the threshold is above the float before it.
            return feature, math.nextafter(threshold, -math.inf), False
        return feature, threshold, True

    def report_unknown(self, component: str, place: Place) -> None:
        """Report an unknown feature, once for all its components and uses."""
        feature = component.partition(".")[0]
        is_known = any(name.partition(".")[0] == feature for name in self._units)
        if self._units and (is_known or feature not in self._reported):
            self._diagnostics.add("CB638", place, names=list(self._units), name=component)
            self._reported.add(feature)

    def _occurs(self, feature: str, threshold: float, sign: str, steps: Steps) -> None:
        """Report a question about a number of objects that has only one possible answer."""
        most = self._most.get(feature)
        if most is None:
            return
        above = [count > threshold for count in range(most + 1)]
        below = [count < threshold for count in range(most + 1)]
        if len(set(above if sign == ">" else below)) == 1:
            details = {"feature": feature, "most": most}
            self._diagnostics.add("CB643", self._source.place(*steps), **details)

    def _threshold(self, text: str, unit: str, steps: Steps) -> float:
        place = self._source.place(*steps)
        try:
            value, given = parse_quantity(text)
        except QuantityError:
            self._diagnostics.add("CB637", place, text=text)
            return 0.0
        wanted = parse_quantity(f"1 {unit}")[1] if unit else None
        if given is not None and (wanted is None or given.dimension != wanted.dimension):
            self._diagnostics.add("CB639", place, text=text, unit=unit or "no unit")
        return value
