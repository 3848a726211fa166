"""How often `check` errs, by source of logs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from infotraj.errors import InputError, problem
from infotraj.plots import style

_LOOKS = {
    "rejections": ("rejected", style.VERMILION, "s", 0.22),
    "cuts": ("cut", style.ORANGE, "D", 0.0),
    "warnings": ("warned", style.BLUE, "o", -0.22),
}
_AIM = {"whole": 1.0, "segment": 1.0}  # %


def errors_of_check(sources: Mapping[str, Mapping[str, Any]], *paths: str | Path) -> None:
    """Draws, a line a source, the shares of good whole flights and segments with false findings, and of errors found.

    sources: `experiment.check_corpus.summary`'s figures by source.
    """
    if not sources:
        raise InputError(problem("no sources", "at least one", "Run `snakemake check_corpus`."))
    style.write(lambda: _drawn(sources), *paths)


def _drawn(sources: Mapping[str, Mapping[str, Any]]) -> Figure:
    names = list(sources)[::-1]
    figure = style.figure(style.DOUBLE, 0.2 * len(names) + 1.1)
    panels = figure.subplots(1, 3, sharey=True)
    for panel, part in zip(panels, ("whole", "segment"), strict=False):
        for what, (label, color, marker, shift) in _LOOKS.items():
            shares = [sources[name][part][what] for name in names]
            _points(panel, shares, shift, label=label, color=color, marker=marker)
        panel.set_xlabel(f"{'Whole flights' if part == 'whole' else 'Segments of 10 s'}\nwith a false finding (%)")
        panel.set_xscale("symlog", linthresh=1.0)
        panel.set_xlim(0.0, 110.0)
        panel.set_xticks([0, 1, 10, 100], ["0", "1", "10", "100"])
        panel.axvline(_AIM[part], color=style.GREY, lw=0.8, ls="--")
    _points(panels[2], [sources[name]["found"] for name in names], 0.0, color=style.GREEN, marker="o")
    panels[2].set_xlabel("Errors put in\nthat are named (%)")
    panels[2].set_xlim(0.0, 102.0)
    panels[0].set_yticks(range(len(names)), names)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure


def _points(panel: Axes, shares: list[Mapping[str, Any]], shift: float, **look: Any) -> None:
    rows = [k for k, share in enumerate(shares) if share["of"]]
    at = [100.0 * shares[k]["count"] / shares[k]["of"] for k in rows]
    around = [
        [x - 100.0 * shares[k]["low"] for x, k in zip(at, rows, strict=True)],
        [100.0 * shares[k]["high"] - x for x, k in zip(at, rows, strict=True)],
    ]
    panel.errorbar(at, [k + shift for k in rows], xerr=around, ls="none", ms=3.5, lw=0.8, clip_on=False, **look)
