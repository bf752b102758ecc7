"""The picture of the cycle in explanation/how-raps-work, drawn as SVG with text."""

from __future__ import annotations

from html import escape

INK, PAPER, LINE = "#1a1a2e", "#ffffff", "#5c6bc0"
FILLS = {"part": "#e8eaf6", "step": "#fff8e1", "end": "#f1f1f1"}
STYLE = (
    f"text{{font:15px sans-serif;fill:{INK}}} .small{{font-size:12.5px}}"
    f" .name{{font-weight:bold}} .way{{stroke:{LINE};stroke-width:2;fill:none}}"
)

BOXES = (
    ("part", 20, 120, 160, "Agenda", "all live tasks"),
    ("step", 270, 24, 230, "1. Is the goal reached?", "succeed"),
    ("step", 270, 120, 230, "2. May the task go on?", "monitors, conditions"),
    ("step", 270, 216, 230, "3. Choose a method", "context, failures, chance"),
    ("step", 270, 312, 230, "4. Start the method", "task-net or primitive"),
    ("end", 590, 24, 190, "Task succeeds", "its effects take place"),
    ("end", 590, 120, 190, "Task waits or fails", "a fact or a time wakes it"),
    ("end", 590, 216, 190, "Task fails", "its parent chooses again"),
    ("part", 590, 312, 190, "World", "simulator or machine"),
    ("part", 20, 408, 160, "Memory", "what the robot believes"),
)
"""Kind, left, top, width, name and note of each box; all boxes are 58 high."""

WAYS = (
    ("M180 149 C225 149 225 53 270 53", "select a task", 128, 84, False),
    ("M385 82 V120", "no", 394, 106, False),
    ("M385 178 V216", "yes", 394, 202, False),
    ("M385 274 V312", "", 0, 0, False),
    ("M500 53 H590", "yes", 532, 46, False),
    ("M500 149 H590", "no", 534, 142, False),
    ("M500 245 H590", "none", 526, 238, False),
    ("M500 341 H590", "request", 518, 334, False),
    ("M270 341 H100 V178", "new tasks", 112, 334, False),
    ("M685 370 V437 H180", "results and data, through handlers", 300, 430, False),
    ("M60 408 V379 H235 V245 H270", "queries", 112, 372, True),
    ("M235 245 V149 H270", "", 0, 0, True),
    ("M235 149 V66 H270", "", 0, 0, True),
)
"""Path, label with its position, and whether the path is dashed."""


def cycle() -> str:
    """Return the picture; its own background makes it legible on any page."""
    parts = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 800 490" role="img">',
        "<title>The cycle of a task</title>",
        f"<style>{STYLE}</style>",
        f'<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7"'
        f' markerHeight="7" orient="auto"><path d="M0 0 L10 5 L0 10 z" fill="{LINE}"/>'
        "</marker></defs>",
        f'<rect width="800" height="490" rx="10" fill="{PAPER}"/>',
    ]
    for path, label, x, y, dashed in WAYS:
        dash = ' stroke-dasharray="5 4"' * dashed
        parts.append(f'<path class="way" d="{path}"{dash} marker-end="url(#tip)"/>')
        if label:
            parts.append(f'<text class="small" x="{x}" y="{y}">{escape(label)}</text>')
    for kind, x, y, width, name, note in BOXES:
        middle = x + width / 2
        parts += [
            f'<rect x="{x}" y="{y}" width="{width}" height="58" rx="8"'
            f' fill="{FILLS[kind]}" stroke="{LINE}"/>',
            f'<text class="name" x="{middle}" y="{y + 25}" text-anchor="middle">'
            f"{escape(name)}</text>",
            f'<text class="small" x="{middle}" y="{y + 45}" text-anchor="middle">'
            f"{escape(note)}</text>",
        ]
    return "\n".join([*parts, "</svg>", ""])
