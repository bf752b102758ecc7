"""RAP081 to RAP083: kinds without a declaration, and values of a wrong kind.

A constant is compared with the kind of its argument. A variable is compared with its
declared kind, or with the kind of its other uses in the method. The kind of an input
without a declared kind is inferred from its uses. `not-a-number` covers numbers.

RAP069: a constant that is not a number where a number is needed, or division by zero.

The check covers only the text; the values of variables are known only in a run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index, NameUse, Occurrence
from rapc.analysis.facts.kinds import INFERRED, KindClash, Learned
from rapc.analysis.facts.names import UnknownNames, declared_at, renaming
from rapc.base.diagnostics import Diagnostic, Fix, Label, Rule, Severity, Subject
from rapc.base.names import Suggestions
from rapc.base.source import Span
from rapc.base.values import format_atom, is_number
from rapc.ir import nodes
from rapc.language.heads import CALLS
from rapc.library.kinds import said_of
from rapc.library.signature import Signature
from rapc.library.signatures import Fault

UNKNOWN = Rule(
    code="RAP081",
    name="unknown-kind",
    severity=Severity.ERROR,
    summary="unknown kind, or a kind that is its own parent",
    fix="unsafe: writes the similar name, if there is one",
    source="L 7",
)

WRONG = Rule(
    code="RAP082",
    name="wrong-kind",
    severity=Severity.ERROR,
    summary="a constant does not have the kind of its argument",
    fix="unsafe: writes the similar value of the kind",
    source="L 7",
)

APART = Rule(
    code="RAP083",
    name="kinds-apart",
    severity=Severity.WARNING,
    summary="a variable of one kind is used as another kind",
    ignore="where a value has both kinds: declare the kind with `:is`",
    source="L 7",
)


@check(UNKNOWN, WRONG, APART)
def kinds(run: Pass) -> Iterator[Diagnostic]:
    """Compare constants and variables with the declared kinds."""
    index = run.result(INDEX)
    if not index.kinds():
        return
    yield from _unknown(run, index)
    yield from _circles(run)
    declared = _of_forms(index)
    for used in index.uses():
        signature = run.signatures.table(used.use).get(used.name)
        if signature is not None and signature.args:
            erased = used.use == "erased"
            if signature.miscount(used.count, erased=erased):
                continue
            if not erased and signature.is_property and used.count != signature.most:
                continue
            yield from _constants(run, used, signature)
            own = declared.get(id(used.owner))
            if own:
                yield from _variables(run, used, signature, own)
    yield from _defaults(run)
    yield from _inferred(run, index)


def _unknown(run: Pass, index: Index) -> Iterator[Diagnostic]:
    kinds = run.signatures.kinds
    unknown = UnknownNames(UNKNOWN)
    near = Suggestions(kinds)
    for named in index.kinds():
        name = named.kind
        if name not in kinds:
            advice = "declare it with `declare-kind`, or `require` its file"
            fault = Fault(
                "unknown",
                f"unknown kind `{name}`",
                near.did_you_mean(name, advice),
                name=name,
                meant=near.near(name),
            )
            unknown.add(fault, named.span, named.owner)
    yield from unknown.findings(run)


def _circles(run: Pass) -> Iterator[Diagnostic]:
    reported: set[str] = set()
    for form in run.library.kinds.values():
        above = run.signatures.kinds.above(form.name)
        if form.name in above and form.name not in reported:
            reported.update(above)
            through = [f"`{name}`" for name in above if name != form.name]
            said = f", through {', '.join(through)}" if through else ""
            yield UNKNOWN.at(form.span, f"kind `{form.name}` is its own parent{said}")


def _constants(run: Pass, used: NameUse, signature: Signature) -> Iterator[Diagnostic]:
    kinds = run.signatures.kinds
    for term, arg in zip(used.node.args, signature.args or (), strict=False):
        kind = arg.kind
        if kind is None or kind == "number" or not isinstance(term, nodes.Const):
            continue
        if not kinds.holds(kind, term.value):
            word = format_atom(term.value)
            label = Label(declared_at(run, signature), "declared here")
            yield WRONG.at(
                term.span,
                said_of(arg, term.value),
                labels=(label,),
                help=_listed(run, kind).did_you_mean(word) or _listing(run, kind),
                fix=_another(run, kind, term),
                about=(Subject(term.span, f"?{term.value}"),),
            )


def _defaults(run: Pass) -> Iterator[Diagnostic]:
    """Yield defaults that are not values of the kind of their property."""
    kinds = run.signatures.kinds
    for form in run.library.properties.values():
        kind = form.args[-1].kind if form.args else None
        if kind is None or form.default in run.library.functions:
            continue
        if not kinds.holds(kind, form.default):
            place = form.args[-1].span if form.args else form.span
            yield WRONG.at(
                place,
                f"default `{form.default}` is not of kind {kind}",
                help=_listing(run, kind)
                or "write `unknown`, which is valid for every kind",
            )


def _listed(run: Pass, kind: str) -> Suggestions:
    values = run.signatures.kinds.values(kind) or ()
    return Suggestions(format_atom(value) for value in values)


def _another(run: Pass, kind: str, term: nodes.Const) -> Fix | None:
    """Return the fix that writes a similar value of a kind."""
    word = format_atom(term.value)
    meant = _listed(run, kind).near(word)
    return renaming(run.library.files, word, meant, [term.span])


def _listing(run: Pass, kind: str) -> str:
    values = run.signatures.kinds.values(kind) or ()
    words = list(dict.fromkeys(format_atom(value) for value in values))
    shown = ", ".join(f"`{word}`" for word in words[:_SHOWN])
    return f"the values are {shown}{', ...' if len(words) > _SHOWN else ''}" * bool(
        words
    )


_SHOWN = 8
"""The maximum number of values of a kind to list."""

_Own = Mapping[str, tuple[str, Span]]
"""The kinds of the variables of a form, with the places that imply the kinds."""


def _of_forms(index: Index) -> Mapping[int, _Own]:
    """Return the variables declared with a kind in each form that has a body."""
    found: dict[int, dict[str, tuple[str, Span]]] = {}
    for said in index.of(nodes.VariableKind):
        own = found.setdefault(id(said.owner), {})
        own[said.node.variable] = (said.node.kind, said.node.span)
    bodies = (nodes.DefineQuery, nodes.DeclarePrimitive, nodes.DeclareDatum)
    for argument in index.of(nodes.Argument):
        arg = argument.node
        if arg.kind is not None and isinstance(argument.owner, bodies):
            own = found.setdefault(id(argument.owner), {})
            own[arg.variable.name] = (arg.kind, arg.span)
    return found


def _variables(
    run: Pass, used: NameUse, signature: Signature, own: _Own
) -> Iterator[Diagnostic]:
    """Yield a finding about the first variable of a different kind."""
    args: Sequence[nodes.Argument] = signature.args or ()
    for term, arg in zip(used.node.args, args, strict=False):
        if arg.kind is None or not isinstance(term, nodes.Var):
            continue
        kind, place = own.get(term.name, (arg.kind, term.span))
        if run.signatures.kinds.apart(kind, arg.kind):
            labels = (
                Label(place, "declared here"),
                Label(
                    declared_at(run, signature),
                    f"`{arg.variable.name}` is declared here",
                ),
            )
            yield APART.at(term.span, _mixed_up(term, kind, arg.kind), labels=labels)
            return


def _mixed_up(variable: nodes.Var, kind: str, wanted: str) -> str:
    return f"expected {_a(wanted)}, not `{variable.name}`, which is {_a(kind)}"


def _a(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


# --- inferred kinds -------------------------------------------------------------------


def _inferred(run: Pass, index: Index) -> Iterator[Diagnostic]:
    inferred = run.result(INFERRED)
    told: set[int] = set()
    for clash in inferred.clashes:
        if id(clash.use) not in told:
            told.add(id(clash.use))
            yield _clash(clash)
    for goal in index.of(nodes.Goal):
        learned = inferred.inputs.get(goal.node.name, ())
        for term, known in zip(goal.node.args, learned, strict=False):
            if known is None or not isinstance(term, nodes.Const):
                continue
            if not run.signatures.kinds.holds(known.kind, term.value):
                yield _no_such_value(run, term, known)


def _clash(clash: KindClash) -> Diagnostic:
    known = clash.known
    return APART.at(
        clash.variable.span,
        _mixed_up(clash.variable, known.kind, clash.wanted),
        labels=(Label(known.span, f"{_a(known.kind)} here"),),
    )


def _no_such_value(run: Pass, term: nodes.Const, known: Learned) -> Diagnostic:
    word = format_atom(term.value)
    return WRONG.at(
        term.span,
        f"expected {_a(known.kind)}, not `{word}`",
        labels=(Label(known.span, f"used as {_a(known.kind)} here"),),
        help=_listed(run, known.kind).did_you_mean(word) or _listing(run, known.kind),
        fix=_another(run, known.kind, term),
        about=(Subject(term.span, f"?{term.value}"),),
    )


NOT_A_NUMBER = Rule(
    code="RAP069",
    name="not-a-number",
    severity=Severity.ERROR,
    summary="a constant is not a number where a number is required, or the "
    "divisor is zero",
    source="T 4.1",
)

ARITHMETIC = ("+", "-", "*", "/")

Found = Iterator[tuple[nodes.Term, str]]
"""Invalid terms, each with the end of the sentence that gives the reason."""


@check(NOT_A_NUMBER)
def not_a_number(run: Pass) -> Iterator[Diagnostic]:
    """Find constants that are not numbers where numbers are needed."""
    index = run.result(INDEX)
    for found in (
        _computed(index),
        _compared(index),
        _times(index),
        _declared(run, index),
    ):
        for term, why in found:
            yield NOT_A_NUMBER.at(term.span, f"{_word(term)} {why}")


def _word(term: nodes.Term) -> str:
    return f"`{format_atom(term.value)}`" if isinstance(term, nodes.Const) else "this"


def _is_other(term: nodes.Term | None) -> bool:
    """Return whether a term is a constant other than a number."""
    return type(term) is nodes.Const and not is_number(term.value)


def _computed(index: Index) -> Found:
    for use in index.of(nodes.Call):
        if use.node.function in ARITHMETIC:
            for arg in use.node.args:
                if _is_other(arg):
                    yield arg, "is not a number"
        if use.node.function == "/":
            for arg in use.node.args[1:]:
                if isinstance(arg, nodes.Const) and arg.value == 0:
                    yield arg, "is not a valid divisor"


def _compared(index: Index) -> Found:
    for use in index.of(nodes.Compare):
        sides = (use.node.left, use.node.right)
        if use.node.op in ("=", "n="):
            for one, other in (sides, sides[::-1]):
                computed = type(one) is nodes.Call and one.function in CALLS
                if computed and _is_other(other):
                    yield other, "is not a number and never equals the other side"
        else:
            for side in sides:
                if _is_other(side):
                    yield (
                        side,
                        f"is not a number, and `{use.node.op}` is never true for it",
                    )


def _times(index: Index) -> Found:
    for believe in index.of(nodes.Believe):
        yield from _must_be_numbers("is not an age", believe.node.age)
    for window in index.of(nodes.Window):
        yield from _must_be_numbers(
            "is not a time", window.node.start, window.node.stop
        )
    for delay in index.of(nodes.MonitorTime):
        yield from _must_be_numbers("is not a time", delay.node.start, delay.node.stop)
    for rap in index.of(nodes.DefineRap):
        yield from _must_be_numbers("is not a time", rap.node.duration)
    for effect in index.of(nodes.ResourceChange):
        if effect.node.op.startswith("counter") and not _is_set(effect):
            yield from _must_be_numbers("is not an amount", effect.node.amount)
    for resource in index.of(nodes.Resource):
        if resource.node.kind == "counter":
            yield from _must_be_numbers("is not a number", resource.node.initial)


def _is_set(effect: Occurrence[nodes.ResourceChange]) -> bool:
    """Return whether a set is changed like a counter; another check reports this."""
    rap, term = effect.owner, effect.node.resource
    resources = rap.resources if isinstance(rap, nodes.DefineRap) else ()
    return any(one.kind == "set" and one.variable == term for one in resources)


def _must_be_numbers(why: str, *terms: nodes.Term | None) -> Found:
    for term in terms:
        if term is not None and _is_other(term):
            yield term, why


def _declared(run: Pass, index: Index) -> Found:
    """Yield arguments that are declared to be numbers."""
    if not any(named.kind == "number" for named in index.kinds()):
        return
    for used in index.uses():
        declared = run.signatures.table(used.use).get(used.name)
        args = declared.args if declared is not None else None
        for term, arg in zip(used.node.args, args or (), strict=False):
            if arg.kind == "number" and _is_other(term) and not _unknown_numbers(term):
                yield term, f"is not a number, as declared for `{arg.variable.name}`"


def _unknown_numbers(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Const) and term.value == "unknown"
