"""RAP144 and RAP145: effects that a RAP has and does not declare, or the reverse."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.hopeless import can_come
from rapc.analysis.facts.effects import EFFECTS, done_by_method
from rapc.analysis.facts.logic import Literal, fact_name, literals
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
    ignore="where a planner has no use for the effect",
    source="T 7.4.1",
    example=_WORLD.format(""),
    better=_WORLD.format(" (not (dark ?lamp))"),
)

_BOX = """\
(declare-memory-proposition lid-open (?box))
(declare-primitive lift (?box) (okay) :on (okay (lid-open ?box)))
(declare-primitive shake (?box) (okay){})
(define-rap (open ?box)
  (effects (lid-open ?box))
  (method (primitive (lift ?box)))
  (method (primitive (shake ?box))))
"""

UNCONFIRMED = Rule(
    code="RAP145",
    name="unconfirmed-effect",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP declares an effect that one of its methods is not known to have",
    why="""A planner counts on `effects` whichever method was chosen (T 7.4.1). Here a
method ends well, and nothing that is declared of what it asks for brings the effect
about, nor does `succeed` ask for it: the method leaves it out, or a primitive does not
say what it does. Told of a RAP some of whose methods are known to have the effect, and
of one of which not all is known; what surely never comes is `empty-promise`. As
much as a library says of its primitives can be confirmed; the rule is opt-in for that
reason.""",
    ignore="where the world brings the effect about, and the primitive cannot say so",
    source="T 7.4.1",
    example=_BOX.format(""),
    better=_BOX.format(" :on (okay (lid-open ?box))"),
)


@check(LACKING, UNCONFIRMED, needs_whole="form")
def declared_effects(run: Pass) -> Iterator[Diagnostic]:
    """Find effects that methods have and the RAP lacks, or the other way round."""
    for rap in run.library.raps.values():
        if rap.effects and rap.methods:
            yield from (*_lacking(run, rap), *_unconfirmed(run, rap))


def _lacking(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    every = [done_by_method(run.library, method) for method in rap.methods]
    common = {fact_name(one) for one in every[0]}.intersection(
        *({fact_name(one) for one in there} for there in every[1:])
    )
    named = {effect.pattern.name for effect in rap.effects}
    lacking = [one for one in every[0] if fact_name(one) in common - named]
    for one in lacking[:1]:
        written = format_formula(one.formula)
        yield LACKING.at(
            rap.effects[0].span,
            f"`{rap.name}` changes `{written}` too, and does not say so",
            labels=(Label(one.span, "declared here"),),
            help=f"add `{written if one.holds else f'(not {written})'}`",
        )


def _unconfirmed(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    effects = run.result(EFFECTS)
    asked = {(one.formula, one.holds) for one in literals(rap.succeed)}
    known = [effects.of_method(method) for method in rap.methods]
    for effect in rap.effects:
        promised = Literal(effect.pattern, not effect.negated)
        if (promised.formula, promised.holds) in asked or not run.complete:
            continue
        without = [
            method
            for method, (done, _) in zip(rap.methods, known, strict=True)
            if not can_come(run.library, promised, done)
        ]
        if len(without) == len(rap.methods) and all(whole for _, whole in known):
            continue
        if without:
            yield _not_confirmed(rap, effect, without[0])
            return


def _not_confirmed(
    rap: nodes.DefineRap, effect: nodes.DeclaredEffect, method: nodes.Method
) -> Diagnostic:
    written = format_formula(effect.pattern)
    return UNCONFIRMED.at(
        method.span,
        f"this method of `{rap.name}` is not known to bring "
        f"`{f'(not {written})' if effect.negated else written}` about",
        labels=(Label(effect.span, "declared here"),),
        help="say what its primitives do, or ask for the effect in `succeed`",
    )
