"""The record of a file between text and library."""

from __future__ import annotations

import msgspec

from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.parser.syntax import Comment, Datum


class PartialForm(msgspec.Struct, frozen=True):
    """A form or test with a part left out."""

    form: nodes.TopForm | DefineTest
    #: Whether the reader guessed its parentheses.
    guessed: bool


class SourceUnit(msgspec.Struct, frozen=True):
    """A file with the results of reading and parsing."""

    #: The name of the file and its text.
    file: SourceFile
    #: The valid definitions and declarations, in the order of the text.
    forms: tuple[nodes.TopForm, ...] = ()
    #: The tests of the file, which are not part of a library.
    tests: tuple[DefineTest, ...] = ()
    #: The data of the text, one for each top-level form.
    data: tuple[Datum, ...] = ()
    #: The comments, in the order of the text.
    comments: tuple[Comment, ...] = ()
    #: The findings in the text, in its order.
    diagnostics: tuple[Diagnostic, ...] = ()
    #: The forms and tests with a part left out.
    partial: tuple[PartialForm, ...] = ()


def with_defaults(test: DefineTest, given: DefineTest) -> DefineTest:
    """Return a test with the test defaults of its file.

    A single value of the test overrides the default; lists of defaults are put before
    the lists of the test.
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
