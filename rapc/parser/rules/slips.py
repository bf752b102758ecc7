"""Rules about published slips: invalid notations with a clear meaning."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

_HAVE = "(declare-memory-proposition have (?thing))"

SLIP_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP050",
        name="parenthesised-times",
        summary="the times of `monitor-time` stand in parentheses",
        why="""`monitor-time` takes its reference and its two times directly. The
other spelling has been printed; what it means is clear.""",
        fix="safe: takes the parentheses away",
        source="T 4.7.1",
        example="""\
(define-rap (watch)
  (succeed false)
  (monitor-time (now 10 15))
  (method (task-net)))
""",
        better="""\
(define-rap (watch)
  (succeed false)
  (monitor-time now 10 15)
  (method (task-net)))
""",
    ),
    Rule(
        code="RAP051",
        name="parenthesised-for",
        summary="`for` behind a formula stands in parentheses of its own",
        why="""An annotation that protects a formula is one list: the formula, `for`,
the tag. The other spelling has been printed; what it means is clear.""",
        fix="safe: takes the parentheses away",
        source="T 4.5.2",
        example=f"""{_HAVE}
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    (t1 (lift) ((have cup) (for t2)))
    (t2 (lift)))))
""",
        better=f"""{_HAVE}
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    (t1 (lift) ((have cup) for t2))
    (t2 (lift)))))
""",
    ),
    Rule(
        code="RAP052",
        name="bare-for",
        summary="`for` and its tag stand without parentheses",
        why="""Every annotation of a step is a list, also `(for tag)`. The other
spelling has been printed; what it means is clear.""",
        fix="safe: puts parentheses around it",
        source="T 4.5.2",
        example="""\
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    (t1 (lift) for t2)
    (t2 (lift)))))
""",
        better="""\
(define-rap (lift))
(define-rap (fetch)
  (method (task-net
    (t1 (lift) (for t2))
    (t2 (lift)))))
""",
    ),
    Rule(
        code="RAP053",
        name="not-of-many",
        summary="`not` is given several formulas",
        why="""`not` denies one formula. With several it might mean that they do not
hold together, or that none of them holds; it is read in the first way.""",
        fix="unsafe: joins the formulas by `and`; `or` may be meant",
        source="T 4.1.3",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed (not (have cup) (have plate))))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (not (and (have cup) (have plate)))))
""",
    ),
    Rule(
        code="RAP054",
        name="believe-without-time",
        summary="`believe` does not say how fresh a belief has to be",
        why="""`believe` asks for an age: a number that the age must stay below, or a
variable that becomes the age. Without an age the proposition alone says the same.""",
        fix="unsafe: binds the age to a variable, which asks for a belief of any age",
        source="T 4.1.1",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed (believe (have cup))))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (believe (have cup) 10)))
""",
    ),
    Rule(
        code="RAP055",
        name="bare-rule",
        summary="the query and the actions of a rule stand without parentheses",
        why="""A rule may have several queries, each with actions of its own, so each
query stands in parentheses with its actions. The other spelling has been printed;
what it means is clear.""",
        fix="safe: puts parentheses around it",
        source="S 4.2",
        example=f"""{_HAVE}
(define-rap (fetch ?thing))
(define-memory-rule (fetch ?thing) :finish
  (match-result (succeed (rule true (mem-add (have ?thing))))))
""",
        better=f"""{_HAVE}
(define-rap (fetch ?thing))
(define-memory-rule (fetch ?thing) :finish
  (match-result (succeed (rule (true (mem-add (have ?thing)))))))
""",
    ),
)
