"""Variables without a value, misspelt variables, and outputs that are never bound.

The fact `BINDINGS` has each variable that needs a value and lacks a value. The checks
add the explanation: the other places that bind the variable and why these bindings are
not available, or the similar variable.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.bindings import SIGNALS, Site, sites, sites_by_name
from rapc.analysis.facts.effects import NeverDone
from rapc.analysis.facts.index import INDEX, Form, Index, VariableAt
from rapc.analysis.facts.logic import is_never
from rapc.analysis.facts.names import renaming
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.analysis.facts.task_nets import TASK_NETS, Net
from rapc.analysis.facts.usage import USAGE
from rapc.analysis.facts.variables import BINDINGS, Missing
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
from rapc.base.names import Close, Suggestions, nearest
from rapc.base.source import SourceFile, Span
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import formulas, given_names, steps, subformulas, substitute
from rapc.library.library import Library

UNBOUND_VARIABLE = Rule(
    code="RAP012",
    name="unbound-variable",
    severity=Severity.ERROR,
    summary="a variable has no value in some order of the steps",
    ignore="never: use a query or a function for values that a host knows",
    fix="unsafe: writes the similar variable",
    source="T 4.2, 4.5.2",
)

_SHOWN = 3
"""The maximum number of places to show after the first use."""

_SEES = {
    "duration": "inputs, resources and variables of preconditions",
    "monitor-time": "inputs and resources",
    "resources": "inputs and the preceding resources",
    "effects": "inputs, outputs, resources and variables of preconditions",
}
"""By clause without bindings of its own, the variables that the clause can use."""

_BIND = {
    "step": "bind the variable in `context`, or in a step ordered before this step",
    "notations": "bind the variable in `context`",
    "primitive": "bind the variable in `context`",
    "claims": "bind the variable in `context`",
    "skills": "bind the variable in `context`",
    ":uses": "use one of the arguments",
    "rule": "bind the variable in the query of the rule",
    "script": "the request of the row binds the variables of the row",
    "memory": "bind the variable in a fact to the left",
}
"""By clause, the place to bind the variables of the clause."""


@check(UNBOUND_VARIABLE, needs_whole="method")
def unbound_variable(run: Pass) -> Iterator[Diagnostic]:
    """Find variables without a value where a value is needed."""
    missing = run.result(BINDINGS).missing
    nets = run.result(TASK_NETS)
    index = run.result(INDEX)
    for form in (*run.library.forms, *run.library.tests):
        lacking = missing.get(id(form), ())
        if lacking:
            places = _Places(form, run.library)
            for first, *further in _by_cause(lacking, places, run.unsure(form.span)):
                net = None if first.method is None else nets.get(id(first.method.body))
                if net is None or not net.is_broken or not _by_steps(first, places):
                    found = _explain(first, further, places, net, index)
                    found = _with_fix(run, found, first, further, places)
                    unused = _unused_input(run, form, first)
                    if unused is not None and found.fix is None:
                        label = Label(unused.span, "this input is never used")
                        found = msgspec.structs.replace(
                            found,
                            labels=(label, *found.labels),
                            help=f"did you mean `{unused.name}`?",
                        )
                    yield found


class _Places:
    """The bindings of the variables of a RAP or rule by name, and the names."""

    def __init__(self, form: Form, library: Library) -> None:
        functions = library.functions
        self.never_done = NeverDone(library.raps)
        self.by_name: Mapping[str, Sequence[Site]] = {}
        self._formulas: Sequence[Span] = ()
        if isinstance(form, nodes.DefineRap):
            self.by_name = sites_by_name(form, functions)
            self._formulas = [one.formula.span for one in formulas(form)]
        self.names = Suggestions(self.by_name)

    def in_one_formula(self, site: Site, missing: Missing) -> bool:
        """Return whether a variable is needed and bound in the same formula."""
        there = site.span, missing.variable.span
        return any(
            all(span.start <= one.start < span.end for one in there)
            for span in self._formulas
        )

    def binds(self, missing: Missing) -> bool:
        """Return whether a binding that the method may use binds a variable."""
        there = self.by_name.get(missing.variable.name, ())
        return any(site.method in (None, missing.method) for site in there)


def _by_cause(
    missing: Iterable[Missing], places: _Places, unsure: bool
) -> Iterator[list[Missing]]:
    """Yield the missing variables, one list for each cause, first use first.

    A variable without any binding has one cause, even if the variable occurs in several
    methods. A syntax error in the form makes the bindings uncertain; then each method
    counts separately.
    """
    causes: dict[tuple[str, int], list[Missing]] = {}
    for one in sorted(missing, key=lambda m: m.variable.span.start):
        name = one.variable.name
        method = id(one.method) if unsure or name in places.by_name else 0
        causes.setdefault((name, method), []).append(one)
    yield from causes.values()


def _by_steps(missing: Missing, places: _Places) -> bool:
    """Return whether steps of the method bind the variable, in any order."""
    return any(
        site.step is not None and site.method is missing.method
        for site in places.by_name.get(missing.variable.name, ())
    )


def _explain(
    first: Missing,
    further: Sequence[Missing],
    places: _Places,
    net: Net | None,
    index: Index,
) -> Diagnostic:
    name = first.variable.name
    used = {m.variable.span for m in (first, *further)}
    elsewhere = [s for s in places.by_name.get(name, ()) if s.span not in used][:_SHOWN]
    labels = [Label(s.span, _why_not(s, first, net, places)) for s in elsewhere]
    help_ = _advice(elsewhere, first, net, places)
    near = None if elsewhere else places.names.near(name)
    if near is not None:
        site = places.by_name[near][0]
        labels = [Label(site.span, _close_name(site))]
        help_ = f"did you mean `{near}`?"
    labels += [
        Label(m.variable.span, "not bound here, either") for m in further[:_SHOWN]
    ]
    if not elsewhere and near is None and _equal_to(first, index) is not None:
        help_ = f"`=` binds nothing; `(is {name} ...)` binds the variable to the value"
    lack = () if places.binds(first) else (Subject(first.variable.span),)
    return UNBOUND_VARIABLE.at(
        first.variable.span,
        f"`{name}` is not bound here",
        labels=tuple(labels),
        help=help_,
        about=(Subject(first.variable.span, name), *lack),
    )


def _equal_to(missing: Missing, index: Index) -> nodes.Compare | None:
    """Return the `=` of which a variable is one side, and a computed term the other."""
    span = missing.variable.span
    here = index.at(span.file, span.start)
    test = here.parent if here is not None else None
    if not isinstance(test, nodes.Compare) or test.op != "=":
        return None
    other = test.right if test.left is missing.variable else test.left
    return test if isinstance(other, nodes.Call) else None


def _with_fix(
    run: Pass,
    found: Diagnostic,
    first: Missing,
    further: Sequence[Missing],
    places: _Places,
) -> Diagnostic:
    """Return a finding with the fix that writes the similar variable, or `is`."""
    name = first.variable.name
    if name in places.by_name:
        return found
    spans = [missing.variable.span for missing in (first, *further)]
    near = places.names.near(name)
    test = None if near else _equal_to(first, run.result(INDEX))
    if test is None:
        fix = renaming(run.library.files, name, near, spans)
    else:
        fix = _bind_with_is(test, first, run.library.files[test.span.file])
    return msgspec.structs.replace(found, fix=fix)


def _bind_with_is(test: nodes.Compare, missing: Missing, source: SourceFile) -> Fix:
    """Return the fix that makes a test with `=` bind the variable with `is`."""
    word = source.text.index("=", test.span.start)
    edits = [Edit(Span(test.span.file, word, word + 1), "is")]
    if test.right is missing.variable:
        left, right = test.left.span, test.right.span
        edits.append(Edit(left, missing.variable.name))
        edits.append(Edit(right, source.text[left.start : left.end]))
    return Fix(Applicability.UNSAFE, "write `is`", tuple(edits))


def _close_name(site: Site) -> str:
    if site.clause in ("input", "resource"):
        return f"{site.what} with a similar name is declared here"
    return "a similar variable is bound here"


def _why_not(site: Site, missing: Missing, net: Net | None, places: _Places) -> str:
    """Return why a binding of the variable is not available at the use."""
    if site.negated:
        return "bound only inside `not`, which exports no bindings"
    if site.method is not None and missing.method is None:
        return f"bound here in a method; `{missing.clause}` does not see this binding"
    if site.method is not None and site.method is not missing.method:
        return "bound here, in another method"
    return _out_of_order(site, missing, net) or _out_of_sight(site, missing, places)


def _out_of_order(site: Site, missing: Missing, net: Net | None) -> str | None:
    """Return the explanation by the order of steps, or None."""
    one, other = site.step, missing.step
    if one is None:
        return None
    if other is None or net is None:
        return "bound here, but only after the method has begun"
    by = site.what
    if site.clause in SIGNALS.values():
        by = f"{site.clause} {by}"
        if one == other or site.clause == SIGNALS["fail"]:
            return f"bound by {by}"
        if one not in net.by_until and net.has_ended(one, other):
            return f"bound by {by}, but the step may end without it"
    elif one == other or (one not in net.early and net.has_ended(one, other)):
        return None
    return f"bound by {by}, {_order_in_words(one, other, net)}"


def _order_in_words(one: int, other: int, net: Net) -> str:
    """Return why a step has not surely finished when another step begins."""
    if one in net.by_until:
        return "which may be ended before"
    if net.is_before(other, one):
        return "which runs after this step"
    if not net.is_before(one, other):
        return "which is not ordered before this step"
    if one in net.early:
        return "which a signal may end before"
    return "but a step between them may be ended before"


def _out_of_sight(site: Site, missing: Missing, places: _Places) -> str:
    if site.branch:
        return "bound here, but only in one branch of an `or`"
    if missing.method is None and site.clause not in (missing.clause, "resource"):
        return f"bound here, but `{missing.clause}` does not see this binding"
    if site.clause in ("monitor-state", "succeed", "preconditions", "constraints"):
        return f"bound here, but {site.what} exports no bindings"
    if places.in_one_formula(site, missing):
        return (
            "bound here, but evaluated after the use: parts are evaluated "
            "from left to right"
        )
    return "bound here, but only after the use"


def _advice(
    elsewhere: Sequence[Site], missing: Missing, net: Net | None, places: _Places
) -> str:
    if missing.clause in _SEES:
        return f"`{missing.clause}` sees only {_SEES[missing.clause]}"
    for site in elsewhere:
        if site.method is missing.method:
            found = _about_site(site, missing, net, places)
            if found:
                return found
    if missing.clause in _BIND:
        return _BIND[missing.clause]
    return "bind the variable in a fact to the left, or make the variable an input"


def _about_site(
    site: Site, missing: Missing, net: Net | None, places: _Places
) -> str | None:
    """Return the advice about a place of the method that binds a variable, or None."""
    if site.branch and not site.negated:
        return "bind the variable in every branch of the `or`"
    if not site.negated and places.in_one_formula(site, missing):
        return "move the part that binds the variable to the left"
    if _may_precede(site, missing, net):
        assert missing.method is not None
        tag = steps(missing.method)[missing.step or 0].tag
        return f"order the steps: add `(for {tag})` to {site.what}"
    if site.clause == SIGNALS["succeed"] and net is not None:
        return _by_signal(site, missing, net, places)
    return None


def _by_signal(site: Site, missing: Missing, net: Net, places: _Places) -> str:
    """Return how a step that a signal may end would surely bind a variable."""
    one, other, method = site.step, missing.step, site.method
    if one == other:
        return "with `:proceed`, the signal comes before the step begins"
    assert method is not None
    assert one is not None
    step, name = steps(method)[one], missing.variable.name
    needed = []
    if other is not None and not net.is_before(one, other):
        needed.append(f"add `(for {steps(method)[other].tag})` to {site.what}")
    ending = [
        {term.name for term in note.args if isinstance(term, nodes.Var)}
        for note in step.annotations
        if isinstance(note, nodes.WaitFor) and note.mode == "succeed"
    ]
    if any(name not in bound for bound in ending):
        needed.append(f"bind `{name}` in each signal that ends {site.what}")
    if step.goal.name not in places.never_done:
        needed.append(
            f"end `{step.goal.name}` only by a signal, as with `(succeed "
            f"nil)`, or return `{name}` as an output"
        )
    return ", and ".join(needed)


def _may_precede(site: Site, missing: Missing, net: Net | None) -> bool:
    """Return whether a step that binds the variable could be ordered before the use."""
    one, other = site.step, missing.step
    if one is None or other is None or net is None or one == other:
        return False
    if site.clause in SIGNALS.values() or net.has_ended(one, other):
        return False
    return one not in net.early and not net.is_before(other, one)


ANONYMOUS_VARIABLE = Rule(
    code="RAP063",
    name="anonymous-variable",
    severity=Severity.ERROR,
    summary="a bare `?` is used where a value is required",
    source="T 4.1",
)


@check(ANONYMOUS_VARIABLE)
def anonymous_variable(run: Pass) -> Iterator[Diagnostic]:
    """Find a bare `?` where a value is needed."""
    for variable in run.result(BINDINGS).anonymous:
        yield ANONYMOUS_VARIABLE.at(
            variable.span,
            "`?` has no value",
            help="name the variable and bind it before; `?` only matches values "
            "in queries and patterns",
        )


MISSPELT_VARIABLE = Rule(
    code="RAP029",
    name="misspelt-variable",
    severity=Severity.WARNING,
    summary="a variable is used once, and a similar variable exists",
    fix="unsafe: writes the similar variable",
    ignore="where both names are meant: choose a name that is less similar",
    source="T 4.1",
)


@check(MISSPELT_VARIABLE, needs_whole="form")
def misspelt_variable(run: Pass) -> Iterator[Diagnostic]:
    """Find variables used once with a name close to the name of another variable."""
    for owner, named in run.result(INDEX).variables():
        if not isinstance(owner, nodes.DefineRap | nodes.DefineQuery):
            continue
        names = named
        if "?" in named:
            names = {name: uses for name, uses in named.items() if name != "?"}
        once = [name for name, uses in names.items() if len(uses) == 1]
        suspects = _suspects(once, names)
        close = Close(names, THRESHOLDS.close_variable) if suspects else None
        for name in suspects:
            other = close.to(name) if close else None
            if other is not None and _is_slip(names[name][0][0], names[other]):
                yield _misspelt(run, names[name][0][0], names[other][0][0])


def _suspects(once: Iterable[str], names: Iterable[str]) -> list[str]:
    """Return the names used once that may be misspelt: a similar length is needed."""
    lengths: dict[int, int] = {}
    for name in names:
        lengths[len(name)] = lengths.get(len(name), 0) + 1
    return [
        name
        for name in once
        if (len(name) >= THRESHOLDS.close_variable - 1 and len(name) + 1 in lengths)
        or (
            len(name) >= THRESHOLDS.close_variable
            and (lengths[len(name)] > 1 or len(name) - 1 in lengths)
        )
    ]


def _is_slip(one: nodes.Var, others: Sequence[VariableAt]) -> bool:
    """Return whether a variable is misspelt, and not the other variable.

    If both variables occur once, the later variable counts as misspelt. A short name is
    not misspelt if the other name is its plural: `?arm` and `?arms`.
    """
    other = others[0][0]
    if len(one.name) < THRESHOLDS.close_variable and other.name == f"{one.name}s":
        return False
    return len(others) > 1 or other.span.start < one.span.start


def _misspelt(run: Pass, variable: nodes.Var, close: nodes.Var) -> Diagnostic:
    return MISSPELT_VARIABLE.at(
        variable.span,
        f"`{variable.name}` is used only here",
        labels=(Label(close.span, "a similar variable"),),
        help=f"did you mean `{close.name}`? for any value, write `?`",
        fix=renaming(run.library.files, variable.name, close.name, [variable.span]),
        about=(Subject(variable.span, variable.name),),
    )


STRAY_VARIABLE = Rule(
    code="RAP181",
    name="stray-variable",
    severity=Severity.WARNING,
    summary="a variable stands where an unused input of the same kind is expected",
    ignore="where any value is meant: write `?`",
    source="T 4.2",
)


_Named = Mapping[str, Sequence[VariableAt]]
"""The variables of a form by name."""


@check(STRAY_VARIABLE, needs_whole="form")
def stray_variable(run: Pass) -> Iterator[Diagnostic]:
    """Find inputs that are not used where a variable of the same kind is."""
    for rap, named in run.result(INDEX).variables():
        if isinstance(rap, nodes.DefineRap) and rap.inputs:
            yield from _unused_inputs(run, rap, named)
            yield from _used_once(run, rap, named)


def _unused_inputs(
    run: Pass, rap: nodes.DefineRap, named: _Named
) -> Iterator[Diagnostic]:
    """Find inputs without a use, in a RAP with another variable of the same kind."""
    own = given_names(rap).union(output.name for output in rap.outputs)
    for one in _unused(rap, named):
        others = (name for name in named if name != "?" and name not in own)
        name = next((name for name in others if _alike(run, rap, name, one)), None)
        if name is not None:
            where = f"`{rap.name}` never uses this input"
            yield _stray(named[name][0][0], one, where)


def _unused(rap: nodes.DefineRap, named: _Named) -> Iterator[nodes.Var]:
    for one in rap.inputs if rap.methods else ():
        if not one.anonymous and len(named[one.name]) == 1:
            yield one


def _unused_input(run: Pass, form: Form, missing: Missing) -> nodes.Var | None:
    """Return an unused input of the kind of a variable without any binding."""
    if not isinstance(form, nodes.DefineRap) or not form.inputs:
        return None
    name = missing.variable.name
    named = next(n for one, n in run.result(INDEX).variables() if one is form)
    unused = _unused(form, named)
    return next((one for one in unused if _alike(run, form, name, one)), None)


def _used_once(run: Pass, rap: nodes.DefineRap, named: _Named) -> Iterator[Diagnostic]:
    """Find variables used once, in a fact without an input of the same kind.

    A variable in `repeat-while` may only stand for a fact that must change [L 4.48].
    Where `succeed` queries the fact with the input, a variable is a different value.
    """
    goal = rap.succeed
    goals = [format_formula(one) for one in subformulas(goal)] if goal else []
    own = given_names(rap)
    used = [one for one in rap.inputs if len(named[one.name]) > 1]
    for whole in formulas(rap):
        if not used or whole.clause.word == "repeat-while":
            continue
        facts = [f for f in subformulas(whole.formula) if type(f) is nodes.Proposition]
        for fact in facts:
            for at, term in enumerate(fact.args):
                if type(term) is not nodes.Var or term.anonymous or term.name in own:
                    continue
                if len(named[term.name]) != 1:
                    continue
                there = {
                    f.args[at] for f in facts if f.name == fact.name and f.args[at:]
                }
                one = _expected(run, rap, term, [i for i in used if i not in there])
                if one is None or one in fact.args:
                    continue
                if format_formula(substitute(fact, {term.name: one})) not in goals:
                    yield _stray(term, one, f"`{fact.name}` does not use this input")


def _expected(
    run: Pass, rap: nodes.DefineRap, variable: nodes.Var, inputs: Iterable[nodes.Var]
) -> nodes.Var | None:
    """Return the first input of the kind of a variable."""
    return next((one for one in inputs if _alike(run, rap, variable.name, one)), None)


def _alike(run: Pass, rap: nodes.DefineRap, name: str, one: nodes.Var) -> bool:
    """Return whether a variable and an input have the same kind.

    Without kinds: whether other forms use one name at both places.
    """
    usage = run.result(USAGE)
    places, others = (list(usage.of(rap, which)) for which in (name, one.name))
    kinds, wanted = set(usage.kinds(places)), set(usage.kinds(others))
    if kinds and wanted and kinds.isdisjoint(wanted):
        return False
    if kinds - _WIDE and wanted - _WIDE:
        return True
    if any(usage.is_named_elsewhere(name, place, rap) for place in places):
        return False
    least = THRESHOLDS.same_variable
    return any(
        usage.together_elsewhere(a, b, rap) >= least for a in places for b in others
    )


_WIDE = {"number", "item", "text", "symbol"}
"""The kinds of so many values that two variables of a kind need not be related."""


def _stray(variable: nodes.Var, one: nodes.Var, where: str) -> Diagnostic:
    return STRAY_VARIABLE.at(
        variable.span,
        f"`{variable.name}` stands where the input `{one.name}` is expected",
        labels=(Label(one.span, where),),
        help=f"write `{one.name}`, or `?` for any value",
        about=(Subject(variable.span, variable.name),),
    )


OUTPUT_IS_INPUT = Rule(
    code="RAP105",
    name="output-is-input",
    severity=Severity.WARNING,
    summary="the output of a step is assigned to an input, which already has a value",
    ignore="where the step must fail unless it finds this value",
    source="T 4.2",
)


@check(OUTPUT_IS_INPUT, needs_whole="form")
def outputs(run: Pass) -> Iterator[Diagnostic]:
    """Find outputs of steps in variables that already have a value."""
    for rap in run.library.raps.values():
        inputs = {variable.name: variable for variable in rap.inputs}
        for method in rap.methods:
            for step in steps(method):
                yield from _taken(step.goal, inputs)


def _taken(goal: nodes.Goal, inputs: dict[str, nodes.Var]) -> Iterator[Diagnostic]:
    given = {term.name: term for term in goal.args if isinstance(term, nodes.Var)}
    for output in goal.outputs:
        if not isinstance(output, nodes.Var) or output.anonymous:
            continue
        first = given.get(output.name) or inputs.get(output.name)
        if first is not None:
            yield OUTPUT_IS_INPUT.at(
                output.span,
                f"the output of `{goal.name}` is `{output.name}`, which already "
                "has a value",
                labels=(Label(first.span, "the value comes from here"),),
                help="use another variable, or write `?`",
                about=(Subject(output.span),),
            )


UNBINDABLE_OUTPUT = Rule(
    code="RAP028",
    name="unbindable-output",
    severity=Severity.WARNING,
    summary="neither `succeed` nor a method binds an output",
    ignore="where a problem solver adds methods that bind the output",
    source="T 4.2",
)

_LOST = {c.word for c in clauses.RAP if c.required and not c.hands_on}
"""Clauses whose bindings are never used."""


@check(UNBINDABLE_OUTPUT, needs_whole="form")
def unbindable_output(run: Pass) -> Iterator[Diagnostic]:
    """Find outputs that neither `succeed` nor any method can bind."""
    for rap in run.library.forms:
        if not isinstance(rap, nodes.DefineRap) or not rap.outputs or not rap.methods:
            continue
        if is_never(rap.succeed):
            continue
        names = {
            site.name
            for site in sites(rap, run.library.functions)
            if not site.negated and site.clause not in _LOST
        }
        for output in rap.outputs:
            if output.name not in names:
                yield _unbindable(output, names)


def _unbindable(output: nodes.Var, names: set[str]) -> Diagnostic:
    near = nearest(output.name, names)
    return UNBINDABLE_OUTPUT.at(
        output.span,
        f"nothing binds output `{output.name}`",
        help=f"did you mean `{near}`?"
        if near
        else "bind the output in `succeed`, in a context, or as the output of a step",
    )
