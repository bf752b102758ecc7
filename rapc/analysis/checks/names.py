"""Names without a declaration, and names that do not match their declaration.

The signature table (`rapc.library.signatures`) compares a name with its declaration;
the fact `MISUSES` has each use that does not match. The checks import no world.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from typing import NamedTuple, get_args

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, USES, Form, Index, NameUse
from rapc.analysis.facts.names import (
    Misuse,
    UnknownNames,
    declared_at,
    misuses,
    renaming,
)
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.analysis.facts.usage import CENSUS, TRUTH, Place
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
    Subject,
)
from rapc.base.names import Suggestions
from rapc.base.source import Span
from rapc.base.values import format_atom, format_list
from rapc.ir import nodes
from rapc.ir.walk import variables
from rapc.library.library import word_span
from rapc.library.signature import Signature
from rapc.library.signatures import Fault, Use

UNKNOWN_RAP = Rule(
    code="RAP013",
    name="unknown-rap",
    severity=Severity.ERROR,
    summary="a step, a method, a rule or a test uses an unknown RAP",
    fix="unsafe: writes the similar name, if there is one",
    ignore="where a host program or a problem solver adds the RAP in the run",
    source="T 3.1.4",
)

WRONG_STEP_ARITY = Rule(
    code="RAP014",
    name="wrong-step-arity",
    severity=Severity.ERROR,
    summary="a RAP has a different number of inputs or outputs than its index",
    source="T 4.2",
)


UNDECLARED_PREDICATE = Rule(
    code="RAP015",
    name="undeclared-predicate",
    severity=Severity.ERROR,
    summary="unknown fact, property or test",
    fix="unsafe: writes the similar name, if there is one",
    source="T A.1",
)

NOT_A_FACT = Rule(
    code="RAP073",
    name="not-a-fact",
    severity=Severity.ERROR,
    summary="a function or a query is asserted, noted or believed like a fact",
    source="T A.1",
)

UNDECLARED_FUNCTION = Rule(
    code="RAP018",
    name="undeclared-function",
    severity=Severity.ERROR,
    summary="unknown function in a term",
    fix="unsafe: writes the similar name, if there is one",
    source="T A.1",
)

WRONG_FUNCTION_ARITY = Rule(
    code="RAP019",
    name="wrong-function-arity",
    severity=Severity.ERROR,
    summary="a function has a different number of arguments than its declaration",
    source="T A.1",
)


UNDECLARED_PRIMITIVE = Rule(
    code="RAP020",
    name="undeclared-primitive",
    severity=Severity.ERROR,
    summary="a method or a test uses an unknown primitive",
    fix="unsafe: writes the similar name, if there is one",
    source="T 4.5.3",
)

WRONG_PRIMITIVE_ARITY = Rule(
    code="RAP021",
    name="wrong-primitive-arity",
    severity=Severity.ERROR,
    summary="a request has a different number of arguments than its primitive",
    source="T 4.5.3",
)


UNDECLARED_SIGNAL = Rule(
    code="RAP023",
    name="undeclared-signal",
    severity=Severity.ERROR,
    summary="unknown skill or event",
    fix="unsafe: writes the similar name, if there is one",
    source="S 2",
)

WRONG_SIGNAL_ARITY = Rule(
    code="RAP024",
    name="wrong-signal-arity",
    severity=Severity.ERROR,
    summary="a skill or an event has a different number of arguments than "
    "its declaration",
    source="S 2",
)


UNDECLARED_DATUM = Rule(
    code="RAP075",
    name="undeclared-datum",
    severity=Severity.ERROR,
    summary="a test or a primitive sends an unknown sensor datum",
    fix="unsafe: writes the similar name, if there is one",
    source="T 3.3.1",
)

WRONG_DATUM_ARITY = Rule(
    code="RAP076",
    name="wrong-datum-arity",
    severity=Severity.ERROR,
    summary="a sensor datum has a different number of arguments than its declaration",
    source="T 3.3.1",
)


WRONG_FACT_ARITY = Rule(
    code="RAP016",
    name="wrong-fact-arity",
    severity=Severity.ERROR,
    summary="a fact or test has a different number of arguments than its declaration",
    source="T A.1",
)

_FACTS: tuple[Use, ...] = ("test", "believed", "asserted", "erased")
_ALL_USES: tuple[Use, ...] = get_args(Use)


class _Space(NamedTuple):
    """The names of one name space, and the rules about the names."""

    uses: tuple[Use, ...]
    undeclared: Rule
    #: A different number of arguments than declared; steps have a separate check.
    arity: Rule | None = None
    #: A name that is declared as something different.
    kind: Rule | None = None


_SPACES = (
    _Space(("goal",), UNKNOWN_RAP),
    _Space(_FACTS, UNDECLARED_PREDICATE, WRONG_FACT_ARITY, NOT_A_FACT),
    _Space(
        ("computed",), UNDECLARED_FUNCTION, WRONG_FUNCTION_ARITY, UNDECLARED_FUNCTION
    ),
    _Space(("primitive",), UNDECLARED_PRIMITIVE, WRONG_PRIMITIVE_ARITY),
    _Space(("skill", "event"), UNDECLARED_SIGNAL, WRONG_SIGNAL_ARITY),
    _Space(("datum",), UNDECLARED_DATUM, WRONG_DATUM_ARITY),
)


@check(
    *dict.fromkeys(rule for space in _SPACES for rule in space[1:] if rule is not None),
    WRONG_STEP_ARITY,
)
def undeclared_or_misused_names(run: Pass) -> Iterator[Diagnostic]:
    """Find names that are not declared, or that do not match their declaration."""
    index = run.result(INDEX)
    further = list(_named_apart(run, index))
    for space in _SPACES:
        unknown = UnknownNames(space.undeclared)
        for one in misuses(run, space.uses, "unknown"):
            used = one.used
            place = used.place(run.library.files)
            unknown.add(one.fault, place, used.owner, _meant_to_bind(index, used))
        for use, name, place, owner in further:
            if use in space.uses and name not in run.signatures.table(use):
                unknown.add(run.signatures.unknown(use, name), place, owner)
        yield from unknown.findings(run)
        if space.arity is not None:
            yield from _wrong_arity(run, space.arity, space.uses)
        for one in misuses(run, space.uses, "kind"):
            assert space.kind is not None
            yield _declared_otherwise(run, space.kind, one)
    for one in misuses(run, ("goal",), "arguments"):
        yield _misfit(run, one)


def _named_apart(run: Pass, index: Index) -> Iterator[tuple[Use, str, Span, Form]]:
    """Yield the names that occur only in declarations and tests."""
    for chosen in index.of(nodes.MethodChosen):
        place = word_span(run.library.files, chosen.node.span, 1)
        yield "goal", chosen.node.rap, place, chosen.owner
    for form in run.library.methods:
        yield "goal", form.rap, form.name_span, form
    for row in index.of(nodes.ComparatorRow):
        yield "test", row.node.property, row.node.span, row.owner
    for function in index.of(nodes.DeclareFunction):
        for name in function.node.reads or ():
            yield "test", name, function.node.span, function.owner
    for skill in index.of(nodes.DeclareSkill):
        for name in skill.node.events or ():
            yield "event", name, skill.node.span, skill.owner
    for primitive in index.of(nodes.DeclarePrimitive):
        for name in primitive.node.tells:
            yield "datum", name, primitive.node.span, primitive.owner


def _wrong_arity(run: Pass, rule: Rule, uses: Container[Use]) -> Iterator[Diagnostic]:
    """Yield the uses with a different number of arguments than declared."""
    faults: dict[tuple[str, str], list[Misuse]] = {}
    for one in misuses(run, uses, "arguments"):
        faults.setdefault((one.used.name, one.fault.message), []).append(one)
    for (name, _), wrong in faults.items():
        number = run.result(USES)
        every = sum(number[use, name] for use in _ALL_USES if use in uses)
        alike = every == len(wrong) >= THRESHOLDS.all_misused
        for one in wrong[:1] if alike else wrong:
            declared = one.fault.declared
            assert declared is not None
            label = Label(
                declared_at(run, declared), f"declared here as `{declared.written}`"
            )
            note = f"all {every} uses have this number; the declaration may be wrong"
            yield rule.at(
                one.used.span,
                one.fault.message,
                labels=(label,),
                notes=(note,) if alike else (),
                about=_left_out(wrong if alike else [one]),
            )


def _left_out(wrong: Iterable[Misuse]) -> tuple[Subject, ...]:
    """Return a subject for each test that lacks one argument, a variable to bind."""
    return tuple(
        Subject(one.used.span)
        for one in wrong
        if one.used.use == "test"
        and one.fault.declared is not None
        and not one.fault.declared.is_property
        and one.used.count + 1 == one.fault.declared.most
    )


def _declared_otherwise(run: Pass, rule: Rule, one: Misuse) -> Diagnostic:
    """Return the finding about a name with a different kind of declaration."""
    declared, used = one.fault.declared, one.used
    assert declared is not None
    place = used.span if used.use == "computed" else used.place(run.library.files)
    return rule.at(
        place,
        one.fault.message,
        labels=(Label(declared_at(run, declared), "declared here"),),
        help=one.fault.help,
        about=tuple(_meant_to_bind(run.result(INDEX), used)),
    )


def _meant_to_bind(index: Index, used: NameUse) -> Iterator[Subject]:
    """Yield the variables that a fact in place of a computed value should bind."""
    if used.use == "computed":
        here = index.at(used.span.file, used.span.start)
        compared = here is not None and isinstance(here.parent, nodes.Compare)
        place = here.parent if here is not None and compared else used.node
        for variable in variables(place):
            yield Subject(place.span, variable.name)


def _misfit(run: Pass, one: Misuse) -> Diagnostic:
    used, rap = one.used, run.library.raps[one.used.name]
    arrow = ["=>", *(v.name for v in rap.outputs)] if rap.outputs else []
    index = format_list([rap.name, *(v.name for v in rap.inputs), *arrow])
    lacks_outputs = used.outputs == 0 and rap.outputs
    return WRONG_STEP_ARITY.at(
        used.span,
        one.fault.message,
        labels=(Label(rap.name_span, f"the index is `{index}`"),),
        help="write `?` after `=>` for an unused output" if lacks_outputs else "",
        about=tuple(_not_handed_out(used, len(rap.outputs))) if lacks_outputs else (),
    )


def _not_handed_out(used: NameUse, outputs: int) -> Iterator[Subject]:
    """Yield the variables that may be outputs of a step, and one for each output."""
    for variable in variables(*used.node.args):
        yield Subject(used.span, variable.name)
    yield from [Subject(used.span)] * outputs


UNKNOWN_AGENDA = Rule(
    code="RAP080",
    name="unknown-agenda",
    severity=Severity.ERROR,
    summary="a test uses an unknown agenda",
    source="T 5.4",
)


@check(UNKNOWN_AGENDA)
def unknown_agenda(run: Pass) -> Iterator[Diagnostic]:
    """Find tests that name an agenda without a definition."""
    known = run.library.agendas
    unknown = UnknownNames(UNKNOWN_AGENDA)
    near = Suggestions(known)
    for test in run.library.tests:
        name = test.agenda
        if name is not None and name not in known:
            advice = "define it with `define-agenda`, or `require` its file"
            help = near.did_you_mean(name, advice)
            message, meant = f"unknown agenda `{name}`", near.near(name)
            fault = Fault("unknown", message, help, name=name, meant=meant)
            place = word_span(run.library.files, test.span, 1)
            unknown.add(fault, place, test)
    yield from unknown.findings(run)


UNKNOWN_METHOD = Rule(
    code="RAP067",
    name="unknown-method",
    severity=Severity.ERROR,
    summary="a query or a test names an unknown method of a RAP",
    fix="unsafe: writes the similar name, if there is one",
    source="T 4.1.2",
)


def _methods(rap: nodes.DefineRap) -> Suggestions:
    return Suggestions(format_atom(m.name) for m in rap.methods if m.name is not None)


def _names_in_traces(rap: nodes.DefineRap) -> Suggestions:
    return Suggestions(
        f"#{method.position}" if method.name is None else format_atom(method.name)
        for method in rap.methods
    )


@check(UNKNOWN_METHOD, needs_whole="form")
def unknown_method(run: Pass) -> Iterator[Diagnostic]:
    """Find conditions about methods that the RAP does not have."""
    index = run.result(INDEX)
    known: dict[int, Suggestions] = {}
    for found in index.of(nodes.HistoryTest):
        rap, history = found.owner, found.node
        if history.query == "last-result" or not isinstance(rap, nodes.DefineRap):
            continue
        asked = history.args[0]
        if isinstance(asked, nodes.Const) and rap.methods and rap.plan is None:
            if id(rap) not in known:
                known[id(rap)] = _methods(rap)
            word = format_atom(asked.value)
            yield from _unknown_method(run, rap, word, asked.span, known[id(rap)])
    traced: dict[int, Suggestions] = {}
    for chosen in index.of(nodes.MethodChosen):
        named, test = run.library.raps.get(chosen.node.rap), chosen.owner
        # A world may have a solver, with methods that are not known in advance, as the
        # planner.
        if named is None or named.plan is not None:
            continue
        if isinstance(test, nodes.DefineTest) and not test.world:
            if id(named) not in traced:
                traced[id(named)] = _names_in_traces(named)
            place = word_span(run.library.files, chosen.node.span, 2)
            yield from _unknown_method(
                run, named, chosen.node.method, place, traced[id(named)]
            )


def _unknown_method(
    run: Pass, rap: nodes.DefineRap, name: str, place: Span, known: Suggestions
) -> Iterator[Diagnostic]:
    """Yield the name of a method if the RAP does not have the method."""
    if name not in known:
        counted = f"#{name}"
        meant = counted if counted in known else known.near(name)
        yield UNKNOWN_METHOD.at(
            place,
            f"unknown method `{name}` of `{rap.name}`",
            help=f"did you mean `{meant}`?" if meant else "",
            fix=renaming(run.library.files, name, meant, [place]),
        )


IMPLIED_TRUE = Rule(
    code="RAP017",
    name="implied-true",
    severity=Severity.INFO,
    summary="a property has no value, which means `true`",
    fix="safe: writes the value `true`",
    ignore="where the library omits the value `true` of all its properties",
    source="T A.1",
)


MISSING_VALUE = Rule(
    code="RAP106",
    name="missing-value",
    severity=Severity.WARNING,
    summary="a property has no value, and its value is never `true`",
    ignore="where a world asserts `true` and the library does not declare so",
    source="T A.1",
)


@check(IMPLIED_TRUE, MISSING_VALUE)
def left_out_values(run: Pass) -> Iterator[Diagnostic]:
    """Find properties without their value."""
    properties = {
        name: signature
        for name, signature in run.signatures.relations.items()
        if signature.is_property and signature.most is not None
    }
    for used in run.result(INDEX).uses():
        declared = properties.get(used.name)
        if declared is None or used.count + 1 != declared.most or not used.count:
            continue
        if used.use in _FACTS and used.use != "erased":
            if _never_true(run, declared):
                yield _missing_value(run, used, declared)
            else:
                yield _implied_value(run, used, declared)


def _never_true(run: Pass, declared: Signature) -> bool:
    """Return whether no form of the library can set a property to `true`."""
    args = declared.args or ()
    kind = args[-1].kind if args else None
    if kind is not None and not run.signatures.kinds.holds(kind, "true"):
        return True
    place = Place("predicate", declared.name, (declared.most or 1) - 1)
    there = run.result(CENSUS).at(place)
    values = {one.written for one in there if one.count == declared.most}
    values.discard("unknown")
    return bool(values) and values.isdisjoint(TRUTH)


def _missing_value(run: Pass, used: NameUse, declared: Signature) -> Diagnostic:
    label = Label(declared_at(run, declared), f"declared here as `{declared.written}`")
    return MISSING_VALUE.at(
        used.span,
        f"`{used.name}` has no value, and `true` is not among its values",
        labels=(label,),
        help="write the value, or a variable for any value",
    )


def _implied_value(run: Pass, used: NameUse, declared: Signature) -> Diagnostic:
    end = used.node.args[-1].span.end
    edit = Edit(Span(used.span.file, end, end), " true")
    label = Label(declared_at(run, declared), f"declared here as `{declared.written}`")
    return IMPLIED_TRUE.at(
        used.span,
        f"`{used.name}` has no value, which means `true`",
        labels=(label,),
        fix=Fix(Applicability.SAFE, "write `true`", (edit,)),
    )
