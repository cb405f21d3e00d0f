"""Nine barcodes of Figure 3.6, in three classes of spatial frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.api.documents import BoxForm, StageDocument
from cbdsl_reproduction.chapter_3 import code39

#: Edge of every pattern, m.
SIZE = 0.1

# Low-frequency patterns: smallest width of a bar or gap, m, number of stripes, and seed.
_LEAST_WIDTH, _COUNT, _SEED = 0.015, 5, 36
_TEXTS = {"medium": ("A", "B", "C"), "high": ("ROBOT", "DEXTER", "AMHERST")}


@dataclass(frozen=True)
class Barcode:
    """Pattern of upright bars, ``SIZE`` wide and high.

    Attributes:
        name: Encoded text, or its number.
        stripes: Widths of bar, gap, ..., bar, from left to right, m.
    """

    name: str
    stripes: tuple[float, ...]

    @property
    def period(self) -> float:
        """Smallest width of a bar together with a gap beside it, m."""
        return min(a + b for a, b in zip(self.stripes, self.stripes[1:], strict=False))

    def printed_on(self, stage: StageDocument, thing: str) -> StageDocument:
        """Return the stage with this barcode in place of the pattern of one of its boxes.

        Raises:
            ValueError: The object is not a box with a pattern.
        """
        box = stage.things[thing].form
        if not isinstance(box, BoxForm) or box.pattern is None:
            raise ValueError(f"'{thing}' of stage '{stage.name}' is no box with a pattern")
        pattern = box.pattern.model_copy(update={"stripes": self.stripes, "height": SIZE})
        form = box.model_copy(update={"pattern": pattern})
        printed = stage.things[thing].model_copy(update={"form": form})
        return stage.model_copy(update={"things": {**stage.things, thing: printed}})


def barcodes() -> dict[str, tuple[Barcode, Barcode, Barcode]]:
    """Return three barcodes each of ``low``, ``medium`` and ``high`` frequency (Figure 3.6(a)).

    The source shows the low ones only in a picture, as random patterns. Ours are three draws of
    five stripes, the same in every run. The stripes are at least 15 mm wide, half of the period
    of Table 3.2.
    """
    rng = np.random.default_rng(_SEED)
    low_1, low_2, low_3 = (Barcode(str(number), _random(rng)) for number in (1, 2, 3))
    medium_1, medium_2, medium_3 = map(_code, _TEXTS["medium"])
    high_1, high_2, high_3 = map(_code, _TEXTS["high"])
    return {
        "low": (low_1, low_2, low_3),
        "medium": (medium_1, medium_2, medium_3),
        "high": (high_1, high_2, high_3),
    }


def _random(rng: np.random.Generator) -> tuple[float, ...]:
    # Shares from a flat Dirichlet distribution are uniform among all that add up to 1.
    spare = SIZE - _COUNT * _LEAST_WIDTH
    return tuple((_LEAST_WIDTH + spare * rng.dirichlet(np.ones(_COUNT))).tolist())


def _code(text: str) -> Barcode:
    widths = code39.stripes(text)
    return Barcode(text, tuple(width * SIZE / sum(widths) for width in widths))
