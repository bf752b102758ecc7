"""Script mode: answer a series of inputs without a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TextIO

import msgspec

from rapc.debug.arguments import is_balanced
from rapc.repl.draw import draw
from rapc.repl.shell import Shell


def inputs(lines: Iterable[str]) -> Iterator[str]:
    """Yield the inputs in lines of text; a list may span several lines."""
    gathered = ""
    for line in lines:
        gathered = f"{gathered}\n{line.rstrip()}" if gathered else line.strip()
        if gathered.startswith(":") or is_balanced(gathered):
            if gathered:
                yield gathered
            gathered = ""
    if gathered:
        yield gathered


def run_script(
    shell: Shell,
    texts: Iterable[str],
    stream: TextIO,
    width: int,
    *,
    color: bool = False,
    as_json: bool = False,
) -> bool:
    """Answer inputs in order and write the answers.

    Args:
        shell: the shell that answers inputs.
        texts: the inputs.
        stream: the output stream.
        width: the width of an answer in characters.
        color: whether answers are coloured.
        as_json: whether to write each answer as a line of JSON.

    Returns:
        Whether every input succeeded.
    """
    well = True
    for text in texts:
        answer = shell.answer(text)
        well = well and not answer.failed
        if as_json:
            record = {"input": text, **answer.record()}
            stream.write(msgspec.json.encode(record, enc_hook=str).decode() + "\n")
        else:
            stream.write(draw(answer, width, color=color))
        stream.flush()
        if shell.left:
            break
    return well
