"""RAP013 and RAP014: steps and rules that ask for a RAP that is not there.

T 4.2 and 4.5.2: a step is a pattern that must match the index of a RAP.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, NameUse
from rapc.analysis.facts.names import Misuse, UnknownNames, misuses
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity, Subject
from rapc.base.values import format_list
from rapc.ir import nodes
from rapc.ir.walk import variables
from rapc.library.library import word_span

UNKNOWN = Rule(
    code="RAP013",
    name="unknown-rap",
    severity=Severity.ERROR,
    summary="a step, a rule or a test names a RAP that the library does not define",
    why="""A step asks for a RAP by its name. If no file that was read defines one of
that name, the method fails whenever it is chosen.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    ignore="where a host program or a problem solver brings the RAP, and says so when "
    "it runs",
    source="T 3.1.4",
    example="""\
(define-rap (go-to ?place))
(define-rap (go-home)
  (method (task-net (t1 (goto depot)))))
""",
    better="""\
(define-rap (go-to ?place))
(define-rap (go-home)
  (method (task-net (t1 (go-to depot)))))
""",
)

ARITY = Rule(
    code="RAP014",
    name="wrong-step-arity",
    severity=Severity.ERROR,
    summary="a RAP is given another number of inputs or outputs than its index has",
    why="""A step has to match the index of the RAP it asks for: as many inputs, and
after `=>` as many outputs. An output that is not needed is written `?`.""",
    source="T 4.2",
    example="""\
(define-rap (look-for ?thing => ?place))
(define-rap (look)
  (method (task-net (t1 (look-for)))))
""",
    better="""\
(define-rap (look-for ?thing => ?place))
(define-rap (look)
  (method (task-net (t1 (look-for box => ?)))))
""",
)


@check(UNKNOWN, ARITY)
def unknown_rap(run: Pass) -> Iterator[Diagnostic]:
    """Find steps and memory rules whose RAP is not defined, or is not met."""
    unknown = UnknownNames(UNKNOWN)
    for one in misuses(run, ("goal",), "unknown"):
        unknown.add(one.fault, one.used.place(run.library.files), one.used.owner)
    for chosen in run.result(INDEX).of(nodes.MethodChosen):
        name = chosen.node.rap
        if name not in run.signatures.raps:
            place = word_span(run.library.files, chosen.node.span, 1)
            unknown.add(run.signatures.unknown("goal", name), place, chosen.owner)
    yield from unknown.findings(run)
    for one in misuses(run, ("goal",), "arguments"):
        yield _misfit(run, one)


def _misfit(run: Pass, one: Misuse) -> Diagnostic:
    used, rap = one.used, run.library.raps[one.used.name]
    arrow = ["=>", *(v.name for v in rap.outputs)] if rap.outputs else []
    index = format_list([rap.name, *(v.name for v in rap.inputs), *arrow])
    lacks_outputs = used.outputs == 0 and rap.outputs
    return ARITY.at(
        used.span,
        one.fault.message,
        labels=(Label(rap.name_span, f"its index is `{index}`"),),
        help="write `?` after `=>` for an output that is not needed"
        if lacks_outputs
        else "",
        about=tuple(_not_handed_out(used, len(rap.outputs))) if lacks_outputs else (),
    )


def _not_handed_out(used: NameUse, outputs: int) -> Iterator[Subject]:
    """Yield the variables that a step may have for outputs, and one for each output."""
    for variable in variables(*used.node.args):
        yield Subject(used.span, variable.name)
    yield from [Subject(used.span)] * outputs
