"""Page of a recorded episode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.reporting.automaton_text import AutomatonData
from cbdsl.reporting.bundle import Bundle
from cbdsl.reporting.diagnoses import DIAGNOSES
from cbdsl.reporting.drawing.automaton_graph import graph_of_steps
from cbdsl.reporting.drawing.svg import svg
from cbdsl.reporting.drawn_links import DrawnLink, LinkShape, read_links
from cbdsl.reporting.recorded import Recorded
from cbdsl.reporting.template import filled
from cbdsl.reporting.thumbnails import chosen, encoded
from cbdsl.robot.meshes.mesh_reader import Mesh
from cbdsl.runtime.recording import HOLDERS

_SCRIPTS = ("vendor/three.min.js", "vendor/uPlot.iife.min.js", "page.js", "data.js", "chart.js",
            "scene.js", "viewpoints.js", "world.js", "timeline.js", "steps.js",
            "replay.js")  # fmt: skip
_STYLES = ("vendor/uPlot.min.css", "page.css", "replay.css")


def page(recorded: Recorded) -> str:
    """Return the page of a recording; the same recording gives the same text."""
    result = recorded.summary["result"]
    title = f"{result['program']}, seed {result['seed']}"
    return filled("replay.html", title, _STYLES, _SCRIPTS, _data(recorded), {})


def _data(recorded: Recorded) -> str:
    summary, bundle = recorded.summary, Bundle()
    links, automata = read_links(summary["robot"], summary["joints"]), summary.get("automata", {})
    header = {
        "result": {key: summary["result"][key] for key in _RESULT},
        "failed": recorded.failed,
        "causes": [c._asdict() for find in DIAGNOSES.all().values() for c in find(recorded)],
        "joints": summary["joints"],
        "controllers": summary["controllers"],
        "holders": [*summary["controllers"], *HOLDERS],
        "triples": summary["triples"],
        "members": summary["members"],
        "transitions": recorded.transitions,
        "steps": drawn_steps(automata),
        "leads": summary.get("leads", {}),
        "predicates": summary["predicates"],
        "cells": summary["load_cells"],
        "guards": summary.get("guards", []),
        "pairs": {
            name: each["pairs"] for name, each in summary["signals"].items() if each.get("pairs")
        },
        "links": [drawn_link(link, bundle) for link in links],
        "bodies": {
            name: [_part(part, bundle) for part in parts]
            for name, parts in summary["scene"].items()
        },
        "arrays": {key: bundle.add(array) for key, array in _series(recorded).items()},
        "cameras": _cameras(recorded, bundle),
    }
    return bundle.text(header)


#: Results shown on a page; none of them depends on the machine.
_RESULT = ("program", "stage", "context", "seed", "rewarded", "sim_seconds", "ending")


def drawn_steps(automata: Mapping[str, AutomatonData]) -> dict[str, object]:
    """Return the automata of uses of programs, each with its picture as SVG."""
    return {
        name: {**each, "svg": svg(graph_of_steps(name, each, {}))}
        for name, each in automata.items()
    }


def _series(recorded: Recorded) -> dict[str, NDArray[Any]]:
    """Return values per tick, with the precision of a page."""
    arrays = recorded.arrays
    series: dict[str, NDArray[Any]] = {
        key: arrays[key].astype(np.float32)
        for key in (
            "positions", "potentials", "scene", "level_share", "level_singular_value",
            "level_predicted",
        )
    }  # fmt: skip
    series |= {key: arrays[key] for key in ("level_priority", "level_rank", "level_held_by")}
    series["time"] = arrays["time"]
    series["at_limits"] = arrays["at_limits"].astype(np.uint8)
    if "errors" in arrays:
        series["errors"] = arrays["errors"].astype(np.float32)
    if "guard_held" in arrays:
        series["guard_held"] = arrays["guard_held"].astype(np.uint8)
    series["forces"] = np.linalg.norm(arrays["loads"][..., :3], axis=-1).astype(np.float32)
    automata = recorded.summary.get("automata", {}).values()
    compared = {name for each in automata for own in each["compared"].values() for name, _ in own}
    series |= {
        f"signal_{name}": recorded.signals[name].astype(np.float32)
        for name in sorted(compared & recorded.signals.keys())
    }
    series |= {key: arrays[key].astype(np.int16) for key in arrays if key.startswith("pair_")}
    for name, data in recorded.summary["signals"].items():
        if data["place"]:
            series[f"point_{name}"] = arrays[f"signal_{name}"].astype(np.float32)
    return series


def _cameras(recorded: Recorded, bundle: Bundle) -> dict[str, Any]:
    """Return the times of images, and the encoded images by camera."""
    kept = chosen(len(recorded.arrays["image_time"]))
    tracks: dict[str, Any] = {"time": bundle.add(recorded.arrays["image_time"][kept]), "images": {}}
    for key, images in recorded.arrays.items():
        if key.startswith("image_") and key != "image_time":
            tracks["images"][key.removeprefix("image_")] = [
                bundle.add(np.frombuffer(content, dtype=np.uint8))
                for content in encoded(images[kept])
            ]
    return tracks


def drawn_link(link: DrawnLink, bundle: Bundle) -> dict[str, object]:
    """Return a link in the form of a page's header."""
    return {**link._asdict(), "shapes": [_shape(shape, bundle) for shape in link.shapes]}


def _part(part: Mapping[str, Any], bundle: Bundle) -> Mapping[str, object]:
    """Return a visible part of an object, with its mesh in the bundle."""
    if "mesh" not in part:
        return part
    corners, triangles = (np.array(part["mesh"][key]) for key in ("corners", "triangles"))
    return {**part, "mesh": _mesh(Mesh(corners, triangles), bundle)}


def _mesh(mesh: Mesh, bundle: Bundle) -> Mapping[str, object]:
    return {
        "corners": bundle.add(mesh.corners.astype(np.float32)),
        "triangles": bundle.add(mesh.triangles.astype(np.uint16)),
    }


def _shape(shape: LinkShape, bundle: Bundle) -> Mapping[str, object]:
    data = shape._asdict()
    if shape.mesh is not None:
        data["mesh"] = _mesh(shape.mesh, bundle)
    return data
