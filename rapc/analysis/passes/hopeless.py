"""RAP140 to RAP142: goals and promises that nothing a RAP does has to do with.

Told where all that the RAP may bring about is known (`rapc.analysis.effects`). A fact
that is asked for may be true already; so a goal is hopeless only if nothing in it can
be brought about.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.effects import EFFECTS, Effect
from rapc.analysis.literals import Literal, literals
from rapc.analysis.passes.settled import is_never
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import subformulas
from rapc.library.library import Library

_WORLD = """\
(declare-memory-proposition lamp-lit (?lamp))
(declare-primitive press (?lamp) (okay) :on (okay ({0}lamp-lit ?lamp{1})))
"""

HOPELESS = Rule(
    code="RAP140",
    name="hopeless-goal",
    severity=Severity.WARNING,
    summary="nothing that a RAP does brings its `succeed` about",
    why="""The methods are carried out, end well, and `succeed` still does not hold, so
they are tried again until the task is given up as futile (T 3.2.5). What primitives and
data do to memory is said behind `:on`: either the wrong primitive is asked for, or the
declaration lacks something, or `succeed` asks for the contrary.""",
    example=_WORLD.format("not (", ")")
    + """\
(define-rap (light ?lamp)
  (succeed (lamp-lit ?lamp))
  (method (primitive (press ?lamp))))
""",
    better=_WORLD.format("", "")
    + """\
(define-rap (light ?lamp)
  (succeed (lamp-lit ?lamp))
  (method (primitive (press ?lamp))))
""",
)

ENDLESS = Rule(
    code="RAP141",
    name="endless-reaction",
    severity=Severity.WARNING,
    summary="nothing that a standing task does ends the state that wakes it",
    why="""A standing task sleeps until its monitor holds, and reacts (T 4.7.1). If
nothing that it does has to do with the monitor, the state goes on, and so does the
task, without a pause, until nothing changes and it fails.""",
    example="""\
(declare-memory-proposition lamp-lit (?lamp))
(declare-memory-proposition bell-rung ())
(declare-primitive ring () (okay) :on (okay (bell-rung)))
(define-rap (warn)
  (succeed nil)
  (monitor-state (lamp-lit red))
  (method (primitive (ring))))
""",
    better="""\
(declare-memory-proposition lamp-lit (?lamp))
(declare-memory-proposition bell-rung ())
(declare-primitive ring () (okay) :on (okay (bell-rung)))
(define-rap (warn)
  (succeed nil)
  (monitor-state (and (lamp-lit red) (not (bell-rung))))
  (method (primitive (ring))))
""",
)

EMPTY = Rule(
    code="RAP142",
    name="empty-promise",
    severity=Severity.WARNING,
    summary="a RAP declares an effect that nothing it does has, or `succeed` denies",
    why="""A planner builds on `effects` (T 7.4.1). One that no primitive below has, or
the contrary of which `succeed` asks for, leads to plans that fail.""",
    example=_WORLD.format("", "")
    + """\
(define-rap (light ?lamp)
  (effects (not (lamp-lit ?lamp)))
  (succeed (lamp-lit ?lamp))
  (method (primitive (press ?lamp))))
""",
    better=_WORLD.format("", "")
    + """\
(define-rap (light ?lamp)
  (effects (lamp-lit ?lamp))
  (succeed (lamp-lit ?lamp))
  (method (primitive (press ?lamp))))
