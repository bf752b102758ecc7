"""RAP144: effects that a RAP surely has and lacks among those that it declares."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.certain import done_by_method, fact_name
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula

_WORLD = """\
(declare-memory-proposition lamp-lit (?lamp))
(declare-memory-proposition dark (?lamp))
(declare-primitive press (?lamp) (okay)
  :on (okay (lamp-lit ?lamp) (not (dark ?lamp))))
(define-rap (light ?lamp)
  (effects (lamp-lit ?lamp){})
  (method (primitive (press ?lamp))))
"""

LACKING = Rule(
    code="RAP144",
    name="lacking-effect",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP declares effects, and lacks one that all its methods have",
    why="""A planner that reads `effects` takes what they do not name for unchanged (T
7.4.1). Here every method of the RAP, when it ends well, changes one more fact. Not all
that a RAP changes need matter to a planner; the rule is opt-in for that reason.""",
    example=_WORLD.format(""),
    better=_WORLD.format(" (not (dark ?lamp))"),
)


def _run(run: Pass) -> None:
    for rap in run.library.raps.values():
        if rap.effects and rap.methods:
            for found in _lacking(run, rap):
                run.report(found)


ANALYZER = Analyzer(
    name="declared-effects",
    doc="Finds effects that all methods of a RAP have, and the RAP does not declare.",
    run=_run,
    rules=(LACKING,),
    needs_whole="form",
)


def _lacking(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    every = [done_by_method(run.library, method) for method in rap.methods]
    common = {fact_name(one) for one in every[0]}.intersection(
        *({fact_name(one) for one in there} for there in every[1:])
    )
    named = {effect.pattern.name for effect in rap.effects}
    lacking = [one for one in every[0] if fact_name(one) in common - named]
    for one in lacking[:1]:
        written = format_formula(one.formula)
        yield Diagnostic(
            rule=LACKING.name,
            message=f"`{rap.name}` changes `{written}` too, and does not say so",
            span=rap.effects[0].span,
            labels=(Label(one.span, "declared here"),),
            help=f"add `{written if one.holds else f'(not {written})'}`",
        )
