"""Random libraries whose forms depend on each other, and edits of single RAPs in them.

Names are declared, and used with as many arguments as they have, so that what is found
is found by what forms say to each other: constants spelled almost alike, arguments that
stand in each other's places, effects and goals, priorities, kinds.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

DECLARATIONS = """\
(declare-kind door (front back side))
(declare-kind room)
(declare-memory-property door-state ((?door door) ?state) unknown)
(declare-memory-property location (?thing ?place) unknown)
(declare-memory-property battery (?level) unknown)
(declare-memory-proposition at ((?room room)))
(declare-memory-proposition seen (?thing))
(declare-memory-proposition beside (?thing ?other))
(declare-memory-function near (?thing ?other))
(declare-primitive push ((?door door)) (okay jammed)
  :on (okay (door-state ?door open)))
(declare-primitive drive ((?room room)) (okay blocked) :on (okay (at ?room)))
(declare-primitive look () (okay) :on (okay (seen box)))
(declare-primitive grab (?thing ?place) (okay dropped)
  :on (okay (not (location ?thing ?place))))
(define-query (reachable ?thing) (or (seen ?thing) (location ?thing shelf)))
(define-memory-rule (r1 ?one ?other) :finish
  (match-result
    (succeed (rule (true (mem-add (beside ?one ?other)))))
    (jammed (rule (true (mem-del (seen ?one)))))))
(define-agenda day
  (task (r0 front hall) :priority 4 :background true)
  (task (r2 front hall) :priority 3 :background true)
  (task (r4 back yard)))
