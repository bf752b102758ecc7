"""Tokens for colours, indentation, and the Pygments lexer."""

from __future__ import annotations

import pytest
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.token import Error

from rapc.language.highlight import indentation, tokens
from rapc.language.pygments import RapLexer
from tests.parser.programs import texts


def kinds(text: str) -> dict[str, str]:
    return {said: kind for kind, said in tokens(text)}


def test_tokens_have_the_kinds_of_the_grammar() -> None:
    text = """
    (define-rap (go ?x) ; there
      (succeed (and (at "home" :now 3) (okay nil)))
      (method (context (> ?x (size-of ?s))) (task-net (t1 (task) for t2))))
    """
    assert kinds(text) == {
        **dict.fromkeys("()", "bracket"),
        "define-rap": "form",
        "go": "defined",
        **dict.fromkeys(("?x", "?s"), "variable"),
        "; there": "comment",
        **dict.fromkeys(("succeed", "method", "context", "task-net", "task"), "clause"),
        **dict.fromkeys(("and", ">", "size-of"), "operator"),
        **dict.fromkeys(("okay", "t1"), "head"),
        "at": "clause",
        '"home"': "string",
        ":now": "keyword",
        "3": "number",
        "nil": "word",
        **dict.fromkeys(("for", "t2"), "name"),
        **{said: kind for kind, said in tokens(text) if kind == "space"},
    }


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("(define-rap (index (go ?x)))", "go"),
        ("(define-query (near ?x) t)", "near"),
        ("(define-agenda day)", "day"),
        ("(define-method go fast (task-net))", "go"),
        ("(define-test one (task (go)))", "one"),
        ("(DECLARE-PRIMITIVE grasp () (okay))", "grasp"),
    ],
)
def test_names_that_a_form_defines_are_tokens_of_their_own(
    text: str, name: str
) -> None:
    assert [said for kind, said in tokens(text) if kind == "defined"] == [name]


def test_forms_without_a_name_define_nothing() -> None:
    for text in (
        "(define-test-defaults (world x))",
        '(require "a")',
        "(define-rap 3 a)",
    ):
        assert "defined" not in kinds(text).values()


def test_comments_nest_and_may_be_unfinished() -> None:
    assert kinds("#| a #| b |# c |#d")["#| a #| b |# c |#"] == "comment"
    assert kinds("x #| a #| b |# (")["#| a #| b |# ("] == "comment"


def test_lexer_reads_all_texts_of_the_repository_without_an_error_token() -> None:
    lexer = RapLexer(stripnl=False, ensurenl=False)
    wrong = set()
    for name, text in texts().items():
        found = list(lexer.get_tokens(text))
        assert "".join(part for _, part in found) == text, name
        wrong |= {part for kind, part in found if kind is Error}
    assert wrong == {"'"}  # the example of `illegal-character`


def test_lexer_marks_characters_that_are_not_rap() -> None:
    found = RapLexer().get_tokens("(a [b] 'c)")
    assert [part for kind, part in found if kind is Error] == ["[", "]", "'"]


def test_lexer_colours_html() -> None:
    html = highlight("(define-rap (go ?x))", RapLexer(), HtmlFormatter(nowrap=True))
    assert '<span class="kd">define-rap</span>' in html
    assert '<span class="nv">?x</span>' in html


def test_a_new_line_is_set_in_below_the_list_it_is_in() -> None:
    assert indentation("(define-rap (go ?x)") == 2
    assert indentation("(define-rap (go ?x)\n  (method") == 4
    assert indentation("(define-rap (go ?x)\n  (succeed (at ?x))") == 2
    assert indentation("(p)") == 0
