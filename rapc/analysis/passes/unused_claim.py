"""RAP084 and RAP086: things that nobody else could want, or that are misspelt."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sized

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.close_names import Close
from rapc.analysis.index import INDEX, Occurrence
from rapc.analysis.renaming import renaming
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.names import Suggestions, plural
from rapc.ir import nodes
from rapc.ir.printer import format_formula

UNUSED = Rule(
    code="RAP084",
    name="unused-claim",
    severity=Severity.INFO,
    summary="a method claims a thing that nothing uses and no other method claims",
    why="""A claim keeps others from what they use or claim themselves. Things are not
declared: one that nothing else names, with as many arguments, keeps nobody from
anything, and is likely misspelt or left over.""",
    fix="unsafe: writes the thing that is spelled almost so, where there is one",
    ignore="where another library uses the thing, and runs beside this one",
    source="L 8",
    example="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(define-rap (go ?to) (method (primitive (drive ?to))))
(define-rap (visit ?to)
  (method (claims weels) (task-net (t1 (go ?to)))))
""",
    better="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(define-rap (go ?to) (method (primitive (drive ?to))))
(define-rap (visit ?to)
  (method (claims wheels) (task-net (t1 (go ?to)))))
""",
)

MISSPELT = Rule(
    code="RAP086",
    name="misspelt-thing",
    severity=Severity.WARNING,
    summary="a thing is named only once, and another one is spelled almost so",
    why="""Things are not declared: whoever uses or claims one keeps others off who name
it in the same way. One that nobody else names keeps nobody off, so two primitives that
need the same arm are under way at once. If it is another thing, give it a name that
shows so.""",
    fix="unsafe: writes the thing that is spelled almost so",
    ignore="where the two things are meant: give one of them a name that is less like "
    "the other",
    source="L 8",
    example="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(declare-primitive turn (?to) (okay) :uses (wheels))
(declare-primitive dock () (okay) :uses (wheles))
""",
    better="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(declare-primitive turn (?to) (okay) :uses (wheels))
(declare-primitive dock () (okay) :uses (wheels))
""",
)

_LEAST = 3
"""How long the name of a thing must be to be close to another."""

_Sort = tuple[str, int]
"""A thing by its name and number of arguments."""


def _run(run: Pass) -> None:
    users: dict[_Sort, set[int]] = {}
    claims: list[Occurrence[nodes.Thing]] = []
    for thing in run.result(INDEX).of(nodes.Thing):
        users.setdefault(_sort(thing), set()).add(id(thing.parent))
        if isinstance(thing.parent, nodes.Method):
            claims.append(thing)
    told = _misspelt(run, users)
    lone = [claim for claim in claims if len(users[_sort(claim)]) == 1]
    lone = [claim for claim in lone if id(claim.node) not in told]
    kept = users.keys() - {_sort(claim) for claim in lone}
    near = Suggestions(sorted({name for name, _ in kept}))
    users_known = not any(run.unsure(one.span) for one in _offers(run))
    for claim in lone if run.complete and users_known else ():
        run.report(_finding(run, claim.node, near, users))


def _misspelt(run: Pass, users: Mapping[_Sort, Sized]) -> set[int]:
    """Report things named once whose names are close; return the ids of their nodes."""
    often: dict[int, list[str]] = {}
    for (name, count), named in users.items():
        if len(named) > 1:
            often.setdefault(count, []).append(name)
    close = {count: Close(sorted(names), _LEAST) for count, names in often.items()}
    told = set()
    for thing in run.result(INDEX).of(nodes.Thing):
        name, count = _sort(thing)
        if len(users[name, count]) == 1 and count in close:
            other = close[count].to(name)
            if other is not None:
                told.add(id(thing.node))
                run.report(_close(run, thing.node, other))
    return told


def _close(run: Pass, thing: nodes.Thing, other: str) -> Diagnostic:
    return Diagnostic(
        rule=MISSPELT.name,
        message=f"nothing else uses or claims `{format_formula(thing)}`",
        span=thing.span,
        help=f"did you mean `{other}`?",
        fix=renaming(run.library.files, thing.name, other, [thing.span]),
    )


def _offers(run: Pass) -> Iterable[nodes.DeclarePrimitive | nodes.DeclareSkill]:
    """Return what may use things."""
    return (*run.library.primitives.values(), *run.library.skills.values())


def _sort(thing: Occurrence[nodes.Thing]) -> _Sort:
    return thing.node.name, len(thing.node.args)


def _finding(
    run: Pass, thing: nodes.Thing, near: Suggestions, users: Mapping[_Sort, object]
) -> Diagnostic:
    written = format_formula(thing)
    others = sorted(count for name, count in users if name == thing.name)
    others.remove(len(thing.args))
    help_, meant = near.did_you_mean(thing.name), near.near(thing.name)
    if others:
        meant = None
        amount = plural(others[0], "argument") if others[0] else "no arguments"
        help_ = f"`{thing.name}` is named with {amount} elsewhere"
    return Diagnostic(
        rule=UNUSED.name,
        message=f"nothing else uses or claims `{written}`",
        span=thing.span,
        help=help_,
        fix=renaming(run.library.files, thing.name, meant, [thing.span]),
    )


ANALYZER = Analyzer(
    name="unused-claim",
    doc="Finds things that nothing else uses or claims, and names of things misspelt.",
    run=_run,
    needs=(INDEX,),
    rules=(UNUSED, MISSPELT),
)
