"""RAP162 and RAP163: variables that occur once, and declarations that nobody uses.

Both are opt-in: a name may say what a bare `?` does not, and a library for others may
declare what it does not use itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Form, Index, Occurrence
from rapc.analysis.facts.names import declared_at
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes
from rapc.library.signature import Signature
from rapc.library.signatures import Use

SINGLE = Rule(
    code="RAP163",
    name="singleton-variable",
    severity=Severity.INFO,
    opt_in=True,
    summary="a variable occurs once in its form, where a bare `?` would do",
    why="""A variable that occurs once matches anything and hands nothing on. Often
another one was meant: an input, or one bound in another clause. Where anything will do
a bare `?` says so. A name may still tell a reader what stands there; the rule is opt-in
for that reason.""",
    ignore="where the name tells a reader what stands there",
    source="T 4.1",
    example="""\
(declare-memory-proposition inside (?thing ?box))
(declare-primitive open (?box) (okay))
(define-rap (take-out ?thing)
  (preconditions (inside ?thing ?case))
  (method (primitive (open ?thing))))
""",
    better="""\
(declare-memory-proposition inside (?thing ?box))
(declare-primitive open (?box) (okay))
(define-rap (take-out ?thing)
  (preconditions (inside ?thing ?))
  (method (primitive (open ?thing))))
""",
)

UNUSED = Rule(
    code="RAP162",
    name="unused-declaration",
    severity=Severity.INFO,
    opt_in=True,
    summary="something is declared that nothing in the library uses",
    why="""A proposition, property, function, query, primitive or datum that nobody
names, or a fact that is told and that nobody asks for, is left over, or its use was
forgotten. A file of declarations for several libraries holds more than each of them
uses; the rule is opt-in for that reason.""",
    ignore="where the file declares what several libraries use",
    source="T A.1",
    example="""\
(declare-memory-proposition inside (?thing ?box))
(declare-memory-proposition on-top-of (?thing ?other))
(declare-primitive open (?box) (okay))
(define-rap (take-out ?thing ?box)
  (preconditions (inside ?thing ?box))
  (method (primitive (open ?box))))
""",
    better="""\
(declare-memory-proposition inside (?thing ?box))
(declare-primitive open (?box) (okay))
(define-rap (take-out ?thing ?box)
  (preconditions (inside ?thing ?box))
  (method (primitive (open ?box))))
""",
)


@check(SINGLE, UNUSED, needs_whole="form")
def singletons(run: Pass) -> Iterator[Diagnostic]:
    """Find variables that occur once, and declarations that nobody uses."""
    index = run.result(INDEX)
    for variable in _single(index):
        yield SINGLE.at(
            variable.span,
            f"`{variable.name}` occurs only here",
            help="write `?` if anything will do",
        )
    read = not any(run.unsure(form.span) for form in run.library.forms)
    if run.complete and read:
        for declared, how in _unused(run, index):
            yield UNUSED.at(
                declared_at(run, declared),
                f"nobody {how} `{declared.name}`",
                help="use it, or take the declaration away",
            )


def _single(index: Index) -> Iterator[nodes.Var]:
    """Yield the variables that occur once in a RAP, query or rule, and in no index."""
    once: dict[tuple[int, str], Occurrence[nodes.Var] | None] = {}
    for use in index.of(nodes.Var):
        if isinstance(use.owner, _BODIES):
            key = (id(use.owner), use.node.name)
            once[key] = use if key not in once else None
    for (_, name), only in once.items():
        if only is not None and name != "?" and not _is_declared(only):
            yield only.node


_BODIES = (nodes.DefineRap, nodes.DefineQuery, nodes.MemoryRule, nodes.EventRule)


def _is_declared(use: Occurrence[nodes.Var]) -> bool:
    """Whether this is where an input, an output or an argument is declared."""
    own: Form = use.owner
    index = isinstance(own, nodes.MemoryRule) and use.parent is own.index
    kinds = nodes.Argument | nodes.Resource
    return index or use.parent is own or isinstance(use.parent, kinds)


_FACTS: Sequence[Use] = ("test", "believed", "computed")
_TOLD: Sequence[Use] = ("asserted", "erased")


def _unused(run: Pass, index: Index) -> Iterator[tuple[Signature, str]]:
    """Yield the declarations that nobody uses, with what nobody does."""
    used = {(one.use, one.name) for one in index.uses()}
    reads = {name for f in run.library.functions.values() for name in f.reads or ()}
    for name, declared in run.signatures.predicates.items():
        if any((use, name) in used for use in _FACTS) or name in reads:
            continue
        told = any((use, name) in used for use in _TOLD)
        yield declared, "asks for" if told else "uses"
    for name, declared in run.signatures.primitives.items():
        if ("primitive", name) not in used:
            yield declared, "asks for"
    told_data = {name for p in run.library.primitives.values() for name in p.tells}
    for name, declared in run.signatures.data.items():
        if name not in told_data and ("datum", name) not in used:
            yield declared, "tells"
