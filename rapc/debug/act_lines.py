"""Acts of the user as JSON, and back.

An act is an object: `do` names the kind of act, the other keys are its fields. Facts,
patterns, signals and tasks are texts of the language. A reloaded library is its files.
What is read is not trusted: all values are checked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Union

import msgspec

from rapc.base.source import SourceFile
from rapc.base.values import Fact, format_list
from rapc.compiler.program import Program
from rapc.debug import acts
from rapc.debug.acts import Act
from rapc.debug.arguments import read_pattern
from rapc.debug.recorded_lines import Int
from rapc.debug.reload import TakeUp, checked
from rapc.library.loader import load_sources
from rapc.parser.parse import parse_signal
from rapc.runtime.task_request import TaskRequest, as_text, read_task_request

KINDS: tuple[type[Act], ...] = (
    acts.AssertFact,
    acts.EraseFacts,
    acts.SubmitTask,
    acts.CancelTasks,
    acts.SendSignal,
    acts.FailTask,
    acts.RetryTask,
    acts.ChangeOption,
    acts.ForceResult,
    TakeUp,
)
"""All kinds of acts."""


class File(msgspec.Struct, frozen=True):
    """A file of a library, with its text."""

    file: str
    text: str


class Library(msgspec.Struct, frozen=True):
    """A library as text."""

    name: str
    files: tuple[File, ...]


def library_in_text(program: Program) -> Library:
    """Return a library as text."""
    files = program.library.files.items()
    return Library(program.name, tuple([File(name, one.text) for name, one in files]))


def read_library(given: Library) -> Program:
    """Return the library of some texts; `require` is not followed.

    Raises:
        CheckError: if the checker reports an error.
    """
    sources = [SourceFile(one.file, one.text) for one in given.files]
    return checked(load_sources(sources), given.name).library.program


def _read_list(text: str) -> Fact:
    return parse_signal(text) if text.startswith("(:") else read_pattern(text)


class _Form(msgspec.Struct, frozen=True):
    """The form of a field in a file: its type there, and both conversions."""

    type: Any
    write: Callable[[Any], Any]
    read: Callable[[Any], Any]


_FORMS: Mapping[Any, _Form] = {
    Fact: _Form(str, format_list, _read_list),
    TaskRequest: _Form(str, as_text, read_task_request),
    Program: _Form(Library, library_in_text, read_library),
    int: _Form(Int, int, int),
}
"""The forms of fields by their types; all other types are written as they are."""


@cache
def _line(kind: type[Act]) -> type[msgspec.Struct]:
    """Return the type of the JSON object for a kind of act."""
    config = kind.__struct_config__
    fields = []
    for field in msgspec.structs.fields(kind):
        form = _FORMS.get(field.type)
        fields.append((field.name, field.type if form is None else form.type))
    return msgspec.defstruct(
        f"{kind.__name__}Line",
        fields,
        tag=config.tag,
        tag_field=config.tag_field,
        forbid_unknown_fields=True,
        frozen=True,
    )


@cache
def line_types() -> Any:
    """Return the union of the types of the JSON objects for acts."""
    return Union[tuple(_line(kind) for kind in KINDS)]  # noqa: UP007  # made at run time


def written(act: Act) -> msgspec.Struct:
    """Return an act in the form of a file, to be encoded as JSON."""
    values = {}
    for field in msgspec.structs.fields(act):
        form, value = _FORMS.get(field.type), getattr(act, field.name)
        values[field.name] = value if form is None else form.write(value)
    return _line(type(act))(**values)


def read(line: msgspec.Struct) -> Act:
    """Return the act of a decoded JSON object.

    Raises:
        TextError: for a text that is not of the language.
        CheckError: for a library with errors.
    """
    tags = {kind.__struct_config__.tag: kind for kind in KINDS}
    kind = tags[line.__struct_config__.tag]
    values = {}
    for field in msgspec.structs.fields(kind):
        form, value = _FORMS.get(field.type), getattr(line, field.name)
        values[field.name] = value if form is None else form.read(value)
    return kind(**values)
