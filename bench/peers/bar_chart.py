"""Bar charts as SVG, from the standard library alone.

Colours carry the kind of a bar and are told apart in grey too; every bar names its number, so no
reader depends on the scale.
"""

from html import escape

INK = "#222222"
GRID = "#d8d8d8"
#: rilievo first, peers after it; for stacked bars dark is preparation, light is rendering.
OURS = ("#8a3b12", "#e08a4f")
THEIRS = ("#2d4a66", "#8fb0cf")

ROW = 22
LABEL = 230
WIDTH = 760
NUMBER = 90


class Bar:
    """One row: a label, its parts from the left, and what is written behind them."""

    def __init__(self, label, parts, told, ours):
        self.label, self.parts, self.told, self.ours = label, parts, told, ours


def chart(title, groups, most=None):
    """The picture as text. `groups` is a list of (heading, bars); all share one linear scale.

    A bar longer than `most` is cut there and marked.
    """
    longest = max(sum(bar.parts) for _, bars in groups for bar in bars)
    most = min(most or longest, longest)
    room = WIDTH - LABEL - NUMBER
    rows = sum(len(bars) + 1 for _, bars in groups)
    height = 40 + ROW * rows
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
        f'viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" font-size="13">',
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>',
        text(8, 22, title, weight="bold"),
    ]
    y = 40
    for heading, bars in groups:
        out.append(text(8, y + 15, heading, weight="bold"))
        out.append(f'<line x1="{LABEL}" y1="{y + 11}" x2="{WIDTH - 8}" y2="{y + 11}" stroke="{GRID}"/>')
        y += ROW
        for bar in bars:
            out.append(text(LABEL - 8, y + 15, bar.label, anchor="end"))
            x = float(LABEL)
            end = LABEL + room
            for value, colour in zip(bar.parts, OURS if bar.ours else THEIRS):
                length = min(value / most * room, end - x)
                out.append(f'<rect x="{x:.1f}" y="{y + 3}" width="{max(length, 0.5):.1f}" '
                           f'height="{ROW - 6}" fill="{colour}"/>')
                x += length
            if sum(bar.parts) > most:
                out.append(f'<path d="M{end - 14} {y + 1} l6 {ROW - 2} h4 l-6 -{ROW - 2} z" fill="#ffffff"/>')
            out.append(text(x + 6, y + 15, bar.told))
            y += ROW
    out.append("</svg>")
    return "\n".join(out) + "\n"


def text(x, y, words, anchor="start", weight="normal"):
    return (f'<text x="{x:.1f}" y="{y}" fill="{INK}" text-anchor="{anchor}" '
            f'font-weight="{weight}">{escape(words)}</text>')
