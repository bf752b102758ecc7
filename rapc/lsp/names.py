"""Names at a position: their declarations and uses."""

from __future__ import annotations

from collections.abc import Mapping

from rapc.analysis.facts.index import NameUse
from rapc.base.source import Span
from rapc.library.library import KINDS, Named, name_span
from rapc.library.signature import Signature
from rapc.library.signatures import Use
from rapc.lsp.positions import lies_at
from rapc.lsp.project import Part

_USES: Mapping[str, Use] = {
    "RAP": "goal",
    "predicate": "test",
    "primitive": "primitive",
    "datum": "datum",
    "skill": "skill",
    "event": "event",
}
"""A use of the names of each name space."""


def use_at(part: Part, file: str, offset: int) -> NameUse | None:
    """Return the use of a declared name at an offset of a file."""
    files = part.loaded.files
    for one in part.index.uses():
        if lies_at(one.span, file, offset) and lies_at(one.place(files), file, offset):
            return one
    return None


def declaration_at(part: Part, file: str, offset: int) -> Named | None:
    """Return the form whose defined name is at an offset of a file."""
    found = part.index.at(file, offset)
    if found is None or type(found.owner) not in KINDS:
        return None
    place = name_span(part.loaded.files, found.owner)
    return found.owner if lies_at(place, file, offset) else None


def declared(part: Part, file: str, offset: int) -> Signature | None:
    """Return the signature of the name at an offset of a file."""
    found = use_at(part, file, offset)
    if found is not None:
        return part.signatures.table(found.use).get(found.name)
    form = declaration_at(part, file, offset)
    if form is None:
        return None
    use = _USES.get(KINDS[type(form)][1])
    name = getattr(form, "name", "")
    return None if use is None else part.signatures.table(use).get(name)


def form_of(part: Part, signature: Signature) -> Named | None:
    """Return the form that declares a name."""
    for field, _, word in KINDS.values():
        if word == signature.kind:
            found: Named | None = getattr(part.library, field).get(signature.name)
            return found
    return None


def definition_of(part: Part, signature: Signature) -> Span:
    """Return the span of the name in its declaration."""
    form = form_of(part, signature)
    return signature.span if form is None else name_span(part.loaded.files, form)
