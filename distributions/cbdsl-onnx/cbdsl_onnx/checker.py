"""Check of a network against its model file and its robot, before anything moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.extend.document import (
    UNKNOWN,
    CheckedRobot,
    Diagnostics,
    Entry,
    Loaded,
    ModelSignal,
    Origin,
    Outcome,
    Resource,
    RobotDocument,
    Session,
    Unknown,
    contents,
    digest_of_bytes,
    find_document,
)
from cbdsl.extend.source import TYPES
from cbdsl_onnx import network
from cbdsl_onnx.bounded import examine_bounded
from cbdsl_onnx.lerobot_policy import digest_of_policy, examine_policy, is_policy
from cbdsl_onnx.model_file import ModelFacts, ModelFileError, TensorFacts
from cbdsl_onnx.network import InputSection, NetworkDocument, NormalisedSection
from cbdsl_onnx.plan import SUBTRACTED, InputPlan, NetworkPlan, Normalisation, OutputPlan

_ROUNDING = 1e-9
# Facts of models that were examined last, by digest.
_KEPT: dict[str, ModelFacts] = {}
_MOST_KEPT = 16
# Type of a model's input of bytes, channels of an image, and the end of its name.
_BYTES, _CHANNELS, _IMAGE = "uint8", 3, ".image"
_SIZES = {"orientation": 9, "pose": 12}
_FAULTS = {
    "format": network.UNREADABLE,
    "external": network.EXTERNAL,
    "weights": network.NOT_FINITE,
    "runtime": network.REFUSED,
}


class _Model(NamedTuple):
    sha256: str
    facts: ModelFacts


def check(loaded: Loaded[NetworkDocument], session: Session, diagnostics: Diagnostics) -> None:
    """Check a network against its robot."""
    if loaded.diagnostics:
        return  # inputs with missing parts cannot be checked
    place, library = loaded.source.place("robot"), session.library
    path = find_document(RobotDocument, loaded.document.robot, place, library, diagnostics)
    body = session.body(path, diagnostics)
    if not isinstance(body, Unknown):
        _Check(loaded, body, diagnostics).plan()


def resources(
    alias: str, loaded: Loaded[NetworkDocument], body: CheckedRobot, diagnostics: Diagnostics
) -> Outcome[tuple[Resource, ...]]:
    """Return the resources of a network; unknown with faults.

    Returns:
        Its output ``<effector>.<alias>``, and for positions ``<effector>.<alias>.withheld``: the
        distance by which the feedback stays behind it.
    """
    plan = _Check(loaded, body, diagnostics).plan()
    if isinstance(plan, Unknown):
        return UNKNOWN
    feedback = plan.output.feedback
    effector = feedback.name.partition(".")[0]
    features = (feedback, *(each for tensor in plan.inputs for each in tensor.resources))
    source = ModelSignal(
        loaded.document.name,
        "network",
        effector,
        "cbdsl_onnx.reader:reader",
        tuple(dict.fromkeys(features)),
        plan,
    )
    output = Resource(f"{effector}.{alias}", feedback.type, Origin.ENVIRONMENT, source)
    if feedback.type.name != "position":
        return (output,)
    behind = source._replace(reader="cbdsl_onnx.withheld:reader", features=(feedback, output))
    name = f"{output.name}.withheld"
    return output, Resource(name, TYPES["length"], Origin.ENVIRONMENT, behind)


def size_of(resource: Resource) -> int:
    """Return the number of components of a signal; an orientation is a matrix."""
    return _SIZES.get(resource.type.name, resource.type.size)


class _Check:
    def __init__(
        self, loaded: Loaded[NetworkDocument], body: CheckedRobot, diagnostics: Diagnostics
    ) -> None:
        self._loaded, self._body, self._diagnostics = loaded, body, diagnostics
        self._document = loaded.document
        cameras = {f"{name}{_IMAGE}" for name in body.document.cameras}
        self._images = cameras.difference(body.resources)

    def plan(self) -> Outcome[NetworkPlan]:
        """Return the network's constants; unknown if it has faults."""
        document = self._document
        self._has_time()
        model = self._model()
        inputs = [self._input(name, section) for name, section in document.inputs.items()]
        feedback = self._feedback()
        if isinstance(model, Unknown) or isinstance(feedback, Unknown):
            return UNKNOWN
        plans = [each for each in inputs if not isinstance(each, Unknown)]
        if len(plans) < len(inputs):
            return UNKNOWN
        typed = [self._fitted(each, model.facts) for each in plans]
        given = model.facts.inputs
        # A misspelt input is both missing and left over, and is reported once.
        more = given.keys() - document.inputs.keys() if UNKNOWN not in typed else ()
        for name in sorted(more):
            self._add(network.TENSOR, "inputs", problem=f"the model also needs the input '{name}'")
        output = self._output(feedback, model.facts)
        if self._diagnostics.failed or isinstance(output, Unknown):
            return UNKNOWN
        return NetworkPlan(
            str(document.path.resolve()),
            model.sha256,
            tuple(each for each in typed if not isinstance(each, Unknown)),
            output,
            document.period,
            document.deadline,
        )

    def _add(self, entry: Entry, *steps: str | int, **details: object) -> None:
        self._diagnostics.add(entry, self._loaded.source.place(*steps), **details)

    def _has_time(self) -> None:
        output, document = self._document.output, self._document
        if output.executed > output.steps:
            problem = f"{output.executed} actions are executed of a chunk of {output.steps}"
            self._add(network.TIMING, "output", "execute", problem=problem)
        elif document.deadline > output.executed * document.period:
            problem = (
                f"the deadline of {document.deadline:g} s is after the end of the executed "
                f"actions at {output.executed * document.period:g} s"
            )
            self._add(network.TIMING, "deadline", problem=problem)
        elif document.period * self._body.document.control.rate < 1.0 - _ROUNDING:
            rate = self._body.document.control.rate
            problem = (
                f"a period of {document.period:g} s is shorter than a control tick of robot "
                f"'{document.robot}', {1.0 / rate:g} s"
            )
            self._add(network.TIMING, "period", problem=problem)

    def _model(self) -> Outcome[_Model]:
        document = self._document
        try:
            data = contents(document.path, document.most_bytes)
            if is_policy(document.path):
                facts = examine_policy(document.path)
                return _Model(digest_of_policy(document.path, data), facts)
            return _examined(data)
        except OSError as error:
            reason = error.strerror or str(error)
            self._add(network.UNREADABLE, "file", file=document.file, reason=reason)
        except ModelFileError as error:
            entry = _FAULTS[error.fault]
            self._add(entry, "file", file=document.file, reason=str(error))
        except ImportError:
            reason = "onnxruntime is not installed: pip install 'cbdsl[onnx]'"
            self._add(network.REFUSED, "file", file=document.file, reason=reason)
        return UNKNOWN

    def _signal(self, text: str, *steps: str | int) -> Outcome[Resource]:
        resource = self._body.resources.get(text)
        if resource is None:
            problem = f"robot '{self._document.robot}' has no signal '{text}'"
            names = [*self._body.resources, *sorted(self._images)]
            self._add(network.SIGNAL, *steps, problem=problem, names=names, given=text)
            return UNKNOWN
        if resource.is_drawn or resource.origin is Origin.CONSTANT:
            problem = f"'{text}' is not measured"
            self._add(network.SIGNAL, *steps, problem=problem)
            return UNKNOWN
        return resource

    def _input(self, name: str, section: InputSection) -> Outcome[InputPlan]:
        if self._images.intersection(section.of):
            return self._image(name, section)
        outcomes = [
            self._signal(text, "inputs", name, "of", place) for place, text in enumerate(section.of)
        ]
        signals = tuple(each for each in outcomes if not isinstance(each, Unknown))
        if len(signals) < len(outcomes):
            return UNKNOWN
        if section.size is not None:
            problem = "only an image has a size"
            self._add(network.SIGNAL, "inputs", name, "size", problem=problem)
            return UNKNOWN
        scale = self._scale(section, sum(map(size_of, signals)), "inputs", name)
        if isinstance(scale, Unknown):
            return UNKNOWN
        return InputPlan(name, signals, scale, section.history, (), "")

    def _image(self, name: str, section: InputSection) -> Outcome[InputPlan]:
        problem = ""
        if len(section.of) > 1:
            problem = f"'{name}' joins an image with other signals; give each an input of its own"
        elif section.size is None:
            problem = (
                f"'{section.of[0]}' needs the model's height and width, such as size: [96, 96]"
            )
        if problem or section.size is None:
            self._add(network.SIGNAL, "inputs", name, "of", problem=problem)
            return UNKNOWN
        scale = self._scale(section, _CHANNELS, "inputs", name)
        if isinstance(scale, Unknown):
            return UNKNOWN
        camera = section.of[0].removesuffix(_IMAGE)
        return InputPlan(name, (), scale, section.history, (), "", camera, section.size)

    def _scale(self, section: NormalisedSection, size: int, *steps: str) -> Outcome[Normalisation]:
        for key in ("mean", "deviation"):
            numbers = getattr(section, key)
            if len(numbers) not in (0, size):
                problem = f"{key} has {len(numbers)} numbers for {size} components"
                self._add(network.NUMBERS, *steps, key, problem=problem)
                return UNKNOWN
        return Normalisation(tuple(section.mean), tuple(section.deviation))

    def _fitted(self, plan: InputPlan, facts: ModelFacts) -> Outcome[InputPlan]:
        """Return an input with the shape and type of the model's."""
        tensor = self._tensor(plan.name, facts.inputs, "input", "inputs", plan.name)
        if isinstance(tensor, Unknown):
            return UNKNOWN
        if plan.camera:
            return self._fitted_image(plan, tensor)
        if not self._has_floats(tensor, "input", "inputs", plan.name):
            return UNKNOWN
        size = sum(map(size_of, plan.resources))
        if not self._fits(tensor, plan.history, size, plan.name, "inputs", plan.name, "of"):
            return UNKNOWN
        return plan._replace(shape=tensor.shape, dtype=tensor.dtype)

    def _tensor(
        self, name: str, tensors: Mapping[str, TensorFacts], role: str, *steps: str
    ) -> Outcome[TensorFacts]:
        tensor = tensors.get(name)
        if tensor is None:
            problem = f"the model has no {role} '{name}', but {', '.join(map(repr, tensors))}"
            self._add(network.TENSOR, *steps, problem=problem)
            return UNKNOWN
        return tensor

    def _has_floats(self, tensor: TensorFacts, role: str, *steps: str) -> bool:
        if tensor.dtype and tensor.dtype != _BYTES:
            return True
        name = self._document.output.name if role == "output" else steps[-1]
        problem = f"the model's {role} '{name}' has another type than floats"
        self._add(network.TENSOR, *steps, problem=problem)
        return False

    def _fitted_image(self, plan: InputPlan, tensor: TensorFacts) -> Outcome[InputPlan]:
        rows, (height, width) = plan.history, plan.size
        first, last = (_CHANNELS, height, width), (height, width, _CHANNELS)
        # Frames of channels one after another are the same numbers as frames one after another.
        shapes = {(rows, *first): True, (rows * _CHANNELS, height, width): True}
        shapes.setdefault((rows, *last), False)
        given = _without_ones(tensor.shape)
        fits = [is_first for shape, is_first in shapes.items() if _without_ones(shape) == given]
        problem = ""
        if not fits:
            sizes = f"{rows} x {_CHANNELS} x {height} x {width}"
            problem = (
                f"'{plan.name}' of the model has shape {tensor.shape}, but images of {sizes} are "
                "given, or with the channels last"
            )
        elif not tensor.dtype:
            problem = f"the model's input '{plan.name}' has another type than bytes or floats"
        elif tensor.dtype == _BYTES and any(plan.scale):
            problem = f"the model's input '{plan.name}' takes bytes, which are not normalised"
        if problem:
            self._add(network.TENSOR, "inputs", plan.name, "of", problem=problem)
            return UNKNOWN
        return plan._replace(shape=tensor.shape, dtype=tensor.dtype, channels_first=fits[0])

    def _fits(self, tensor: TensorFacts, rows: int, size: int, name: str, *steps: str) -> bool:
        """Return whether a tensor holds rows of a size, one below another or in turn."""
        if _without_ones(tensor.shape) in (
            _without_ones((rows, size)),
            _without_ones((rows * size,)),
        ):
            return True
        problem = (
            f"'{name}' of the model has shape {tensor.shape}, but {rows} x {size} numbers are given"
        )
        self._add(network.TENSOR, *steps, problem=problem)
        return False

    def _feedback(self) -> Outcome[Resource]:
        text = self._document.output.of
        if text in self._images:
            problem = f"'{text}' is an image; an output fits {', '.join(SUBTRACTED)}"
            self._add(network.SIGNAL, "output", "of", problem=problem)
            return UNKNOWN
        feedback = self._signal(text, "output", "of")
        if isinstance(feedback, Unknown):
            return UNKNOWN
        if feedback.type.name not in SUBTRACTED:
            problem = f"'{text}' is of type {feedback.type}; an output fits {', '.join(SUBTRACTED)}"
            self._add(network.SIGNAL, "output", "of", problem=problem)
            return UNKNOWN
        return feedback

    def _output(self, feedback: Resource, facts: ModelFacts) -> Outcome[OutputPlan]:
        section, size = self._document.output, feedback.type.size
        tensor = self._tensor(section.name, facts.outputs, "output", "output", "name")
        scale = self._scale(section, size, "output")
        if isinstance(tensor, Unknown) or isinstance(scale, Unknown):
            return UNKNOWN
        if not self._has_floats(tensor, "output", "output", "name"):
            return UNKNOWN
        if not self._fits(tensor, section.steps, size, section.name, "output", "of"):
            return UNKNOWN
        return OutputPlan(
            section.name, feedback, section.gives, scale, section.steps, section.executed
        )


def _without_ones(shape: Sequence[int]) -> tuple[int, ...]:
    return tuple(size for size in shape if size != 1)


def _examined(data: bytes) -> _Model:
    """Return the digest and the facts of a model, kept by its digest."""
    sha256 = digest_of_bytes(data)
    if sha256 not in _KEPT:
        facts = examine_bounded(data)
        if len(_KEPT) >= _MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[sha256] = facts
    return _Model(sha256, _KEPT[sha256])
