"""The reference of the protocol of remote worlds: methods, types, JSON Schema."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

import msgspec

from generator.markdown import table
from generator.python import Notes
from rapc.worlds.remote import protocol
from rapc.worlds.remote.protocol import METHODS, Answer, Params

_SHARED: tuple[type, ...] = (
    protocol.Answer,
    protocol.Primitive,
    protocol.WireOption,
    protocol.WireDatum,
    protocol.WireSignal,
    protocol.WireFinished,
    protocol.WireLost,
    protocol.WireReply,
    protocol.Refusal,
    protocol.Known,
)
"""The types in several results, or in fields."""

_WORDS = {
    "str": "string",
    "Symbol": "symbol",
    "int": "integer",
    "Count": "integer",
    "bool": "boolean",
    "Plain": "boolean, number or string",
    "Time": "time",
    "Fact": "fact",
    "Change": "change",
    "Stream": "state",
    "msgspec.Raw": "any",
    "WireMessage": "message",
    "OptionalMethod": "method",
    "float": "number",
    "Picture": "picture",
}
"""The names of types on the page."""


def schema() -> str:
    """Return the JSON Schema of the protocol."""
    return json.dumps(protocol.schema(), indent=1) + "\n"


def wire() -> str:
    """Return the tables of all methods and types."""
    return "\n".join([*_methods(), *map(_type, _SHARED)])


def _methods() -> Iterator[str]:
    for method, (params, result) in METHODS.items():
        rows = [*_rows(params, Params, "params"), *_rows(result, Answer, "result")]
        optional = method not in ("describe", "open", "perform", "advance")
        said = "Optional.\n\n" if optional else ""
        fields = table(("part", "field", "type", "meaning"), rows) if rows else ""
        yield f"### {method}\n\n{said}{fields}"


def _type(kind: type) -> str:
    rows = [row[1:] for row in _rows(kind, None, "")]
    tag = msgspec.inspect.type_info(kind).tag  # type: ignore[attr-defined]
    if tag is not None:
        rows.insert(0, ("`type`", f'`"{tag}"`', "The kind of message."))
    title = kind.__name__.removeprefix("Wire")
    return f"### {title}\n\n" + table(("field", "type", "meaning"), rows)


def _rows(kind: type, base: type | None, part: str) -> Iterator[tuple[str, ...]]:
    """Yield a row for each field, except the fields of a base class."""
    inherited = set() if base is None else set(_names(base))
    notes = Notes.of(kind)
    for field in msgspec.structs.fields(kind):
        if field.name in inherited:
            continue
        required = " (required)" * field.required
        said = _words(str(kind.__annotations__[field.name])) + required
        yield part, f"`{field.encode_name}`", said, notes.get(field.name, "")


def _names(kind: type) -> list[str]:
    return [field.name for field in msgspec.structs.fields(kind)]


def _words(annotation: str) -> str:
    """Return a type in words: `list of fact`."""
    text = re.sub(r"Annotated\[(.*), Meta\(.*?\)\]", r"\1", annotation)
    text = text.removesuffix(" | None")
    if found := re.fullmatch(r"tuple\[(.*), \.\.\.\]", text):
        return f"list of {_words(found[1])}"
    if found := re.fullmatch(r"Mapping\[[^,]*, (.*)\]", text):
        return f"object of {_words(found[1])}"
    if found := re.fullmatch(r"Literal\[(.*)\]", text):
        return ", ".join(f"`{word}`" for word in found[1].split(", "))
    if " | " in text:
        words = [_words(one) for one in text.split(" | ")]
        return ", ".join(dict.fromkeys(words[:-1])) + f" or {words[-1]}"
    word = text.removeprefix("protocol.")
    return _WORDS.get(word, word.removeprefix("Wire").lower())
