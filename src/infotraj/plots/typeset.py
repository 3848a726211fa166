"""A table of words and numbers: as Markdown, as LaTeX, and drawn."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from matplotlib.figure import Figure

from infotraj.plots import style

LINE = 0.155  # inches of one line of text
PADDING = 0.035  # inches above and below a row


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; a pipe inside a cell is escaped."""

    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"

    return "\n".join([line(header), line(["---"] * len(header)), *map(line, rows)]) + "\n"


def latex(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A LaTeX tabular with booktabs rules: first column left, the others centred."""
    special = {"%": r"\%", "&": r"\&", "_": r"\_", "#": r"\#"}

    def line(cells: Sequence[str]) -> str:
        return " & ".join("".join(special.get(c, c) for c in cell) for cell in cells) + r" \\"

    body = [line(header), r"\midrule", *map(line, rows)]
    head = r"\begin{tabular}{l" + "c" * (len(header) - 1) + "}"
    return "\n".join([head, r"\toprule", *body, r"\bottomrule", r"\end{tabular}"]) + "\n"


def draw(
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    widths: Sequence[float],
    colors: dict[tuple[int, int], str] | None = None,
    title: str = "",
) -> Figure:
    """The table as a figure: widths (inches) a column, text wrapped to them; colors of single cells (row, column)."""
    wrapped = [[_wrap(cell, width) for cell, width in zip(row, widths, strict=True)] for row in (header, *rows)]
    heights = [LINE * max(cell.count("\n") + 1 for cell in row) + 2 * PADDING for row in wrapped]
    total, top = sum(widths), 0.3 if title else 0.06
    figure = Figure(figsize=(total + 0.2, sum(heights) + top + 0.06))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-0.1, total + 0.1), ylim=(sum(heights) + 0.06, -top))
    axes.axis("off")
    axes.text(0.0, -0.12, title, va="center", fontsize=9)
    y = 0.0
    for number, (cells, height) in enumerate(zip(wrapped, heights, strict=True)):
        if number < 2 or cells[0].strip():
            axes.plot([0, total], [y, y], color=style.INK, lw=(1.0, 0.6)[number] if number < 2 else 0.2)
        x = 0.0
        for column, (cell, width) in enumerate(zip(cells, widths, strict=True)):
            color = (colors or {}).get((number - 1, column), style.INK)
            at, align = (x + 0.04, "left") if column == 0 else (x + 0.5 * width, "center")
            weight = "bold" if number == 0 else "normal"
            axes.text(
                at,
                y + 0.5 * height,
                cell,
                ha=align,
                va="center",
                color=color,
                weight=weight,
                fontsize=8.5,
                linespacing=0.85,
            )
            x += width
        y += height
    axes.plot([0, total], [y, y], color=style.INK, lw=1.0)
    return figure


def _wrap(cell: str, width: float) -> str:
    return "\n".join(textwrap.wrap(cell, max(4, int(width * 18)))) or " "
