"""The closed loop over all seeds: tracking error by controller, and what a right or wrong name takes off it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.evaluation.intervals import bootstrap_mean
from infotraj.experiment.common.tables import write_table
from infotraj.rotations import Array

RESAMPLES = 10_000
_SEED = 20261001
UNITS = {"rotors": ("mm", 1e3), "position": ("mm", 1e3), "attitude": ("deg", float(np.degrees(1.0)))}


def summarise(*, tables: Sequence[str | Path], runs: str | Path, table: str | Path, markdown: str | Path) -> None:
    """Writes all rows below each other, a row a case and controller with intervals, and the same as Markdown.

    `removed`: the share of what the effect's absence costs (nominal minus oracle, by the rotors' error) that the
    controller takes off, the mean of the paired differences over seeds divided by the mean cost, with its 95 %
    bootstrap interval over seeds. `lost`: flights that did not stay in the air; they count as the worst that flew.
    """
    from infotraj.plots import typeset  # late: matplotlib

    rows = pd.concat([pd.read_csv(path) for path in tables], ignore_index=True)
    write_table(rows, runs)
    out = [_summary(case, part) for case, part in rows.groupby("case", sort=False)]
    result = pd.concat(out, ignore_index=True)
    write_table(result, table)
    cells = []
    for _, r in result.iterrows():
        shown = [str(r["case"]), _label(r["controller"], r["points"]), f"{int(r['runs'])} ({int(r['lost'])})"]
        shown += [f"{r[k]:.1f} ({r[f'{k}_low']:.1f} to {r[f'{k}_high']:.1f})" for k in UNITS]
        shown.append(f"{r['removed']:.0%} ({r['removed_low']:.0%} to {r['removed_high']:.0%})")
        shown += [f"{r['force_left']:.3f}", f"{r['torque_left']:.3f}"]
        cells.append(shown)
    header = [
        "case", "controller", "flights (lost)", "rotors' place (mm)", "position (mm)", "attitude (deg)",
        "absence cost removed", "force left (m/s^2)", "torque left (rad/s^2)",
    ]  # fmt: skip
    Path(markdown).write_text(
        "Root mean squares over a flight, means over seeds with 95 % intervals. Left: of a held-out flight of the "
        "nominal controller.\n\n" + typeset.markdown(header, cells)
    )


def _summary(case: str, part: pd.DataFrame) -> pd.DataFrame:
    wide = part.pivot_table(index="seed", columns=["controller", "points"], values="rotors", dropna=False)
    nominal, oracle = wide[("nominal", 0)], wide[("oracle", 0)]
    rows = []
    for (controller, points), group in part.groupby(["controller", "points"], sort=False):
        row: dict[str, object] = {
            "case": case, "controller": controller, "points": points, "runs": len(group),
            "lost": int(group["rotors"].isna().sum()),
        }  # fmt: skip
        for name, (_, factor) in UNITS.items():
            values = factor * group[name].fillna(part[name].max()).to_numpy()
            found = bootstrap_mean(values)
            row |= {name: found.mean, f"{name}_low": found.low, f"{name}_high": found.high}
        own = wide[(controller, points)].fillna(part["rotors"].max())
        share, low, high = ratio_of_means((nominal - own).to_numpy(), (nominal - oracle).to_numpy())
        row |= {"removed": share, "removed_low": low, "removed_high": high}
        row |= {name: group[name].mean() for name in ("force_left", "torque_left")}
        rows.append(row)
    return pd.DataFrame(rows)


def ratio_of_means(numerator: Array, denominator: Array) -> tuple[float, float, float]:
    """mean(numerator) / mean(denominator), both (n,), paired, with the 95 % percentile bootstrap over pairs."""
    rng = np.random.default_rng(_SEED)
    drawn = rng.integers(len(numerator), size=(RESAMPLES, len(numerator)))
    ratios = numerator[drawn].mean(axis=1) / denominator[drawn].mean(axis=1)
    low, high = np.percentile(ratios, [2.5, 97.5])
    return float(numerator.mean() / denominator.mean()), float(low), float(high)


def _label(controller: str, points: int) -> str:
    words = {"gp": "Gaussian process alone", "both": "named effects and Gaussian process", "right": "named effects"}
    words |= {"nominal": "nominal model", "oracle": "true effects"}
    return words.get(controller, controller) + (f", {points} points" if points else "")
