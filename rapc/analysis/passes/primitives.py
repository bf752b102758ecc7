"""RAP020 and RAP021: requests to the world that no declaration knows, or that miss it.

What the world offers is declared in the library; no world is imported to find out
(semantics 1).
"""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.arity import wrong_arity
from rapc.analysis.names import Names
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.unknown import Unknown
from rapc.base.diagnostics import Rule, Severity
from rapc.ir import nodes
from rapc.library.library import name_span, word_span

UNDECLARED = Rule(
    code="RAP020",
    name="undeclared-primitive",
    severity=Severity.ERROR,
    summary="a method requests a primitive that is not declared",
    why="""A primitive is a request to the world. What the world offers is declared, so
that a library can be checked without the world; what is not declared nobody answers. A
step of a task-net is no primitive: it names a RAP.""",
    example="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?arm ?thing)
  (method (primitive (arm-grsp ?arm ?thing))))
""",
    better="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?arm ?thing)
  (method (primitive (arm-grasp ?arm ?thing))))
""",
)

ARITY = Rule(
    code="RAP021",
    name="wrong-primitive-arity",
    severity=Severity.ERROR,
    summary="a request has another number of arguments than its primitive",
    why="""The world takes a request with the arguments that were declared for it and
no others.""",
    example="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?thing)
  (method (primitive (arm-grasp ?thing))))
""",
    better="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?thing)
  (method (primitive (arm-grasp left ?thing))))
""",
)


def _run(run: Pass) -> None:
    known = run.library.primitives
    advice = "declare it with `declare-primitive`, or `require` the file that does"
    unknown = Unknown(UNDECLARED, "no primitive is called `{}`", Names(known), advice)
    for use in run.result(OCCURRENCES).of(nodes.Primitive):
        request = use.node.request
        declared = known.get(request.name)
        if declared is None:
            place = word_span(run.library.files, request.span, 0)
            unknown.add(request.name, place)
        elif len(declared.args) != len(request.args):
            place = name_span(run.library.files, declared)
            said = (declared.name, declared.args, place)
            run.report(wrong_arity(ARITY, request, said))
    unknown.report(run)


ANALYZER = Analyzer(
    name="primitives",
    doc="Finds requests for primitives that are not declared, or declared otherwise.",
    run=_run,
    needs=(OCCURRENCES,),
    rules=(UNDECLARED, ARITY),
)
