"""`rapc rule [NAME]`: the manual page of a rule, of all rules, or their list."""

from __future__ import annotations

import json

import click
import msgspec

from rapc.analysis import registry
from rapc.analysis.selection import UnknownRuleError, rule_names
from rapc.base.diagnostics import Rule
from rapc.cli.options import command, fail
from rapc.errors import in_a_line

EXAMPLES = """\b
Examples:
  rapc rule
  rapc rule unbound-variable
  rapc rule RAP012 --format json
  rapc rule --all
"""


@command(EXAMPLES)
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="Print the pages of all rules.")
@click.option(
    "--format",
    "output_format",
    type=click.Choice(["text", "json"]),
    default="text",
    show_default=True,
    help="Format of the pages; text is Markdown.",
)
def rule(name: str | None, everything: bool, output_format: str) -> None:
    """Explain the rule NAME (a name or a code).

    Without NAME, all rules are listed, one a line. `rapc check` reports an opt-in rule
    only if `--select` or `--extend-select` names the rule, or selects `ALL`.

    Exit status: 0; 2 for an unknown rule.
    """
    if name is not None and everything:
        fail("cannot combine the name of a rule and --all")
    rules = registry.rules()
    chosen = list(rules.values()) if name is None else [_find(name)]
    if output_format == "json":
        click.echo(_json(chosen, one=name is not None))
    elif name is None and not everything:
        width = max(len(one.name) for one in chosen)
        for one in chosen:
            told = f"{one.summary}{' (opt-in)' * one.opt_in}"
            severity = f"{one.severity.word:7}"
            click.echo(f"{one.code}  {one.name:{width}}  {severity}  {told}")
    else:
        title = "# The rules of rapc check\n\n" if everything else ""
        click.echo(title + "\n".join(_page(one) for one in chosen), nl=False)


def _find(word: str) -> Rule:
    try:
        (name,) = rule_names([word])
    except UnknownRuleError as error:
        fail(in_a_line(error))
    return registry.rules()[name]


def _page(one: Rule) -> str:
    """Return a rule's page in Markdown."""
    page = one.page
    return (
        f"## {one.name}\n\n"
        f"{one.code}, {one.severity.word}{', opt-in' * one.opt_in}: {one.summary}.\n\n"
        f"{page.why}\n\n"
        f"Example:\n\n```rap\n{page.example}```\n\n"
        f"Use instead:\n\n```rap\n{page.better}```\n\n"
        + "\n".join(f"- {name}: {said}." for name, said in advice(one).items())
        + "\n"
    )


def advice(one: Rule) -> dict[str, str]:
    """Return advice on findings of a rule, and further reading, by title."""
    return {
        "Fix": one.fix or "none; the correction depends on the intention",
        "Ignore it": one.ignore or "not possible; a library with this error is refused",
        "Source": one.source,
    }


def _json(chosen: list[Rule], *, one: bool) -> str:
    pages = [_fields(rule) for rule in chosen]
    return json.dumps(pages[0] if one else pages, indent=2, ensure_ascii=False)


def _fields(one: Rule) -> dict[str, object]:
    """Return a rule and its page as JSON has them."""
    page = one.page
    return {
        "code": one.code,
        "name": one.name,
        "summary": one.summary,
        "why": " ".join(page.why.split()),
        "example": page.example,
        "better": page.better,
        **msgspec.structs.asdict(one),
        "severity": one.severity.word,
    }
