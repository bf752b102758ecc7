"""Validation of IR from a compiled library, which may come from any author.

The decoder has already validated the types. This module validates the properties that
parser and checker guarantee for sources: valid words and numbers, declared names with
the right number of arguments, existing steps. Warnings of the checker are not repeated.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from functools import cache
from operator import attrgetter
from typing import Any

from rapc.base.limits import LARGEST_NUMBER, MAX_NODE_DEPTH, MAX_PARTS
from rapc.base.names import plural
from rapc.base.source import Span
from rapc.ir import nodes, walk
from rapc.ir.schema import CHILDREN, rule_of
from rapc.language.grammar import RULES
from rapc.language.heads import CALLS
from rapc.library.signatures import Fault, Signatures, Use

_FORBIDDEN = frozenset(' ()";')
_RESOURCES = ("#counter(", "#set(")
_LOOKED_AT = frozenset({nodes.Var, nodes.Call, nodes.SetTest, nodes.HistoryTest})


class UnsoundError(Exception):
    """An error for IR that no source compiles to; the text is a short reason."""


class Verifier:
    """A validator for the definitions of a library.

    All methods raise UnsoundError for invalid definitions.

    Args:
        signatures: the declarations of the library; its RAPs need not be decoded.
        files: the names of its files, for the check of spans; None for no check.
    """

    def __init__(
        self, signatures: Signatures, files: Container[str] | None = None
    ) -> None:
        self._signatures = signatures
        self._files = files
        self._words: set[object] = set()

    def node(self, node: nodes.Node) -> None:
        """Check the words, numbers, nesting and computed terms of any node."""
        level: list[Any] = [node]
        for _ in range(MAX_NODE_DEPTH):
            level = self._below(level)
            if not level:
                return
        raise UnsoundError("a node is nested too deeply")

    def _below(self, level: list[Any]) -> list[Any]:
        """Validate a level of nodes and return the next; `level` grows by tuples."""
        below: list[Any] = []
        words, files, contents = self._words, self._files, _contents()
        for value in level:
            kind: Any = type(value)
            if kind is str:
                if value not in words:
                    words.add(_word(value))
            elif kind is Span:
                if files is not None and value.file not in files:
                    raise UnsoundError("a node has no file")
            elif kind is tuple:
                level.extend(value)
            elif (content := contents.get(kind)) is not None:
                if kind in _LOOKED_AT:
                    self._own(value)
                below.extend(content(value))
            elif kind is int or kind is float:
                _number(value)
        return below

    def _own(
        self, node: nodes.Var | nodes.Call | nodes.SetTest | nodes.HistoryTest
    ) -> None:
        """Validate the parts that only some kinds of nodes have."""
        if isinstance(node, nodes.Var):
            if node.name[:1] != "?":
                raise UnsoundError(f"`{node.name}` is not the name of a variable")
        elif isinstance(node, nodes.Call):
            self._call(node)
        elif len(node.args) != (takes := len(RULES[rule_of(node)]) - 2):
            word = node.test if isinstance(node, nodes.SetTest) else node.query
            wanted = plural(takes, "argument")
            raise UnsoundError(f"`{word}` takes {wanted}, not {len(node.args)}")

    def declaration(self, form: nodes.TopForm) -> None:
        """Validate a form that is not a RAP."""
        self.node(form)
        if isinstance(form, nodes.DeclareProperty):
            for exclusion in form.excludes:
                self._known("asserted", exclusion.pattern)
        elif isinstance(form, nodes.DefineQuery):
            self.formula(form.formula)
        elif isinstance(form, nodes.DefineAgenda):
            for task in form.tasks:
                self._goal(task.goal, given=True)
        elif isinstance(form, nodes.DefineMethod):
            if form.rap not in self._signatures.raps:
                raise UnsoundError(f"unknown RAP `{form.rap}`")
        elif isinstance(form, nodes.DefineRap):
            raise UnsoundError("a RAP is among the declarations")

    def rap(self, rap: nodes.DefineRap) -> None:
        """Validate a RAP."""
        try:
            self._rap(rap)
        except UnsoundError as error:
            raise UnsoundError(f"in `{rap.name}`: {error}") from None

    def _rap(self, rap: nodes.DefineRap) -> None:
        self.node(rap)
        for at in walk.formulas(rap):
            self.formula(at.formula)
        for method in rap.methods:
            for pattern in method.notations:
                self._known("asserted", pattern)
            for skill in method.skills:
                self._known("skill", skill)
            if isinstance(method.body, nodes.Primitive):
                self._known("primitive", method.body.request)
            elif isinstance(method.body, nodes.Skills):
                for skill in (*method.body.enable, *method.body.disable):
                    self._known("skill", skill)
            elif isinstance(method.body, nodes.TaskNet):
                self._steps(method.body.steps)

    def formula(self, formula: nodes.Formula) -> None:
        """Validate the names and the size of a formula."""
        for count, part in enumerate(walk.subformulas(formula)):
            if count > MAX_PARTS:
                raise UnsoundError("a formula is too large")
            if isinstance(part, nodes.Pattern):
                self._known("test", part)

    def _known(self, use: Use, pattern: nodes.Pattern) -> None:
        _raise(self._signatures.fault(use, pattern.name, len(pattern.args)))

    def _call(self, call: nodes.Call) -> None:
        if call.function not in CALLS:
            _raise(self._signatures.fault("computed", call.function, len(call.args)))
        elif not call.args:
            raise UnsoundError(f"`{call.function}` has no arguments")

    def _steps(self, steps: Sequence[nodes.Step]) -> None:
        tags = {step.tag for step in steps}
        if len(tags) < len(steps):
            raise UnsoundError("duplicate step tag")
        for step in steps:
            self._goal(step.goal)
            for tag in _tags(step):
                if tag not in tags:
                    raise UnsoundError(f"unknown step `{tag}`")

    def _goal(self, goal: nodes.Goal, *, given: bool = False) -> None:
        """Validate a goal; a `given` goal need not name its outputs."""
        outputs: int | None = len(goal.outputs)
        if given:
            outputs = outputs or None
        _raise(self._signatures.fault("goal", goal.name, len(goal.args), outputs))


def _raise(fault: Fault | None) -> None:
    if fault is not None:
        raise UnsoundError(fault.message)


def _tags(step: nodes.Step) -> Iterator[str]:
    """Yield the tags of steps in a step's annotations."""
    for annotation in step.annotations:
        if isinstance(annotation, nodes.For | nodes.UntilStart | nodes.UntilEnd):
            yield annotation.tag
        elif isinstance(annotation, nodes.Window):
            yield from {annotation.reference} - {"now", "absolute"}


@cache
def _contents() -> Mapping[type, Callable[[Any], Iterable[Any]]]:
    """Return for each kind of node a function that returns the parts to validate."""
    return {kind: _content(kind) for kind in CHILDREN}


def _content(kind: type[nodes.Node]) -> Callable[[Any], Iterable[Any]]:
    if kind is nodes.Require:
        return lambda node: (node.span,)
    names = [name for name in kind.__struct_fields__ if name != "doc"]
    return attrgetter(*names) if len(names) > 1 else lambda node: (node.span,)


def _word(word: str) -> str:
    """Return a valid word of the language or resource in a trace, or raise."""
    parted = not _FORBIDDEN.isdisjoint(word) and not word.startswith(_RESOURCES)
    if not word or not word.isprintable() or parted:
        raise UnsoundError(f"{ascii(word)[:60]} is not a word of the language")
    return word


def _number(value: float) -> None:
    """Validate that a number is in its canonical form and within the limit."""
    whole = isinstance(value, float) and value.is_integer()
    if whole or abs(value) > LARGEST_NUMBER:
        raise UnsoundError("a number is not finite")
