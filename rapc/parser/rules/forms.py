"""Rules about the shape of forms, clauses, formulas, terms and steps."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

_HAVE = "(declare-memory-proposition have (?thing))"

FORM_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP010",
        name="unknown-clause",
        summary="a clause or option has a name that does not exist",
        why="""A clause that nobody knows would have no effect. Some print has had
for others: `success` for `succeed`, `constraint` for `constraints`; these have a
safe fix.""",
        fix="safe for what print has had, else unsafe: writes the word that is meant",
        source="T 3.1, 4.10",
        example=f"""{_HAVE}
(define-rap (fetch)
  (success (have cup)))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (have cup)))
""",
    ),
    Rule(
        code="RAP011",
        name="duplicate-clause",
        summary="a clause stands twice where it may stand once",
        why="""Only methods may be several. Of two other clauses of one name the
first counts, and `and` joins what they say.""",
        source="T 4.10",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed (have cup))
  (succeed (have plate)))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (and (have cup) (have plate))))
""",
    ),
    Rule(
        code="RAP030",
        name="malformed-form",
        summary="a declaration lacks a part, or has one that does not fit",
        why="""Each declaration has its parts in a fixed order: a name, most often a
list of arguments, then what is special to it; a doc string and options may follow.""",
        fix="safe or unsafe by the part: writes a name with its mark, or in "
        "parentheses",
        source="T A.1",
        example="""\
(declare-memory-property colour (?thing ?colour))
""",
        better="""\
(declare-memory-property colour (?thing ?colour) unknown)
""",
    ),
    Rule(
        code="RAP031",
        name="malformed-clause",
        summary="a clause has parts that do not fit it",
        why="""Most clauses hold one formula; several are joined by `and`.
`monitor-time` takes a reference and two times, `resources` sets and counters, a
method a name and clauses.""",
        fix="unsafe: puts parentheses around what lacks them",
        source="T 4.10",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed (have cup) (have plate)))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (and (have cup) (have plate))))
""",
    ),
    Rule(
        code="RAP032",
        name="malformed-formula",
        summary="something is no formula",
        why="""A formula is a proposition, a comparison, a special form or a
connective, in parentheses, or one of the constants `true`, `t`, `false`, `nil`. What
computes a value is a term: it can be compared, but is neither true nor false.""",
        fix="safe: writes a bare `true` or `otherwise` for one in parentheses",
        source="T 4.1",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed have))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (have cup)))
""",
    ),
    Rule(
        code="RAP033",
        name="malformed-term",
        summary="something is no term",
        why="""An argument is a symbol, a number, a string, a variable or a computed
term such as `(+ ?n 1)`. Formulas have no value and cannot stand inside of one.""",
        source="T 4.1",
        example="""\
(define-rap (wait ?time)
  (succeed (> (+ ?time) 3)))
""",
        better="""\
(define-rap (wait ?time)
  (succeed (> (+ ?time 1) 3)))
""",
    ),
    Rule(
        code="RAP034",
        name="malformed-proposition",
        summary="a plain proposition is wanted",
        why="""What is asserted, noted, requested or believed is one proposition: a
name and its arguments. Connectives and comparisons are for questions only.""",
        fix="safe: writes the colon of an event or a skill",
        source="T 4.1",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed (believe (not (have cup)) 10)))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (not (believe (have cup) 10))))
""",
    ),
    Rule(
        code="RAP035",
        name="malformed-goal",
        summary="a goal or an index is not a name with arguments",
        why="""A step asks for a RAP by its name with inputs and, behind `=>`,
outputs, all in one list; the index of a RAP looks the same and has variables only.""",
        fix="safe where nothing else can be meant, else unsafe: puts parentheses "
        "around it",
        source="T 4.2",
        example="""\
(define-rap (index fetch ?thing))
""",
        better="""\
(define-rap (index (fetch ?thing)))
""",
    ),
    Rule(
        code="RAP036",
        name="malformed-step",
        summary="a step of a task-net lacks its tag or its goal",
        why="""Each step is a list: a tag to speak of it, a priority if wanted, the
goal, and annotations.""",
        source="T 4.5.2",
        example="""\
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    ((lift)))))
""",
        better="""\
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    (t1 (lift)))))
""",
    ),
    Rule(
        code="RAP037",
        name="unknown-annotation",
        summary="an annotation of a step does not exist",
        why="""An annotation that nobody knows would neither order nor end nor count
anything. `counter-del`, which has been printed, is called `counter-sub`.""",
        fix="safe for `counter-del`, else unsafe: writes the word that is meant",
        source="T 4.5.2",
        example="""\
