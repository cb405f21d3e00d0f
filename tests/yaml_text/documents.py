"""Arbitrary documents of every kind."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from cbdsl.documents.calibration import CalibrationDocument
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.documents.document import Document
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.relations import RelationsDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.documents.shared import SharedDocument
from cbdsl.documents.stage import StageDocument

Data = st.SearchStrategy[dict[str, Any]]

NAME = st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,6}", fullmatch=True)
# Texts that some YAML readers convert to other types.
TRAPS = st.sampled_from(
    ["NO", "yes", "1e-3", "0755", "12:30:45", "~", "null", "", ".inf", "0x1F", "=", "<<", "%", "@"]
) | st.sampled_from(
    [
        "a: b",
        "# a",
        "- a",
        "*",
        "&a",
        "'",
        '"',
        " a ",
        "a\nb",
        "\t",
        "\x85",
        "\u2028",
        "<|",
        "◁",
        "!",
    ]
)
TEXT = st.text(max_size=12) | TRAPS
NUMBER = st.floats(-1e6, 1e6, allow_nan=False) | st.integers(-1000, 1000).map(float)
POSITIVE = st.floats(1e-6, 1e6)
SHARE = st.floats(0, 1)


def data(required: dict[str, Any], optional: dict[str, Any] | None = None) -> Data:
    return st.fixed_dictionaries(required, optional=optional or {})


def many(
    values: st.SearchStrategy[Any], keys: st.SearchStrategy[str] = NAME, least: int = 0
) -> Data:
    return st.dictionaries(keys, values, min_size=least, max_size=3)


def head(kind: str) -> dict[str, Any]:
    return {
        "cbdsl": st.just(1),
        "kind": st.just(kind),
        "name": NAME,
        "description": TEXT,
    }


QUIESCENCE = data({"rate": POSITIVE, "window": POSITIVE}, {"within": POSITIVE})
CONTROLLER = data(
    {"potential": NAME, "feedback": TEXT, "effector": TEXT},
    {
        "reference": TEXT | NUMBER | st.lists(TEXT | NUMBER, max_size=3),
        "gain": POSITIVE,
        "speed": POSITIVE,
        "quiescence": QUIESCENCE,
        "free_axis": st.sampled_from("xyz"),
        "axes": st.lists(st.sampled_from("xyz"), max_size=3),
        "onset": data({"change": POSITIVE}, {"window": POSITIVE, "pace": NUMBER}),
        "seek": data({}, {"once": NAME, "within": NUMBER, "until": NUMBER}),
        "requires": NAME,
    },
)
PROGRAM = data(
    {
        **head("program"),
        "robot": NAME,
        "controllers": many(CONTROLLER | TEXT),
        "actions": st.lists(TEXT, min_size=1, max_size=3),
    },
    {
        "parameters": many(TEXT),
        "use": many(data({"program": NAME}, {"with": many(TEXT)})),
        "policy": many(TEXT, TEXT),
        "limits": data({}, {"transitions": st.integers(1, 99), "transition_time": POSITIVE}),
    },
)
EFFECTOR = data(
    {"joints": st.lists(TEXT, min_size=1, max_size=3)},
    {
        "tip": data({"link": TEXT}, {"offset": st.tuples(NUMBER, NUMBER, NUMBER)}),
        "postures": many(st.lists(NUMBER, max_size=3)),
    },
)
ROBOT = data(
    {
        **head("robot"),
        "model": TEXT,
        "base": TEXT,
        "effectors": many(EFFECTOR),
        "control": data(
            {"rate": POSITIVE, "tasks": many(data({"gain": POSITIVE, "quiescence": QUIESCENCE}))}
        ),
    },
    {
        "couplings": many(data({"follows": TEXT, "ratio": NUMBER}), TEXT),
        "vision": data({}, {"rate": POSITIVE, "renderer": st.sampled_from(["auto", "tiny"])}),
    },
)
SPAN = NUMBER | st.tuples(NUMBER, NUMBER)
SIZE = POSITIVE | st.tuples(POSITIVE, POSITIVE)
FORM = data({"shape": st.just("ball"), "radius": SIZE}) | data(
    {"shape": st.just("box"), "size": st.tuples(SIZE, SIZE, SIZE)}
)
STAGE = data(
    {
        **head("stage"),
        "robot": NAME,
        "things": many(
            data({"form": FORM, "mass": POSITIVE}, {"color": st.tuples(SHARE, SHARE, SHARE)})
        ),
        "contexts": many(
            data(
                {}, {"share": POSITIVE, "place": data({"x": SPAN, "z": SPAN}), "joints": many(SPAN)}
            ),
            least=1,
        ),
    }
)
COUNT = st.integers(1, 10**9)
STATES = st.text("X-01", min_size=1, max_size=4)
POLICY = data(
    {
        **head("policy"),
        "program": NAME,
        "predicates": st.lists(TEXT, max_size=3),
        "policy": many(TEXT, TEXT),
    },
    {
        "models": many(NAME, TEXT),
        "values": many(many(NUMBER, TEXT), STATES),
        "transitions": many(many(many(COUNT, STATES), TEXT), STATES),
        "curve": data(
            {
                "context": st.just(["here", "there"]),
                "reward": st.tuples(COUNT, COUNT),
                "transitions": st.tuples(COUNT, COUNT),
                "ticks": st.tuples(COUNT, COUNT),
            }
        ),
    },
)

VECTOR = st.lists(NUMBER, min_size=1, max_size=3)
WIDTHS = st.lists(POSITIVE, min_size=1, max_size=3)
GAUSSIAN = data({"form": st.just("gaussian"), "mean": VECTOR, "deviation": WIDTHS})
KERNEL = data(
    {
        "form": st.just("kernel"),
        "samples": st.lists(VECTOR, min_size=1, max_size=3),
        "bandwidth": WIDTHS,
    }
)
MODEL = data({**head("model"), "robot": NAME, "effector": NAME, "density": GAUSSIAN | KERNEL})

LEAF = st.one_of(NAME, st.lists(NAME, max_size=2))
SCHEMA = data(
    {
        **head("schema"),
        "program": NAME,
        "policy": NAME,
        "features": many(TEXT, least=1),
        "allocations": many(many(NAME), least=1),
        "choose": st.recursive(
            LEAF, lambda tree: data({"if": TEXT, "then": tree, "else": tree}), max_leaves=4
        ),
        "otherwise": st.lists(NAME, min_size=1, max_size=2),
    },
    {
        "actions": many(data({"potential": NAME, "in": TEXT, "out": TEXT})),
        "reward": st.recursive(
            SHARE, lambda tree: data({"if": TEXT, "then": tree, "else": tree}), max_leaves=4
        ),
        "least_reward": SHARE,
    },
)
TRIPLE = st.lists(NUMBER, min_size=3, max_size=3)
CALIBRATION = data(
    {
        **head("calibration"),
        "robot": NAME,
        "cameras": many(
            data(
                {
                    "position": TRIPLE,
                    "rotation": TRIPLE,
                    "position_deviation": POSITIVE,
                    "rotation_deviation": NUMBER,
                    "views": st.integers(1, 99),
                    "error_before": POSITIVE,
                    "error_after": POSITIVE,
                }
            ),
            least=1,
        ),
    }
)
SAMPLES = data(
    {
        "count": st.integers(1, 99),
        "mean": st.tuples(NUMBER, NUMBER),
        "covariance": st.tuples(st.tuples(NUMBER, NUMBER), st.tuples(NUMBER, NUMBER)),
    }
)
AFFORDANCE = data(
    {"program": NAME, "tried": st.just(9), "rewarded": st.integers(0, 9)},
    {
        "with": many(TEXT),
        "interval": st.tuples(SHARE, SHARE),
        "features": many(data({"signal": TEXT, "unit": TEXT, "components": st.integers(1, 9)})),
        "with_reward": SAMPLES,
        "without_reward": SAMPLES,
        "habituation": data(
            {"variance": POSITIVE, "change": POSITIVE, "habituated": st.booleans()}
        ),
        "value": NUMBER,
        "failed": TEXT,
    },
)
CATALOG = data(
    {**head("catalog"), "robot": NAME, "feature": TEXT, "affordances": many(AFFORDANCE, least=1)},
    {"over": st.lists(NAME, max_size=2)},
)
META_CATALOG = data(
    {
        **head("meta_catalog"),
        "robot": NAME,
        "things": many(data({"feature": TEXT}, {"catalog": NAME}), least=1),
    },
    {
        "pairs": many(AFFORDANCE.map(lambda own: {**own, "upper": "a", "lower": "b"})),
        "over": st.lists(NAME, max_size=2),
    },
)

RELATIONS = data(
    {
        **head("relations"),
        "robot": NAME,
        "program": NAME,
        "tree": st.recursive(
            NAME, lambda tree: data({"if": TEXT, "then": tree, "else": tree}), max_leaves=4
        ),
    },
    {"samples": many(st.lists(st.lists(POSITIVE, min_size=6, max_size=6), max_size=2))},
)

SHARED = data(
    {**head("shared"), "robot": NAME},
    {
        "parameters": many(TEXT),
        "controllers": many(
            data({"potential": NAME}, {"feedback": TEXT, "gain": POSITIVE}) | TEXT,
            st.from_regex(r"[a-z]{1,5}(\([a-z]{1,3}(, [a-z]{1,3})?\))?", fullmatch=True),
        ),
        "conditions": many(TEXT),
    },
)

#: Documents of each kind.
DOCUMENTS: dict[str, st.SearchStrategy[Document]] = {
    "robot": ROBOT.map(RobotDocument.model_validate),
    "program": PROGRAM.map(ProgramDocument.model_validate),
    "stage": STAGE.map(StageDocument.model_validate),
    "policy": POLICY.map(PolicyDocument.model_validate),
    "model": MODEL.map(ModelDocument.model_validate),
    "schema": SCHEMA.map(SchemaDocument.model_validate),
    "calibration": CALIBRATION.map(CalibrationDocument.model_validate),
    "catalog": CATALOG.map(CatalogDocument.model_validate),
    "shared": SHARED.map(SharedDocument.model_validate),
    "relations": RELATIONS.map(RelationsDocument.model_validate),
    "meta_catalog": META_CATALOG.map(MetaCatalogDocument.model_validate),
}
