"""Each claim of the paper with its number, ours and the interval, and whether it holds."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from infotraj.errors import InputError, problem
from infotraj.plots import style, typeset
from infotraj.writing import write_text

COLUMNS = ("claim", "paper", "ours", "low", "high", "holds")
COLORS = {"yes": style.GREEN, "no": style.VERMILION, "open": style.INK}
HEADER = ("claim", "paper", "ours", "95 % interval", "holds")


def claims_table(table: pd.DataFrame, markdown: str | Path | None = None, png: str | Path | None = None) -> None:
    """Writes the claims as Markdown and as a picture, where the path is given.

    A row a claim: claim (words), paper, ours, low, high (numbers or words), holds: yes or no where the whole interval
    says so, else open. InputError where a column is missing.
    """
    style.checked(table, COLUMNS, "claims")
    for value in table["holds"]:
        if value not in COLORS:
            raise InputError(problem(f"claims: holds is '{value}'", ", ".join(COLORS), "Write the table again."))
    if markdown is not None:
        write_text(typeset.markdown(HEADER, _cells(table)), markdown)
    if png is not None:
        style.write(lambda: draw_claims(table), png)


def draw_claims(table: pd.DataFrame) -> Figure:
    """The claims as a figure; argument as in `claims_table`."""
    colors = {(i, 4): COLORS[value] for i, value in enumerate(table["holds"])}
    return typeset.draw(HEADER, _cells(table), [3.6, 0.9, 0.8, 1.3, 0.6], colors)


def _cells(table: pd.DataFrame) -> list[list[str]]:
    rows = []
    for row in table.itertuples(index=False):
        low, high = _text(row.low), _text(row.high)
        interval = "-" if low == high == "-" else f"[{low}, {high}]"
        rows.append([str(row.claim), _text(row.paper), _text(row.ours), interval, str(row.holds)])
    return rows


def _text(value: object) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