(define-rap (lift))
(define-rap (fetch ?count)
  (method (task-net
    (t1 (lift) (counter-del ?count 1)))))
""",
        better="""\
(define-rap (lift))
(define-rap (fetch ?count)
  (method (task-net
    (t1 (lift) (counter-sub ?count 1)))))
""",
    ),
    Rule(
        code="RAP038",
        name="malformed-annotation",
        summary="an annotation of a step has parts that do not fit it",
        why="""`for`, `until-start` and `until-end` name one step, `window` a step or
a clock and two times, the effects a resource and one thing or amount, `wait-for` a
signal and what it does.""",
        source="T 4.5.2",
        example="""\
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    (t1 (lift) (until-end))
    (t2 (lift)))))
""",
        better="""\
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    (t1 (lift) (until-end t2))
    (t2 (lift)))))
""",
    ),
    Rule(
        code="RAP039",
        name="repeated-variable",
        summary="a variable is declared twice in one place",
        why="""The inputs and outputs of a RAP, the arguments of a declaration and
the resources of a task each have names of their own: one name cannot take two
values.""",
        source="T 4.2",
        example="""\
(define-rap (move ?thing ?thing))
""",
        better="""\
(define-rap (move ?thing ?place))
""",
    ),
    Rule(
        code="RAP040",
        name="missing-index",
        summary="a RAP has no name",
        why="""The index names a RAP and its inputs and outputs; without it nothing
can ask for it.""",
        source="T 4.2",
        example="""\
(define-rap
  (method (task-net)))
""",
        better="""\
(define-rap (wait)
  (method (task-net)))
""",
    ),
    Rule(
        code="RAP041",
        name="duplicate-method",
        summary="two methods of a RAP have one name",
        why="""`method-tried` and `result-with-method` speak of a method by its name,
and so do traces and tests.""",
        fix="unsafe: numbers the second one, and leaves questions about either as "
        "they are",
        source="T 4.5",
        example="""\
(define-rap (wait)
  (method 1 (task-net))
  (method 1 (task-net)))
""",
        better="""\
(define-rap (wait)
  (method 1 (task-net))
  (method 2 (task-net)))
""",
    ),
    Rule(
        code="RAP042",
        name="method-without-body",
        summary="a method does not say what to do",
        why="""A method has a `task-net` or a `primitive`. One that means to do
nothing says so with an empty task-net, `(task-net)`, which ends well at once.""",
        source="T 4.5",
        example="""\
(define-rap (wait)
  (method (context true)))
""",
        better="""\
(define-rap (wait)
  (method (context true) (task-net)))
""",
    ),
    Rule(
        code="RAP043",
        name="formula-too-large",
        summary="a formula has more than 200 parts",
        why="""Formulas become nested code, which has a limit. A declared function
can decide such a matter, or several RAPs can share it.""",
        source="L 1",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed (or{201 * " (have cup)"})))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (or (have cup) (have plate))))
""",
    ),
    Rule(
        code="RAP044",
        name="misplaced-clause",
        summary="a clause stands in the wrong kind of form",
        why="""`context`, `notations`, `task-net` and `primitive` belong to a method,
all other clauses to the RAP. Most often a parenthesis is missing or too many.""",
        source="T 4.10",
        example=f"""{_HAVE}
(define-rap (fetch)
  (method (task-net)
    (succeed (have cup))))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (method (task-net))
  (succeed (have cup)))
""",
    ),
    Rule(
        code="RAP045",
        name="malformed-rule",
        summary="a rule over memory has parts that do not fit it",
        why="""A memory rule names the goal it watches, when it runs, and cases; an
event rule names a signal. Both hold rules, each a list of queries with their
actions.""",
        source="S 4.2",
        example=f"""{_HAVE}
(define-rap (fetch ?thing))
(define-memory-rule (fetch ?thing)
  (match-result (succeed (rule (true (mem-add (have ?thing)))))))
""",
        better=f"""{_HAVE}
(define-rap (fetch ?thing))
(define-memory-rule (fetch ?thing) :finish
  (match-result (succeed (rule (true (mem-add (have ?thing)))))))
""",
    ),
    Rule(
        code="RAP046",
        name="grouped-steps",
        summary="steps are grouped by a word such as `sequence`",
        why="""The steps of a task-net stand beside each other. They may run in any
order, but for what their annotations say: `(for t2)` puts a step before step t2.""",
        source="T 4.5.2",
        example="""\
(define-rap (lift))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (sequence (t1 (lift)) (t2 (carry))))))
""",
        better="""\
(define-rap (lift))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (lift) (for t2))
    (t2 (carry)))))
""",
    ),
)
