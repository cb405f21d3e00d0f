"""Declaration of a verb: a dataclass whose fields are its inputs, each written once.

The signature and the docstring of the verb, the call that repeats it, and the options of its
command derive from the fields.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, dataclass_transform

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest

Inputs = ParamSpec("Inputs")
Request = TypeVar("Request")
Result = TypeVar("Result")


# Sentences about inputs of several verbs.
SEED = "Seed of all random draws."
BACKEND = "Name of the backend, as for ``open_robot``; the first installed one if ``None``."
CAMERAS = "Kind of cameras, as for ``open_robot``."
CONSTANTS = "Constants of the algorithm, by name, in SI or as text with units."
COMMAND = "Command that repeats the call, for the provenance of documents; the call if empty."
FOLDER = "Folder to search for documents by name; the working folder if ``None``."


def given(
    text: str,
    *,
    default: Any = MISSING,
    default_factory: Any = MISSING,
    kw_only: bool = True,
    always: bool = False,
    recorded: bool = True,
    **option: Any,
) -> Any:
    """Return the field of an input.

    Args:
        text: Sentence that describes it.
        default: Default, as for ``dataclasses.field``.
        default_factory: Function that returns a mutable default.
        kw_only: False if a call needs no keyword.
        always: True if recorded calls contain it with its default, too.
        recorded: False if the result does not depend on it.
        option: Option of the command, unless commands share one for this input: ``kind``, its
            type; ``help``, a sentence if not the text; ``flag``, if it is not named like the
            input, or ``-`` for an argument; ``group``, its heading; ``completes``, the kind of
            document whose names a shell completes; and settings such as ``min``.
    """
    metadata = {"text": text, "always": always, "recorded": recorded, "option": option}
    return field(
        default=default, default_factory=default_factory, kw_only=kw_only, metadata=metadata
    )


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(given,))
def declaration(request: type[Request]) -> type[Request]:
    """Return a class of requests, whose fields are from ``given`` and become its docstring."""
    made = dataclass(frozen=True)(request)
    made.__doc__ = f"{inspect.getdoc(made)}\n\n{described('Attributes', made)}\n"
    return made


def verb(
    request: Callable[Inputs, Request],
) -> Callable[[Callable[[Request], Result]], Callable[Inputs, Result]]:
    """Return a decorator that turns a function of a request into one of the request's inputs."""

    def decorated(function: Callable[[Request], Result]) -> Callable[Inputs, Result]:
        def call(*args: Inputs.args, **kwargs: Inputs.kwargs) -> Result:
            return function(request(*args, **kwargs))

        returned = inspect.signature(function).return_annotation
        parameters = dict(inspect.signature(request).parameters)
        for each in fields(request):  # type: ignore[arg-type]
            if (default := default_of(each)) is not MISSING:
                parameters[each.name] = parameters[each.name].replace(default=default)
        signature = inspect.Signature([*parameters.values()], return_annotation=returned)
        call.__signature__ = signature  # type: ignore[attr-defined]
        call.__name__ = call.__qualname__ = function.__name__
        call.__module__ = function.__module__
        before, raises, after = (inspect.getdoc(function) or "").partition("Raises:")
        call.__doc__ = f"{before}{described('Args', request)}\n\n{raises}{after}"
        return call

    return decorated


def default_of(declared: Field[Any]) -> Any:
    """Return the default of an input or an option; ``MISSING`` if it has to be given."""
    factory = declared.default_factory
    return declared.default if factory is MISSING else factory()


def described(heading: str, request: Any) -> str:
    """Return the section of a docstring that describes all inputs."""
    lines = [f"{heading}:"]
    for each in fields(request):
        text = re.sub(r" \[(.+)\]\.$", r"; \1 if ``None``.", each.metadata["text"])
        line = f"{each.name}: {text}"
        lines.append(textwrap.fill(line, 96, initial_indent="    ", subsequent_indent=" " * 8))
    return "\n".join(lines)


def engine_of(request: Any) -> str:
    """Return the backend of a request; the first installed one if it names none."""
    from cbdsl.backends.engines import default_engine

    return default_engine() if request.backend is None else str(request.backend)


def load_text(run: RunRequest, values: Mapping[str, str]) -> str:
    """Return the call that loads a program on its stage, with values of its parameters."""
    inputs = (run.program.name, run.stage.name, dict(values))
    return "cbdsl.load({!r}, stage={!r}, values={!r})".format(*inputs)


def call_text(name: str, request: Any, **texts: str) -> str:
    """Return the call of a verb that repeats a request, for the provenance of documents.

    Args:
        name: Name of the verb, with its module.
        request: Request.
        texts: Texts of the inputs that are written otherwise.
    """
    words = []
    for each in fields(request):
        value, declared = getattr(request, each.name), each.metadata
        if each.name == "backend":
            value = engine_of(request)
        is_default = value == default_of(each)
        if each.name not in texts and (
            not declared["recorded"] or (is_default and not declared["always"])
        ):
            continue
        text = texts.get(each.name) or repr(dict(value) if isinstance(value, Mapping) else value)
        words.append(f"{each.name}={text}" if each.kw_only else text)
    return f"{name}({', '.join(words)})"
