"""RAP067: questions about a method that the RAP does not have (T 4.1.2)."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.names import renaming
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.names import Suggestions
from rapc.base.source import Span
from rapc.base.values import format_atom
from rapc.ir import nodes
from rapc.library.library import word_span

UNKNOWN = Rule(
    code="RAP067",
    name="unknown-method",
    severity=Severity.ERROR,
    summary="a question or a test names a method that its RAP does not have",
    why="""`method-tried` and `result-with-method` are about the methods of the RAP that
asks them, by their names; so is `(method rap name)` in a test, where `#1` is the first
method if it has no name. One that no method has was never tried and never had a result.
(In a RAP without methods of its own, a problem solver may bring methods with any name,
and so it may in a test that names a world.)""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="T 4.1.2",
    example="""\
(define-rap (knock))
(define-rap (ring))
(define-rap (call)
  (method bell (task-net (t1 (ring))))
  (method door (context (method-tried bel)) (task-net (t1 (knock)))))
""",
    better="""\
(define-rap (knock))
(define-rap (ring))
(define-rap (call)
  (method bell (task-net (t1 (ring))))
  (method door (context (method-tried bell)) (task-net (t1 (knock)))))
""",
)


def _names(rap: nodes.DefineRap) -> Suggestions:
    return Suggestions(format_atom(m.name) for m in rap.methods if m.name is not None)


def _names_in_traces(rap: nodes.DefineRap) -> Suggestions:
    return Suggestions(
        f"#{method.position}" if method.name is None else format_atom(method.name)
        for method in rap.methods
    )


@check(UNKNOWN, needs_whole="form")
def unknown_method(run: Pass) -> Iterator[Diagnostic]:
    """Find questions about methods that the RAP does not have."""
    index = run.result(INDEX)
    known: dict[int, Suggestions] = {}
    for found in index.of(nodes.HistoryTest):
        rap, history = found.owner, found.node
        if history.query == "last-result" or not isinstance(rap, nodes.DefineRap):
            continue
        asked = history.args[0]
        if isinstance(asked, nodes.Const) and rap.methods:
            if id(rap) not in known:
                known[id(rap)] = _names(rap)
            word = format_atom(asked.value)
            yield from _look(run, rap, word, asked.span, known[id(rap)])
    traced: dict[int, Suggestions] = {}
    for chosen in index.of(nodes.MethodChosen):
        named, test = run.library.raps.get(chosen.node.rap), chosen.owner
        # A world may bring a solver along, whose methods nobody knows before.
        if named is not None and isinstance(test, nodes.DefineTest) and not test.world:
            if id(named) not in traced:
                traced[id(named)] = _names_in_traces(named)
            place = word_span(run.library.files, chosen.node.span, 2)
            yield from _look(run, named, chosen.node.method, place, traced[id(named)])


def _look(
    run: Pass, rap: nodes.DefineRap, name: str, place: Span, known: Suggestions
) -> Iterator[Diagnostic]:
    """Yield a method's name if the RAP does not have it."""
    if name not in known:
        counted = f"#{name}"
        meant = counted if counted in known else known.near(name)
        yield UNKNOWN.at(
            place,
            f"`{rap.name}` has no method called `{name}`",
            help=f"did you mean `{meant}`?" if meant else "",
            fix=renaming(run.library.files, name, meant, [place]),
        )
