"""Hover: what a name means, its documentation and its uses; the page of a rule."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from lsprotocol import types

from rapc.analysis.driver import Finding
from rapc.analysis.facts.effects import EFFECTS
from rapc.analysis.facts.kinds import INFERRED, Learned
from rapc.base.source import Span
from rapc.base.values import format_list
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import heads, spelling
from rapc.library.library import KINDS
from rapc.library.library import Named as Form
from rapc.lsp.workspace import View
from rapc.parser.names import Named

_MOST = 10
"""The number of uses that a hover lists."""

_USED = ("RAP", "predicate", "primitive", "datum", "skill", "event", "kind")
"""The name spaces whose uses are listed."""

_WORD = re.compile(r"[^\s()\";]+")


def hover(view: View, position: types.Position) -> types.Hover | None:
    """Return the text about the name and the findings at a position."""
    parts = [_of_finding(one) for one in _findings(view, position)]
    named = view.named(position)
    if named is not None:
        parts += of_name(view, named)
    elif not parts:
        parts += _of_word(view, view.then(position))
    if not parts:
        return None
    text = "\n\n".join(part for part in parts if part)
    place = None if named is None else view.range(named.span)
    content = types.MarkupContent(types.MarkupKind.Markdown, text)
    return types.Hover(content, place)


# --- findings and words ---------------------------------------------------------------


def _findings(view: View, position: types.Position) -> Iterator[Finding]:
    for other, one in view.workspace.findings(view.workspace.uri(view.name)):
        place = other.range(one.diagnostic.span)
        if place.start <= position <= place.end:
            yield one


def _of_finding(finding: Finding) -> str:
    rule = finding.rule
    link = f"[{rule.name}]({rule.page_file.as_uri()})"
    return f"**{link}**: {rule.summary}.\n\n{rule.page.why.strip()}"


def _of_word(view: View, offset: int) -> Iterator[str]:
    """Yield the notation and the purpose of a word of the language."""
    source = view.source
    line = source.line(source.row(offset))
    column = source.position(offset).column - 1
    for word in _WORD.finditer(line):
        if word.start() <= column <= word.end():
            for rule in RULES:
                if word[0].lower() in heads(rule) and GRAMMAR[rule].says:
                    yield f"```rap\n{spelling(rule)}\n```\n\n{GRAMMAR[rule].says}"
                    return


# --- names ----------------------------------------------------------------------------


def of_name(view: View, named: Named) -> Iterator[str]:
    """Yield the paragraphs about a name."""
    form = _form(view, named)
    if isinstance(form, nodes.DefineRap):
        yield from _of_rap(view, form)
    elif form is not None:
        yield from _of_form(view, form)
    else:
        yield from _of_other(view, named)
    if named.space in _USED:
        yield _users(view, named)


def _form(view: View, named: Named) -> Form | None:
    """Return the form that defines a name."""
    library = view.part.library
    for kind, (field, space, _) in KINDS.items():
        if space == named.space and named.name in getattr(library, field):
            found: Form = getattr(library, field)[named.name]
            assert isinstance(found, kind)
            return found
    return None


def _of_rap(view: View, rap: nodes.DefineRap) -> Iterator[str]:
    inputs = " ".join([rap.name, *(one.name for one in rap.inputs)])
    outputs = " ".join(one.name for one in rap.outputs)
    yield f"```rap\n({inputs}{' => ' + outputs if outputs else ''})\n```"
    yield documentation(view, rap)
    if rap.succeed is not None:
        yield f"succeed: `{format_node(rap.succeed)}`"
    learned = _inferred(view, rap.name)
    declared = {one.variable: one.kind for one in rap.kinds}
    kinds = [
        f"`{variable.name}` {kind}"
        for at, variable in enumerate(rap.inputs)
        if (kind := declared.get(variable.name) or _learned(learned, at))
    ]
    yield f"kinds: {', '.join(kinds)}" if kinds else ""
    effects = view.part.run.known(EFFECTS)
    changes = () if effects is None else effects.known(rap.name)
    said = dict.fromkeys(f"`{'not ' * one.gone}{one.name}`" for one in changes)
    yield f"may change: {_listed(said)}" if said else ""


def _inferred(view: View, rap: str) -> Sequence[Learned | None]:
    """Return the inferred kinds of the inputs of a RAP; none before the full check."""
    inferred = view.part.run.known(INFERRED)
    return () if inferred is None else inferred.inputs.get(rap, ())


def _learned(learned: Iterable[object], at: int) -> str:
    one = [*learned, *[None] * (at + 1)][at]
    return getattr(one, "kind", "")


def _of_form(view: View, form: Form) -> Iterator[str]:
    word = KINDS[type(form)][2]
    args = getattr(form, "args", None) or ()
    shown = [
        arg.variable.name if arg.kind is None else f"({arg.variable.name} {arg.kind})"
        for arg in args
    ]
    name = getattr(form, "name", "")
    line = format_list([name]) if not shown else f"({' '.join([name, *shown])})"
    if isinstance(form, nodes.DeclareKind | nodes.DefineAgenda):
        line = name
    yield f"```rap\n{line}\n```\n\n{word}"
    yield documentation(view, form)
    if isinstance(form, nodes.DeclarePrimitive):
        on = {one.result: one.effects for one in form.on}
        rows = []
        for result in form.results:
            effects = " ".join(format_node(one) for one in on.get(result, ()))
            rows.append(f"- {result}" + (f": `{effects}`" if effects else ""))
        yield "\n".join(rows)
    elif isinstance(form, nodes.DeclareKind) and form.values is not None:
        yield "values: " + " ".join(map(str, form.values))
    elif isinstance(form, nodes.DefineQuery):
        yield f"```rap\n{format_node(form.formula)}\n```"


def _of_other(view: View, named: Named) -> Iterator[str]:
    """Yield the text about a name without a form: a variable, a tag, a result."""
    owner = f" of `{named.rap}`" if named.rap else ""
    yield f"{named.space} `{named.name}`{owner}"
    if named.space == "variable" and named.rap:
        rap = view.part.library.raps.get(named.rap)
        inputs = [] if rap is None else [one.name for one in rap.inputs]
        if named.name in inputs:
            learned = _inferred(view, named.rap)
            kind = _learned(learned, inputs.index(named.name))
            yield f"kind: {kind}" if kind else ""


def _users(view: View, named: Named) -> str:
    """Return the RAPs and other forms that use a name."""
    found = view.names.naming.occurrences(named, _COUNTED + 1)
    uses = [one for one in found if not one.defines]
    if not uses:
        return "not used"
    if len(found) > _COUNTED:
        owners = dict.fromkeys(_owner(view, one) for one in uses[:_MOST])
        return f"used at least {len(uses)} times: {', '.join(owners)}, ..."
    times = "once" if len(uses) == 1 else f"{len(uses)} times"
    owners = dict.fromkeys(_owner(view, one) for one in uses)
    return f"used {times}: {_listed(owners)}"


_COUNTED = 100
"""The number of occurrences after which a hover stops to count."""


def _owner(view: View, use: Named) -> str:
    """Return the name of the form around a use: the second word of the form."""
    source = view.names.view(use.span.file).source
    place = source.word(use.form, 1)
    if place == use.form:  # a parenthesis precedes the name
        place = source.word(
            source.span(source.text.index("(", place.start + 1), place.end), 0
        )
    return f"`{source.text[place.start : place.end]}`"


def _listed(names: Iterable[str]) -> str:
    known = list(names)
    more = f" and {len(known) - _MOST} more" if len(known) > _MOST else ""
    return ", ".join(known[:_MOST]) + more


def documentation(view: View, form: Form) -> str:
    """Return the documentation of a form, or else the comment above the form."""
    return getattr(form, "doc", "") or _comment_above(view, form.span)


def _comment_above(view: View, span: Span) -> str:
    """Return the comment in the lines directly above a form, without its marks."""
    unit = view.part.units.get(span.file)
    if unit is None:
        return ""
    text = unit.file.text
    at, lines = span.start, []
    for comment in reversed(unit.comments):
        if comment.span.end > at:
            continue
        gap = text[comment.span.end : at]
        if gap.strip() or gap.count("\n") > 1:
            break
        lines.append(comment.text.strip("#|").lstrip(";").strip())
        at = comment.span.start
    return "\n".join(reversed(lines))
