"""Hover: what a name means, its documentation, and who uses it; the page of a rule."""

from __future__ import annotations

from lsprotocol import types

from rapc.library.signature import Signature
from rapc.lsp.names import declared, form_of
from rapc.lsp.workspace import View


def hover(view: View, position: types.Position) -> types.Hover | None:
    """Return the text for a position of a file."""
    offset = view.then(position)
    signature = declared(view.part, view.name, offset)
    if signature is None:
        return None
    return types.Hover(
        types.MarkupContent(types.MarkupKind.Markdown, _text(view, signature))
    )


def _text(view: View, signature: Signature) -> str:
    form = form_of(view.part, signature)
    doc = getattr(form, "doc", "") if form is not None else ""
    return f"```rap\n{signature.written}\n```\n\n{signature.kind}\n\n{doc}".strip()
