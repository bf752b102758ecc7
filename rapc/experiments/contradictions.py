"""What contradicts itself in an experiment, whatever its library and world are."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.experiments.definition import Experiment, Series
from rapc.experiments.draws import Between, names_in


def contradictions(experiment: Experiment) -> Iterator[str]:
    """Yield what is wrong with an experiment, in words."""
    if experiment.library == "-":
        yield "`library`: standard input is there only once, a file is wanted"
    yield from _about_tasks(experiment)
    names = [part.name for part in experiment.part]
    for part in experiment.part:
        told = f"part `{part.name}`"
        if names.count(part.name) > 1:
            yield f"there is more than one {told}"
        if (part.vary is None) != (not part.values):
            yield f"{told} needs both `vary` and `values`, or neither"
        if len(set(map(repr, part.values))) < len(part.values):
            yield f"{told} has a value twice"
        if part.mark is not None and part.vary is None:
            yield f"{told} has a `mark`, but varies nothing"
        others = {p.name for p in experiment.part if p.vary == part.vary and p.vary}
        yield from (
            f"{told} is to be drawn beside `{other}`, which is no part that varies "
            "the same"
            for other in part.beside
            if other not in others - {part.name}
        )
        yield from _misfits(part, told)


def _misfits(part: Series, told: str) -> Iterator[str]:
    """Figures from elsewhere that are not one for each value."""
    if part.reference is None:
        return
    many = len(part.reference.at) if part.vary is not None else 1
    if part.vary is None and part.reference.at:
        yield f"{told} varies nothing, so its reference needs no `at`"
        return
    for value in part.reference.at:
        if value not in part.values:
            what = f"reference figures at {value}, which is none of its `values`"
            yield f"{told} has {what}"
    for measure, bounds in part.reference.bounds.items():
        for value, low, high in bounds:
            if value not in part.values:
                what = f"a bound of `{measure}` at {value}, which is none of its values"
                yield f"{told} has {what}"
            if low > high:
                yield f"{told} has a bound of `{measure}` that ends below its beginning"
    for measure, figures in part.reference.figures.items():
        if len(figures) != many:
            yield (
                f"{told} has {len(figures)} reference figures for `{measure}`, "
                f"but {many} values they could be for"
            )


def _about_tasks(experiment: Experiment) -> Iterator[str]:
    """Parts without a task, and draws that nobody uses or makes."""
    for part in experiment.part:
        agenda, tasks = experiment.given(part)
        if agenda is None and not tasks:
            yield f"part `{part.name}` needs an `agenda` or `tasks`"
    used = dict.fromkeys(name for text in _texts(experiment) for name in names_in(text))
    for name, draw in experiment.draw.items():
        if name not in used:
            yield f"`draw`, {name}: no task and no option has `{{{name}}}`"
        if isinstance(draw, Between) and draw.low > draw.high:
            yield f"`draw`, {name}: `from` is more than `to`"
        elif not isinstance(draw, Between) and not draw:
            yield f"`draw`, {name}: there is nothing to draw from"
    for part in experiment.part:
        for task in experiment.given(part)[1]:
            for name in names_in(task):
                if name not in experiment.draw:
                    yield f"a task has `{{{name}}}`, which `draw` does not have"


def _texts(experiment: Experiment) -> Iterator[str]:
    """The texts in which a value that is drawn may stand."""
    for part in experiment.part:
        yield from experiment.given(part)[1]
        yield from (value for value in part.values if isinstance(value, str))
    for table in (experiment.set, *[part.set for part in experiment.part]):
        for settings in table.values():
            yield from (text for text in settings.values() if isinstance(text, str))