"""

WORDS = (
    *("open", "opened", "shut", "shutt", "jammed", "jamed", "front", "back", "box"),
    *("boxes", "shelf", "shelff", "hall", "yard", "unknown", "3", "40", "true"),
)
VARIABLES = ("?one", "?other", "?state", "?stat", "?place", "?open", "?shelf", "?box")
FACTS = (
    *("(door-state {} {})", "(location {} {})", "(beside {} {})", "(seen {})"),
    *("(at {})", "(battery {})", "(reachable {})", "(near {} {})", "(door-state {})"),
    *("(= {} {})", "(> {} 3)", "(believe (seen {}) 4)", "(last-result {})"),
)
REQUESTS = ("(push {})", "(drive {})", "(look)", "(grab {} {})")


class Maker:
    """Makes RAPs at random; `r0` to `rN` ask for each other.

    Args:
        dice: where chance comes from.
        names: how many RAPs there are.
    """

    def __init__(self, dice: random.Random, names: int) -> None:
        self._dice = dice
        self._names = names

    def files(self, count: int) -> dict[str, str]:
        """Return the texts of a library by the names of its files."""
        texts = {"a.rap": DECLARATIONS}
        for file in range(count):
            numbers = range(file, self._names, count)
            texts[f"p{file}.rap"] = "".join(map(self.rap, numbers))
        return texts

    def rap(self, number: int) -> str:
        """Return the text of a RAP by its number."""
        clauses = [
            f"  ({clause} {self._formula()})\n"
            for clause, often in _CLAUSES.items()
            if self._dice.random() < often
        ]
        if self._dice.random() < _SELDOM:
            clauses = [f"  (succeed nil)\n  (monitor-state {self._formula()})\n"]
        methods = [self._method(at) for at in range(self._dice.randrange(1, 3))]
        index = f"(index (r{number} ?one ?other))"
        return f"(define-rap {index}\n{''.join(clauses)}{''.join(methods)})\n"

    def _method(self, at: int) -> str:
        context = f"(context {self._formula()}) " * (self._dice.random() < _OFTEN)
        if self._dice.random() < _OFTEN:
            body = f"(primitive {self._filled(self._dice.choice(REQUESTS))})"
        else:
            count = self._dice.randrange(1, 4)
            steps = [self._step(step, last=step + 1 == count) for step in range(count)]
            body = f"(task-net {' '.join(steps)})"
        return f"  (method m{at} {context}{body})\n"

    def _step(self, at: int, *, last: bool) -> str:
        goal = self._filled(f"(r{self._dice.randrange(self._names)} {{}} {{}})")
        notes = ""
        if not last and self._dice.random() < _OFTEN:
            notes += f" ({self._fact()} for t{at + 1})"
        high = f"{self._dice.randrange(9)} " * (self._dice.random() < _SELDOM)
        return f"(t{at} {high}{goal}{notes})"

    def _formula(self) -> str:
        parts = [self._fact() for _ in range(self._dice.randrange(1, 4))]
        return parts[0] if len(parts) == 1 else f"(and {' '.join(parts)})"

    def _fact(self) -> str:
        fact = self._filled(self._dice.choice(FACTS))
        return f"(not {fact})" if self._dice.random() < _SELDOM else fact

    def _filled(self, pattern: str) -> str:
        terms = [self._term() for _ in range(pattern.count("{}"))]
        return pattern.format(*terms)

    def _term(self) -> str:
        words = VARIABLES if self._dice.random() < _OFTEN else WORDS
        return self._dice.choice(words)


_OFTEN, _SELDOM = 0.6, 0.2
_CLAUSES = {"preconditions": 0.2, "monitor-state": 0.2, "succeed": 0.5}


def edited(
    dice: random.Random, maker: Maker, files: Mapping[str, str]
) -> dict[str, str]:
    """Return a library with a change in one of its files."""
    texts = dict(files)
    if dice.random() < _SELDOM:
        return _with_other_files(dice, maker, texts)
    name = dice.choice([name for name in texts if name != "a.rap"])
    forms = _forms(texts[name])
    at = dice.randrange(len(forms))
    kind = dice.randrange(11)
    number = int(forms[at].split("(index (r", 1)[1].split(" ", 1)[0])
    if kind < 4:
        forms[at] = maker.rap(number)
    elif kind == 4:
        forms[at] = f"; rapc: ignore[{dice.choice(_RULES)}] an edit\n{forms[at]}"
    elif kind == 5:
        forms[at] = forms[at].replace("  (", "\n  (", 1)
    elif kind == 6:
        forms[at] = _with_another_word(dice, forms[at])
    elif kind == 7:
        forms.insert(at, maker.rap(_ADDED + dice.randrange(9)))
    elif kind == 8 and len(forms) > 1 and (number >= _ADDED or dice.random() < _SELDOM):
        del forms[at]
    elif kind == 9:
        forms[at] = _with_another_name(dice, forms[at])
    elif dice.random() < _SELDOM:
        texts["a.rap"] = texts["a.rap"].replace("shelf))", "hall))", 1)
    else:
        forms[0] = _with_another_require(dice, forms[0])
    texts[name] = "".join(forms)
    return texts


def damaged(dice: random.Random, files: Mapping[str, str]) -> dict[str, str]:
    """Return a library with a slip of the pen in one of its files."""
    texts = dict(files)
    name = dice.choice(list(texts))
    before, after = dice.choice(_SLIPS)
    places = [
        at for at in range(len(texts[name])) if texts[name].startswith(before, at)
    ]
    if places:
        at = dice.choice(places)
        texts[name] = texts[name][:at] + after + texts[name][at + len(before) :]
    return texts


_SLIPS = (
    *((")", ""), ("(", ""), (")", "))"), ("(", "(("), (")\n", "\n"), ("(method", "")),
    *((" ", ' "'), ("?", "#"), ("context", "contxt"), ("(define-rap", "(define-rp")),
    *(("(index", "index"), ("task-net", "task-nets"), ("(t1 ", "(t1 (")),
    *(("(method", "; rapc: ignore[malformed-form] a slip\n  (method method"),),
    *(("(primitive", "(primitive (look) "), ("(not ", "(not (seen box) ")),
)


def _with_other_files(
    dice: random.Random, maker: Maker, texts: dict[str, str]
) -> dict[str, str]:
    """Change declarations or the agenda, or have a file come or go."""
    kind = dice.randrange(6)
    if kind in (0, 4, 5):
        before, after = dice.choice(_DECLARED if kind == 0 else _GIVEN)
        texts["a.rap"] = texts["a.rap"].replace(before, after, 1)
    elif kind == 1:
        before = f":priority {dice.randrange(3, 5)}"
        after = f":priority {dice.randrange(9)}"
        texts["a.rap"] = texts["a.rap"].replace(before, after, 1)
    elif "q.rap" in texts:
        del texts["q.rap"]
    else:
        texts["q.rap"] = "".join(maker.rap(_ADDED + 50 + at) for at in range(2))
    return texts


_DECLARED = (
    ("(okay jammed)", "(okay jammed stuck)"),
    ("(okay jammed stuck)", "(okay jammed)"),
    ("(front back side)", "(front back side shelf)"),
    ("?state) unknown", "?state) shut"),
    (" :on (okay (seen box))", " :on (okay (seen box) (at hall))"),
    ("(seen ?thing)", "(seen ?thing ?place)"),
)

_GIVEN = (
    ("(task (r4 back", "(task (r5 back"),
    ("(task (r5 back", "(task (r4 back"),
    ("(task (r5 back", "(task (r77 back"),
    ("(task (r77 back", "(task (r3 shutt"),
    ("(task (r3 shutt", "(task (r4 back"),
    ("  (task (r4 back", "  (task (r1 shelf boxes))\n  (task (r4 back"),
    ("  (task (r1 shelf boxes))\n", ""),
    (" :background true)", ")"),
    ("(r0 front hall)", "(r0 hall front)"),
    ("(r0 hall front)", "(r0 front hall)"),
    (
        "(define-agenda day",
        "(define-agenda night\n  (task (r6 box hall)))\n(define-agenda day",
    ),
    ("(define-agenda night\n  (task (r6 box hall)))\n", ""),
)

_RULES = ("misspelt-constant", "swapped-arguments", "unbound-variable")


def _forms(text: str) -> list[str]:
    pieces = text.split("(define-rap")
    head = pieces[0]
    forms = [f"(define-rap{piece}" for piece in pieces[1:]]
    forms[0] = head + forms[0]
    return forms


_ADDED = 1000
"""The RAPs with these numbers and higher ones are asked for by none."""


def _with_another_require(dice: random.Random, text: str) -> str:
    head, begin, rest = text.partition("(define-rap")
    head = dice.choice((head, "", '(require "a")\n', '(require "p1")\n'))
    return head + begin + rest


def _with_another_name(dice: random.Random, text: str) -> str:
    """Ask for a RAP, a fact or a primitive that may not be there, or with too much."""
    before = dice.choice(("(r1", "(r2", "(location ", "(drive ", "(seen "))
    number = dice.randrange(99)
    after = dice.choice((f"(r{number}", "(locatin ", "(drve ", "(seen box "))
    head, begin, body = text.partition("?other))")
    return head + begin + body.replace(before, after, 1)


def _with_another_word(dice: random.Random, text: str) -> str:
    head, begin, body = text.partition("?other))")
    there: Sequence[str] = [word for word in (*WORDS, *VARIABLES) if word in body]
    if not there:
        return text
    return head + begin + body.replace(dice.choice(there), dice.choice(WORDS), 1)
