"""Edits as a person makes them, and the findings that must follow."""

from __future__ import annotations

import time
from pathlib import Path

from tests.lsp.client import Editor  # before lsprotocol: it skips without it

from lsprotocol import types  # isort: skip

from rapc.analysis.config_file import nearest_config
from rapc.analysis.libraries import check_workspace

TYPED = """\
; Wait for a while, then look again.
(define-rap (typed ?here)
  (succeed (at robot ?here))
  (method (task-net (t1 (typed ?here)) (t2 (other ?there)))))

"""
"""A text with and without faults while it is typed."""


def type_keys(
    editor: Editor, uri: str, rap: str, count: int, pause: float
) -> list[float]:
    """Type some keys, and ask about a RAP of the file after each of them.

    Args:
        editor: the editor.
        uri: the file; the keys are typed before its text, so that all places move.
        rap: the name of the RAP.
        count: the number of keys.
        pause: the seconds from one key to the next.

    Returns:
        the seconds of each answer.
    """
    head = "(define-rap ("
    typed = 0
    times = []
    for _ in range(count):
        start = time.perf_counter()
        if typed == len(TYPED):
            editor.change(uri, 0, typed, "")
            typed = 0
        else:
            editor.change(uri, typed, typed, TYPED[typed])
            typed += 1
        place = editor.texts[uri].index(f"{head}{rap} ") + len(head)
        position = editor.at(uri, place)
        document = types.TextDocumentIdentifier(uri)
        asked = time.perf_counter()
        hover = editor.ask(
            types.TEXT_DOCUMENT_HOVER, types.HoverParams(document, position)
        )
        times.append(time.perf_counter() - asked)
        assert f"({rap} " in hover.contents.value
        found = editor.ask(
            types.TEXT_DOCUMENT_DEFINITION,
            types.DefinitionParams(document, position),
        )
        assert [(one.uri, one.range.start) for one in found] == [(uri, position)]
        time.sleep(max(0.0, pause - (time.perf_counter() - start)))
    return times


def assert_findings_are_fresh(editor: Editor, files: dict[str, Path]) -> None:
    """Compare the findings of open files with those of a check by a new process.

    Args:
        editor: the editor.
        files: the paths of the files by address.
    """
    texts = {str(file): editor.texts[uri] for uri, file in files.items()}
    folder = str(editor.folders[0])
    report = check_workspace(folder, nearest_config(folder), None, texts)
    for uri, file in files.items():
        expected = sorted(
            (one.rule.name, one.diagnostic.message.partition("\n")[0])
            for one in report.findings
            if one.diagnostic.span.file == str(file)
        )
        editor.findings(uri)
        editor.expect(uri, expected)
