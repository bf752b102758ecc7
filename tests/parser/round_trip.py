"""What the printer writes of a text, held against the text.

`python -m tests.parser.round_trip 2000` prints and reads so many generated programs.
"""

from __future__ import annotations

import sys

from rapc.ir.layout import laid_out
from rapc.ir.printer import format_node
from tests.parser.programs import for_each_program
from tests.parser.reading import parsed


def changed(text: str) -> list[str]:
    """The forms of a text, as printed, that do not read back as they are.

    Forms in which something is found are left out: what was left out of them is lost.
    """
    unit = parsed(text)
    places = [found.span for found in unit.diagnostics]
    wrong = []
    for form in (*unit.forms, *unit.tests):
        span = form.span
        if any(span.start <= place.start < span.end for place in places):
            continue
        for printed in (format_node(form), laid_out(form)):
            back = parsed(printed)
            if back.diagnostics or (*back.forms, *back.tests) != (form,):
                wrong.append(printed)
    return wrong


def main(count: int) -> None:
    """Print the forms that do not read back, and how many programs there were."""
    seen = {"programs": 0, "forms that do not read back": 0}

    def hold(text: str) -> None:
        wrong = changed(text)
        seen["programs"] += 1
        seen["forms that do not read back"] += len(wrong)
        if wrong:
            print(text, *wrong, sep="\n")

    for_each_program(count, hold)
    for what, number in seen.items():
        print(f"{number:6} {what}")


if __name__ == "__main__":
    main(int(sys.argv[1]))
