"""The one record of a file on its way from text to a library."""

from __future__ import annotations

import msgspec

from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.parser.syntax import Comment, Datum


class PartialForm(msgspec.Struct, frozen=True):
    """A form or test from which something had to be left out."""

    form: nodes.TopForm | DefineTest
    #: Whether the reader had to guess at its parentheses.
    guessed: bool


class SourceUnit(msgspec.Struct, frozen=True):
    """A file with all that reading and parsing made of it."""

    #: The name of the file and its text.
    file: SourceFile
    #: Every definition and declaration that could be made, in the order of the text.
    forms: tuple[nodes.TopForm, ...] = ()
    #: The tests of the file, kept apart: they are no part of a library.
    tests: tuple[DefineTest, ...] = ()
    #: What the reader made of the text: one datum for each top-level form.
    data: tuple[Datum, ...] = ()
    #: The comments, in the order of the text.
    comments: tuple[Comment, ...] = ()
    #: What is wrong with the text, in its order.
    diagnostics: tuple[Diagnostic, ...] = ()
    #: The forms and tests that were not read whole.
    partial: tuple[PartialForm, ...] = ()


def with_defaults(test: DefineTest, given: DefineTest) -> DefineTest:
    """Return a test with what its file says of all tests.

    What may stand once is the test's own if it says it; all else comes before.
    """
    merged = {
        name: getattr(given, name) + getattr(test, name)
        if isinstance(getattr(test, name), tuple)
        else getattr(given, name)
        if getattr(test, name) is None
        else getattr(test, name)
        for name in test.__struct_fields__
        if name not in ("name", "doc", "name_span", "span")
    }
    return msgspec.structs.replace(test, **merged)
