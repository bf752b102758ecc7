"""What the kinds of slips share: edits of a text, and where a library offers places."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import msgspec

from rapc.analysis.facts.index import Index, NameUse, Occurrence
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.library.library import Library, word_span
from rapc.library.signatures import Signatures


class Edit(msgspec.Struct, frozen=True):
    """A slip: what is put where a span was."""

    span: Span
    content: str
    #: The name that is defined no more, which a finding elsewhere can only name.
    about: str = ""


Headed = nodes.Goal | nodes.Pattern | nodes.Step | nodes.Compare | nodes.ResourceChange
"""What is written as a list with a word at its head."""


class Base:
    """A library in which nothing is found, and what the slips ask of it.

    Args:
        library: the library.
    """

    def __init__(self, library: Library) -> None:
        self.library = library
        self.files: Mapping[str, SourceFile] = library.files
        self.index = Index(library)
        self.signatures = Signatures.of(library)
        self.raps = tuple(library.raps.values())

    def text(self, span: Span) -> str:
        """Return the text at a span."""
        return self.files[span.file].text[span.start : span.end]

    def around(self, span: Span) -> Span:
        """Return the list that a word heads and a span ends, as `(succeed ...)`."""
        text = self.files[span.file].text
        start = text.rindex("(", 0, span.start)
        return Span(span.file, start, text.index(")", span.end) + 1)

    def head(self, node: Headed) -> Span:
        """Return where the first word of a list stands."""
        return word_span(self.files, node.span, 0)

    def uses(self, use: str) -> Iterator[NameUse]:
        """Yield the uses of names of one sort outside of tests."""
        for one in self.index.uses():
            if one.use == use and type(one.owner) is not nodes.DefineTest:
                yield one

    def relations(self) -> Iterator[nodes.DeclareProperty | nodes.DeclareProposition]:
        """Yield the declarations of what memory may hold."""
        yield from self.library.properties.values()
        yield from self.library.propositions.values()

    def facts(self) -> Iterator[Occurrence[nodes.Proposition]]:
        """Yield the facts that RAPs ask, note or tell."""
        for one in self.index.of(nodes.Proposition):
            if type(one.owner) is nodes.DefineRap:
                yield one

    def requests(self) -> Iterator[nodes.Request]:
        """Yield what RAPs ask of the world."""
        for one in self.index.of(nodes.Request):
            if type(one.owner) is nodes.DefineRap:
                yield one.node

    def nets(self) -> Iterator[tuple[nodes.DefineRap, nodes.Method, nodes.TaskNet]]:
        """Yield the task-nets with their methods and RAPs."""
        for rap in self.raps:
            for method in rap.methods:
                if isinstance(method.body, nodes.TaskNet):
                    yield rap, method, method.body

    def steps(self) -> Iterator[tuple[nodes.TaskNet, nodes.Step]]:
        """Yield the steps with their task-nets."""
        for _, _, net in self.nets():
            for step in net.steps:
                yield net, step

    def contexts(self) -> Iterator[tuple[nodes.Method, nodes.And]]:
        """Yield the contexts that have several parts."""
        for rap in self.raps:
            for method in rap.methods:
                if isinstance(method.context, nodes.And):
                    yield method, method.context


Kind = Callable[[Base], Iterator[Edit]]


def misspelt(word: str) -> str:
    """Return a word with two letters in its midst swapped, or one doubled."""
    for at in range(len(word) // 2, len(word) - 1):
        if word[at] != word[at + 1] and word[at].isalpha() and word[at + 1].isalpha():
            return word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    return word + word[-1]


def negated(base: Base, formula: nodes.Formula) -> Edit:
    """Return the opposite of a formula; a `not` is left out, not written twice."""
    if isinstance(formula, nodes.Not):
        return Edit(formula.span, base.text(formula.part.span))
    return Edit(formula.span, f"(not {base.text(formula.span)})")


def misspell(base: Base, span: Span) -> Edit:
    return Edit(span, misspelt(base.text(span)))


def swap(base: Base, one: Span, other: Span) -> Edit:
    between = base.files[one.file].text[one.end : other.start]
    whole = Span(one.file, one.start, other.end)
    return Edit(whole, base.text(other) + between + base.text(one))
