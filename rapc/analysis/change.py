"""What has become of the forms of a library since it was checked.

Only changes of RAPs, and of one agenda, are told apart: where a declaration, a rule,
what files require or the order of forms is another, there is no answer.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.file_census import FormKey
from rapc.analysis.kept import FileState, FormState, State


class Change(msgspec.Struct, frozen=True):
    """What has become of the forms of a library, told by file and beginning."""

    #: The files with another text, or none, or that were not there before.
    files: frozenset[str]
    #: The forms whose text is another, or that are not there any more.
    gone: Mapping[FormKey, FormState]
    #: The forms with a new text.
    fresh: Mapping[FormKey, FormState]
    #: Where forms of changed files begin now whose text is as before.
    moved: Mapping[FormKey, FormKey]

    def now(self, key: FormKey) -> Iterator[FormKey]:
        """Yield where a form is now, unless its text is another."""
        if key[0] not in self.files:
            yield key
        elif key in self.moved:
            yield self.moved[key]


def change_of(old: State, files: Mapping[str, FileState]) -> Change | None:
    """Return what has changed; None if it is more than RAPs and one agenda.

    Args:
        old: the library as it was.
        files: its files now, in the order in which they are read.
    """
    before = {one.name: one for one in old.files}
    both = [name for name in before if name in files]
    if both != [name for name in files if name in before]:
        return None
    gone: dict[FormKey, FormState] = {}
    fresh: dict[FormKey, FormState] = {}
    moved: dict[FormKey, FormKey] = {}
    changed = [
        name
        for name in dict.fromkeys((*before, *files))
        if name not in before or name not in files or before[name] is not files[name]
    ]
    for name in changed:
        was = before[name].forms if name in before else ()
        now = files[name].forms if name in files else ()
        if [*_declared(was)] != [*_declared(now)]:
            return None
        pairs = _same(was, now)
        if pairs is None or _in_both(was, now) != _in_both(now, was):
            return None
        moved.update(((name, a.start), (name, b.start)) for a, b in pairs)
        kept = {id(one) for pair in pairs for one in pair}
        gone.update(((name, one.start), one) for one in was if id(one) not in kept)
        fresh.update(((name, one.start), one) for one in now if id(one) not in kept)
    if any(one.is_entangled for one in (*gone.values(), *fresh.values())):
        return None
    if _is_elsewhere(gone, fresh) or max(_agendas(gone), _agendas(fresh)) > 1:
        return None
    return Change(frozenset(changed), gone, fresh, moved)


def _in_both(forms: Iterable[FormState], others: Iterable[FormState]) -> list[str]:
    """Return what forms are called that others are called, too, in order."""
    names = {_called(one) for one in others}
    return [name for one in forms if (name := _called(one)) and name in names]


def _called(form: FormState) -> str:
    """Return the name of a RAP, a word for an agenda, nothing for all else."""
    return form.rap or ("(agenda)" if form.sort == "agenda" else "")


def _agendas(forms: Mapping[FormKey, FormState]) -> int:
    return sum(one.sort == "agenda" for one in forms.values())


def _is_elsewhere(
    gone: Mapping[FormKey, FormState], fresh: Mapping[FormKey, FormState]
) -> bool:
    """Whether a form that has changed stands in another file than before."""
    was_in = {name: key[0] for key, one in gone.items() if (name := _called(one))}
    return any(key[0] != was_in.get(_called(one), key[0]) for key, one in fresh.items())


def _declared(forms: Iterable[FormState]) -> Iterator[bytes]:
    return (one.digest for one in forms if not one.rap and not one.sort)


def requires_the_same(
    was: Mapping[str, tuple[str, ...]],
    now: Mapping[str, tuple[str, ...]],
    files: Container[str],
) -> bool:
    """Whether some files require, and are required, as they were.

    Args:
        was: what files required themselves.
        now: what they require.
        files: those that were there and still are.
    """
    return _of(was, files) == _of(now, files)


def _of(
    required: Mapping[str, tuple[str, ...]], files: Container[str]
) -> tuple[object, object]:
    own = {name: there for name, there in required.items() if name in files}
    return own, {one for there in required.values() for one in there if one in files}


def _same(
    was: Sequence[FormState], now: Sequence[FormState]
) -> list[tuple[FormState, FormState]] | None:
    """Return the forms with the text they had; None if their order is another."""
    known: dict[bytes, list[FormState]] = {}
    for one in was:
        known.setdefault(one.digest, []).append(one)
    pairs = []
    for one in now:
        there = known.get(one.digest)
        if there:
            pairs.append((there.pop(0), one))
    starts = [one.start for one, _ in pairs]
    return pairs if starts == sorted(starts) else None