""",
)


def _run(run: Pass) -> None:
    effects = run.result(EFFECTS)
    for rap in run.library.raps.values():
        wanted = rap.succeed or rap.effects
        if not run.complete or not rap.methods or not wanted:
            continue
        for found in _against_succeed(rap):
            run.report(found)
        done = effects.of(rap.name)
        if done is not None:
            for found in (*_hopeless(run, rap, done), *_empty(rap, done)):
                run.report(found)


ANALYZER = Analyzer(
    name="hopeless",
    doc="Finds goals, reactions and promises that nothing a RAP does has to do with.",
    run=_run,
    needs=(EFFECTS,),
    rules=(HOPELESS, ENDLESS, EMPTY),
    needs_whole="form",
)


def _hopeless(
    run: Pass, rap: nodes.DefineRap, done: Sequence[Effect]
) -> Iterator[Diagnostic]:
    goal, monitor = rap.succeed, rap.monitor_state
    if goal is None:
        return
    if not is_never(goal):
        parts = goal.parts if isinstance(goal, nodes.Or) else (goal,)
        if not any(_can_come(run.library, part, done) for part in parts):
            yield Diagnostic(
                rule=HOPELESS.name,
                message=f"nothing that `{rap.name}` does brings this about",
                span=goal.span,
                help=_said(done),
            )
    elif monitor is not None and rap.monitor_time is None:
        names = {effect.name for effect in done}
        if _is_known(run.library, monitor) and not names & _asked(run.library, monitor):
            yield Diagnostic(
                rule=ENDLESS.name,
                message=f"nothing that `{rap.name}` does ends the state that wakes it",
                span=monitor.span,
                help=_said(done),
            )


def _said(done: Sequence[Effect]) -> str:
    names = sorted({f"`{effect.name}`" for effect in done})
    if not names:
        return "as far as it is declared, nothing in memory changes"
    return f"as far as it is declared, it changes {', '.join(names[:_SHOWN])}" + (
        ", ..." if len(names) > _SHOWN else ""
    )


_SHOWN = 6
"""How many names of facts are told."""


def _can_come(library: Library, part: nodes.Formula, done: Sequence[Effect]) -> bool:
    """Whether anything done may make a conjunction hold, or it is not known.

    What is compared comes from the facts beside it, or nobody knows from where.
    """
    asked = [one for one in literals(part) if not isinstance(one.formula, _BESIDE)]
    return not asked or any(_one_can_come(library, one, done) for one in asked)


_BESIDE = (nodes.Compare, nodes.Truth)


def _one_can_come(library: Library, one: Literal, done: Sequence[Effect]) -> bool:
    fact = one.formula
    if isinstance(fact, nodes.Believe):
        fact = fact.pattern
    if isinstance(fact, nodes.Proposition) and not _is_declared(library, fact.name):
        return True
    if not isinstance(fact, nodes.Proposition) or _is_computed(library, fact.name):
        if not _is_known(library, fact):
            return True
        asked = _asked(library, fact)
        return any(effect.name in asked for effect in done)
    return any(_serves(library, effect, fact, one.holds) for effect in done)


def _serves(
    library: Library, effect: Effect, fact: nodes.Proposition, holds: bool
) -> bool:
    """Whether an effect may make a fact hold, or keep it from holding."""
    if effect.name != fact.name:
        return False
    property_ = library.properties.get(fact.name)
    pairs = list(zip(effect.values, fact.args, strict=False))
    same = [
        value is None or not isinstance(term, nodes.Const) or value == term.value
        for value, term in pairs
    ]
    if property_ is None:
        return effect.gone is not holds and all(same)
    if effect.gone or len(effect.values) != len(fact.args):
        return True
    return all(same) if holds else all(same[:-1])


def _is_declared(library: Library, name: str) -> bool:
    stored = name in library.properties or name in library.propositions
    return stored or _is_computed(library, name)


def _is_computed(library: Library, name: str) -> bool:
    return name in library.functions or name in library.queries


_PLAIN = (
    nodes.Truth,
    nodes.Proposition,
    nodes.And,
    nodes.Or,
    nodes.Not,
    nodes.Compare,
    nodes.Believe,
)


def _is_known(library: Library, formula: nodes.Formula) -> bool:
    """Whether a formula asks about facts alone, through queries too."""
    return all(
        isinstance(one, _PLAIN)
        and not (isinstance(one, nodes.Proposition) and one.name in library.functions)
        for one in _through(library, formula)
    )


def _asked(library: Library, formula: nodes.Formula) -> set[str]:
    """The names of the facts that a formula asks, through queries too."""
    return {
        one.name
        for one in _through(library, formula)
        if isinstance(one, nodes.Proposition)
    }


def _through(library: Library, formula: nodes.Formula) -> Iterator[nodes.Formula]:
    waiting, seen = [formula], set[str]()
    while waiting:
        for one in subformulas(waiting.pop()):
            yield one
            name = one.name if isinstance(one, nodes.Proposition) else ""
            query = library.queries.get(name)
            if query is not None and name not in seen:
                seen.add(name)
                waiting.append(query.formula)


# --- declared effects ----------------------------------------------------------------


def _against_succeed(rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    asked = {one.formula: one for one in literals(rap.succeed)}
    for effect in rap.effects:
        one = asked.get(effect.pattern)
        if one is not None and one.holds is effect.negated:
            yield Diagnostic(
                rule=EMPTY.name,
                message="`succeed` asks for the contrary of this effect",
                span=effect.span,
                labels=(Label(one.span, "asked here"),),
            )


def _empty(rap: nodes.DefineRap, done: Sequence[Effect]) -> Iterator[Diagnostic]:
    asked = {one.formula for one in literals(rap.succeed)}
    names = {effect.name for effect in done}
    for effect in rap.effects:
        fact = effect.pattern
        if fact not in asked and fact.name not in names:
            yield Diagnostic(
                rule=EMPTY.name,
                message=f"nothing that `{rap.name}` does changes "
                f"`{format_formula(fact)}`",
                span=effect.span,
                help=_said(done),
            )
