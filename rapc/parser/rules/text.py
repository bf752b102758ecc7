"""Rules of the reader about the text, independent of its meaning."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

_HAVE = "(declare-memory-proposition have (?thing))"

TEXT_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP001",
        name="missing-parenthesis",
        summary="a list is not closed, or a form has lost its first parenthesis",
        why="""Without its last parenthesis a list takes in what was meant to stand
behind it. The finding shows the list, where that was noticed and where, going by the
indentation, the parenthesis is most likely missing. Other findings in that form are
withheld: they might be due to this one. Words known from print are told.""",
        fix="unsafe: closes the list where the indentation says that it ends",
        source="T 3.1",
        example="""\
(define-rap (lift))
(define-rap (fetch)
  (method
    (task-net
      (t1 (lift))))
(define-rap (put-down))
""",
        better="""\
(define-rap (lift))
(define-rap (fetch)
  (method
    (task-net
      (t1 (lift)))))
(define-rap (put-down))
""",
    ),
    Rule(
        code="RAP002",
        name="surplus-parenthesis",
        summary="there is a closing parenthesis too many",
        why="""A parenthesis too many closes a list before its end, and what follows
stands outside of it. The finding shows the parenthesis that, going by the
indentation, is the one too many. Other findings in that form are withheld, as they
might be due to this one, but for slips whose meaning is clear.""",
        fix="unsafe: takes out the one that the indentation says is too many",
        source="T 3.1",
        example="""\
(define-rap (lift))
(define-rap (fetch))
  (method
    (task-net
      (t1 (lift)))))
""",
        better="""\
(define-rap (lift))
(define-rap (fetch)
  (method
    (task-net
      (t1 (lift)))))
""",
    ),
    Rule(
        code="RAP003",
        name="unterminated-string",
        summary="a string is not closed",
        why="""Without its last quotation mark a string takes in the rest of the
file. It is taken to end with its line; what follows is read as usual.""",
        fix="unsafe: closes it at the end of its line, before the parentheses there",
        source="L 1",
        example="""\
(declare-memory-proposition open (?door) "what is known of doors)
(define-rap (wait))
""",
        better="""\
(declare-memory-proposition open (?door) "what is known of doors")
(define-rap (wait))
""",
    ),
    Rule(
        code="RAP004",
        name="unterminated-comment",
        summary="a comment that begins with `#|` is not closed",
        why="""Such comments nest, so each `#|` needs a `|#` of its own. One without
takes in the rest of the file. It is taken to end where the next form begins in
column one.""",
        fix="unsafe: closes it before the next form",
        source="L 1",
        example="""\
#| what a robot does
when there is nothing to do
(define-rap (wait))
""",
        better="""\
#| what a robot does
when there is nothing to do |#
(define-rap (wait))
""",
    ),
    Rule(
        code="RAP005",
        name="illegal-character",
        summary="a character has no place in this language",
        why="""Symbols and lists stand for themselves and are not quoted as in other
Lisps; lists are written with parentheses, strings with plain quotation marks, space
with blanks, tabs and line ends.""",
        fix="safe: takes out a quotation mark before a symbol or a list",
        source="L 1",
        example=f"""{_HAVE}
(define-rap (fetch)
  (succeed (have 'cup)))
""",
        better=f"""{_HAVE}
(define-rap (fetch)
  (succeed (have cup)))
""",
    ),
    Rule(
        code="RAP006",
        name="nested-too-deeply",
        summary="lists are nested more than 100 deep",
        why="""No program needs such depth; where it occurs, closing parentheses are
missing, or the file is none of ours. What lies deeper is left out.""",
        source="L 1",
        example=f"""\
(define-rap (wait)
  (succeed {99 * "(not "}true{99 * ")"}))
""",
        better="""\
(define-rap (wait)
  (succeed (not (not true))))
""",
    ),
    Rule(
        code="RAP007",
        name="too-long",
        summary="a name or a number is absurdly long",
        why="""Names may have up to 1000 characters and numbers up to 100, which
keeps numbers in the range that arithmetic can handle. Longer ones mean that the file
is damaged or none of ours.""",
        source="L 1",
        example=f"""\
(define-rap (wait)
  (duration 1{100 * "0"}))
""",
        better="""\
(define-rap (wait)
  (duration 10))
""",
    ),
    Rule(
        code="RAP008",
        name="malformed-number",
        summary="something looks like a number and is none",
        why="""Numbers are integers and decimals with digits on both sides of the
point, with a sign if wanted; there are no exponents. Anything else would be a
symbol, which is hardly what was meant.""",
        fix="safe: writes the number that is meant, where it can be told",
        source="L 1",
        example="""\
(define-rap (wait)
  (duration 1e3))
""",
        better="""\
(define-rap (wait)
  (duration 1000))
""",
    ),
    Rule(
        code="RAP009",
        name="unknown-form",
        summary="something at the top level is no form of the language",
        why="""A file is a row of definitions, declarations and `require`s. Whatever
else stands there would have no effect.""",
        fix="unsafe: writes the name that is spelled almost so, where there is one",
        source="L 1",
        example="""\
(define-rapp (wait))
""",
        better="""\
(define-rap (wait))
""",
    ),
)
