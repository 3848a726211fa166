"""Figures and tables: files are written and repeatable, a figure draws what its table holds, bad tables are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure

from infotraj import rotations
from infotraj.errors import InputError
from infotraj.plots import (
    claims,
    correlation,
    cost,
    learning_curve,
    phase,
    pool,
    sphere,
    style,
    table_1,
    typeset,
    waterfall,
)

PLANTS = ("omav_a", "omav_b", "omav_c")


def correlation_table(seeds: int = 4, candidates: int = 12, plants: tuple = PLANTS) -> pd.DataFrame:
    rng = np.random.default_rng(0)
    rows = []
    for plant in plants:
        for seed in range(seeds):
            level = rng.uniform(0.8, 1.2)
            for candidate in range(-1, candidates):
                value = level * rng.uniform(20.0, 60.0)
                error = 0.3 + 0.01 * value / level + rng.normal(0, 0.05)
                rows.append((plant, seed, candidate, value, error, 0.4 * error))
    return pd.DataFrame(rows, columns=correlation.COLUMNS)


def learning_table(seeds: int = 5, plants: tuple = PLANTS) -> pd.DataFrame:
    rng = np.random.default_rng(1)
    rows = []
    for plant in plants:
        for seed in range(seeds):
            rows.append((plant, seed, "prior", 20, rng.normal(2.0, 0.1), 1.5))
            for points in (40, 60, 80, 100):
                task = rng.normal(1.4 - 0.004 * points, 0.08)
                rows.append((plant, seed, "task", points, task, 0.7 * task))
                rows.append((plant, seed, "informative", points, task * rng.normal(0.8, 0.05), 0.5 * task))
    return pd.DataFrame(rows, columns=learning_curve.COLUMNS)


def reduction_table(seeds: int = 5, plants: tuple = PLANTS) -> pd.DataFrame:
    rng = np.random.default_rng(2)
    means = {"task": (38, 42, 23), "informative": (45, 58, 63)}
    rows = [
        (plant, seed, source, axis, rng.normal(mean, 5))
        for plant in plants
        for seed in range(seeds)
        for source, by_axis in means.items()
        for axis, mean in zip("xyz", by_axis, strict=True)
    ]
    return pd.DataFrame(rows, columns=table_1.COLUMNS)


def cost_table(candidates: int = 20) -> pd.DataFrame:
    rng = np.random.default_rng(3)
    table = pd.DataFrame({"candidate": range(-1, candidates), "cost": rng.uniform(20, 60, candidates + 1)})
    table["chosen"] = table["cost"] == table["cost"].min()
    return table.assign(cost_std=rng.uniform(1, 4, candidates + 1))


def pool_table(tasks: int = 10, candidates: int = 19) -> pd.DataFrame:
    rng = np.random.default_rng(4)
    rows = []
    for task in range(tasks):
        costs = rng.uniform(20, 60, candidates)
        for candidate, value in enumerate(costs):
            error = 0.1 + 0.002 * value + rng.normal(0, 0.015)
            rows.append((f"B{task}_trefoil_fast_rep1", f"flight_{candidate}", value, error, int(value == costs.min())))
    return pd.DataFrame(rows, columns=pool.COLUMNS)


def phase_table(amplitude: float) -> pd.DataFrame:
    phase_angle = np.linspace(0, 4 * np.pi, 800)
    roll, pitch = amplitude * np.sin(phase_angle / 2), amplitude * np.sin(phase_angle)
    return pd.DataFrame({"roll": roll, "pitch": pitch, "tx": -0.004 * roll, "ty": -0.012 * pitch + 0.02 * roll / 26})


def attitudes(lag: float = 0.0, noise: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(5)
    phase_angle = np.linspace(0, 2 * np.pi, 400) - lag
    bend = np.radians(26)
    q = rotations.from_euler(bend * np.sin(phase_angle), bend * np.sin(2 * phase_angle), 0 * phase_angle)
    wobble = np.cumsum(rng.normal(0, noise, (400, 3)), axis=0)
    return rotations.multiply(q, rotations.exp(wobble - wobble.mean(axis=0)))


CLAIMS = pd.DataFrame(
    [
        ("average gain of the informative flight, four data sizes [%]", 13.3, 24.71, 18.2, 31.0, "yes"),
        ("rank correlation of cost and error, median over seeds", "clear", 0.41, 0.2, 0.55, "no"),
    ],
    columns=claims.COLUMNS,
)

FIGURES: dict[str, Callable[[Path, Path], None]] = {
    "figure_2": lambda a, b: correlation.figure_2(correlation_table(2, 6, PLANTS[:1]), a, b),
    "figure_3": lambda a, b: sphere.figure_3(
        attitudes(), {"informative": attitudes(0.1, 2e-3), "task": attitudes(0.2, 4e-3)}, a, b
    ),
    "figure_4": lambda a, b: learning_curve.figure_4(learning_table(3, PLANTS[:1]), a, b),
    "figure_5": lambda a, b: phase.figure_5(phase_table(26), phase_table(43), a, b),
    "costs": lambda a, b: cost.figure_costs(cost_table(), a, b),
    "pool": lambda a, b: pool.figure_pool(pool_table(tasks=2), a, b),
    "table_1": lambda a, b: table_1.table_1(reduction_table(2, PLANTS[:2]), csv=a.with_suffix(".csv"), tex=a, png=b),
    "claims": lambda a, b: claims.claims_table(CLAIMS, a, b),
}


@pytest.mark.parametrize("name", FIGURES)
def test_files_are_written_and_repeatable(name: str, tmp_path: Path) -> None:
    written = []
    for run in ("first", "second"):
        paths = tmp_path / run / "f.pdf", tmp_path / run / "f.png"
        FIGURES[name](*paths)
        assert paths[1].read_bytes().startswith(b"\x89PNG")
        written.append([p.read_bytes() for p in sorted((tmp_path / run).iterdir())])
    assert written[0] == written[1]
    assert all(len(content) > 200 for content in written[0])


@pytest.mark.parametrize(
    ("call", "column"),
    [
        (lambda t, a, b: correlation.figure_2(correlation_table().drop(columns="cost"), a, b), "cost"),
        (lambda t, a, b: learning_curve.figure_4(learning_table().drop(columns="source"), a, b), "source"),
        (lambda t, a, b: phase.figure_5(phase_table(26), phase_table(43).drop(columns="ty"), a, b), "ty"),
        (lambda t, a, b: cost.figure_costs(cost_table().drop(columns="chosen"), a, b), "chosen"),
        (lambda t, a, b: pool.figure_pool(pool_table(2).drop(columns="error"), a, b), "error"),
        (lambda t, a, b: table_1.table_1(reduction_table().drop(columns="axis"), tex=a, png=b), "axis"),
        (lambda t, a, b: claims.claims_table(CLAIMS.drop(columns="low"), a, b), "low"),
    ],
)
def test_a_missing_column_is_one_clear_line(call: Callable, column: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=rf"no column {column}; expected .*\.$") as raised:
        call(None, tmp_path / "f.pdf", tmp_path / "f.png")
    assert "\n" not in str(raised.value)
    assert list(tmp_path.iterdir()) == []


def test_no_rows_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no rows"):
        correlation.figure_2(correlation_table().iloc[:0], tmp_path / "f.pdf", tmp_path / "f.png")


def test_attitudes_of_another_shape_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"task has shape \(400, 3\)"):
        sphere.figure_3(attitudes(), {"task": attitudes()[:, :3]}, tmp_path / "f.pdf", tmp_path / "f.png")


def scattered(axes: Axes) -> int:
    return sum(len(np.asarray(c.get_offsets())) for c in axes.collections if isinstance(c, PathCollection))


def dots(axes: Axes) -> list[float]:
    return [y for line in axes.lines if line.get_marker() == "." for y in np.asarray(line.get_ydata())]


def panels(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_visible()]


def test_figure_2_draws_every_flight() -> None:
    table = correlation_table(seeds=4, candidates=12)
    drawn = panels(correlation.draw_figure_2(table))
    assert len(drawn) == 3
    assert [scattered(a) for a in drawn] == [4 * 13] * 3


def test_figure_2_has_a_row_of_panels_for_the_papers_cost_where_it_is_there() -> None:
    table = correlation_table(seeds=4, candidates=12)
    drawn = panels(correlation.draw_figure_2(table.assign(cost_paper=-table["cost"])))
    assert [scattered(a) for a in drawn] == [4 * 13] * 6
    medians = [float(a.get_title().split("median ")[1].split(",")[0]) for a in drawn]
    assert medians[3:] == [-m for m in medians[:3]]
    assert drawn[3].get_xlabel().startswith("the paper's cost")


def test_figure_2_of_one_seed_shows_the_spread_as_the_paper_does() -> None:
    table = correlation_table(seeds=1, candidates=5, plants=("omav_a",))
    (axes,) = panels(correlation.draw_figure_2(table))
    bars = [segment for c in axes.collections if hasattr(c, "get_segments") for segment in c.get_segments()]
    lengths = sorted(np.ptp(bar[:, 1]) for bar in bars)
    np.testing.assert_allclose(lengths, sorted(2 * table["error_std"]), rtol=1e-9)


def test_rank_correlation_leaves_the_task_out() -> None:
    table = pd.DataFrame({"seed": 0, "candidate": [-1, 0, 1, 2], "cost": [0.0, 1, 2, 3], "error": [99.0, 1, 2, 3]})
    assert correlation.rank_correlations(table)[0] == pytest.approx(1.0)


def test_figure_4_draws_every_run_and_the_paired_gain() -> None:
    table = learning_table(seeds=5)
    drawn = np.array(panels(learning_curve.draw_figure_4(table))).reshape(3, 3)
    part = table[table["plant"] == "omav_b"]
    assert sorted(dots(drawn[0, 1])) == pytest.approx(sorted(part["error"]))
    assert sorted(dots(drawn[1, 1])) == pytest.approx(sorted(part["error_std"]))
    wide = part.pivot_table(index=["seed", "points"], columns="source", values="error").dropna(
        subset=["task", "informative"]
    )
    expected = 100 * (1 - wide["informative"] / wide["task"])
    assert sorted(dots(drawn[2, 1])) == pytest.approx(sorted(expected))


def test_figure_4_shows_the_controls_and_the_gain_over_chance() -> None:
    table = learning_table(seeds=5)
    chance = table[table["source"] == "task"].assign(source="random", error=lambda rows: 0.9 * rows["error"])
    drawn = np.array(panels(learning_curve.draw_figure_4(pd.concat([table, chance])))).reshape(3, 3)
    assert "over random" in drawn[2, 0].get_title()
    both = [learning_curve.paired_gains(pd.concat([table, chance]), over=o) for o in ("task", "random")]
    part = pd.concat(both)
    assert sorted(dots(drawn[2, 0])) == pytest.approx(sorted(part.loc[part["plant"] == "omav_a", "gain"]))


def test_an_unknown_source_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="source other; expected none, prior, task, random, paper, informative"):
        learning_curve.figure_4(learning_table(2).assign(source="other"), tmp_path / "f.pdf", tmp_path / "f.png")


def test_gain_pairs_the_same_seed_only() -> None:
    table = learning_table(seeds=2, plants=("omav_a",))
    alone = table.drop(table[(table["source"] == "task") & (table["seed"] == 1)].index)
    assert set(learning_curve.paired_gains(alone)["seed"]) == {0}


def test_figure_5_has_the_papers_axes() -> None:
    left, right = panels(phase.draw_figure_5(phase_table(26), phase_table(43)))
    assert (left.get_xlabel(), left.get_ylabel()) == ("torque about x [N m]", "roll angle [deg]")
    assert (right.get_xlabel(), right.get_ylabel()) == ("torque about y [N m]", "pitch angle [deg]")
    assert max(np.max(line.get_ydata()) for line in right.lines) == pytest.approx(43, abs=0.01)


def test_unrolled_sphere_keeps_distances_from_the_middle() -> None:
    tips = sphere.tips(attitudes())
    middle = rotations.normalize(tips.mean(axis=0))
    flat = sphere.unrolled(tips, middle)
    np.testing.assert_allclose(np.linalg.norm(flat, axis=1), np.arccos(tips @ middle), atol=1e-9)
    np.testing.assert_allclose(sphere.unrolled(middle[None], middle), 0.0, atol=1e-12)


def test_costs_are_sorted_and_the_chosen_is_the_lowest() -> None:
    table = cost_table()
    (axes,) = panels(cost.draw_figure_costs(table))
    assert scattered(axes) == len(table)
    handles, labels = axes.get_legend_handles_labels()
    (chosen,) = (h for h, label in zip(handles, labels, strict=True) if label == "chosen")
    assert isinstance(chosen, PathCollection)
    assert tuple(np.asarray(chosen.get_offsets())[0]) == (0.0, pytest.approx(table["cost"].min()))


def test_pool_draws_every_candidate_of_every_task() -> None:
    table = pool_table(tasks=4, candidates=19)
    drawn = panels(pool.draw_figure_pool(table))
    assert [scattered(a) for a in drawn[:4]] == [19] * 4
    best = sorted(table.groupby("task")["error"].min())
    bars = next(line for line in drawn[4].lines if line.get_label() == "best candidate")
    assert sorted(np.asarray(bars.get_xdata())) == pytest.approx(best)


def test_table_1_pairs_the_seeds_and_keeps_the_papers_numbers() -> None:
    summary = table_1.summarised(reduction_table()).set_index(["source", "plant", "axis"])
    rows = reduction_table().pivot_table(index=["plant", "seed"], columns=["axis", "source"], values="reduction")
    paired = rows[("z", "informative")] - rows[("z", "task")]
    found = summary.loc[("over_task", "all", "z")]
    assert found["mean"] == pytest.approx(paired.mean())
    assert found["low"] < found["mean"] < found["high"]
    assert summary.loc[("informative", "omav_a", "y"), "paper"] == 57.9
    assert summary.loc[("task", "omav_a", "x"), "runs"] == 5


def test_table_1_compares_with_chance_where_chance_flew() -> None:
    table = reduction_table()
    chance = table[table["source"] == "task"].assign(source="random", reduction=lambda rows: rows["reduction"] - 1.0)
    summary = table_1.summarised(pd.concat([table, chance])).set_index(["source", "plant", "axis"])
    over = summary["mean"].loc[["over_random", "over_task"], "all", "x"]
    assert over["over_random"].item() == pytest.approx(over["over_task"].item() + 1.0)
    assert pd.isna(summary.loc[("random", "all", "x"), "paper"])


def test_table_1_as_text(tmp_path: Path) -> None:
    table_1.table_1(reduction_table(), markdown=tmp_path / "t.md", tex=tmp_path / "t.tex")
    lines = (tmp_path / "t.md").read_text().splitlines()
    assert "| non-informative | the paper | 38.4 | 41.7 | 23.0 |" in lines
    assert len({line.count("|") for line in lines}) == 1
    assert r"x-axis [\%]" in (tmp_path / "t.tex").read_text()


def test_claims_say_yes_and_no(tmp_path: Path) -> None:
    claims.claims_table(CLAIMS, tmp_path / "c.md")
    lines = (tmp_path / "c.md").read_text().splitlines()
    assert lines[2].endswith("| 13.3 | 24.7 | [18.2, 31] | yes |")
    assert lines[3].endswith("| clear | 0.41 | [0.2, 0.55] | no |")


def test_claims_that_are_neither_of_the_three_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds is 'perhaps'"):
        claims.claims_table(CLAIMS.assign(holds="perhaps"), tmp_path / "c.md")


def test_text_stays_in_its_column() -> None:
    figure = typeset.draw(("a", "b"), [("a long sentence that needs more than one line", "1")], (1.0, 0.5))
    assert any("\n" in text.get_text() for text in figure.axes[0].texts)


def test_the_waterfall_gives_all_axes_of_a_quantity_one_unit(tmp_path):
    assert style.prefixed("N", 26.0) == (1.0, "N")
    assert style.prefixed("N", 0.026) == (1e3, "mN")
    assert style.prefixed("N m", 4.3e-4) == (1e6, "\N{MICRO SIGN}N m")
    assert style.prefixed("N m", 0.0)[0] == 1e6
    assert style.prefixed("m/s^2", 0.03) == (1.0, "m/s$^2$")
    rmse = np.array([[6e-3, 2e-3, np.nan, 4e-4, 2e-5, 1e-5], [2e-3, 1e-3, np.nan, 1e-4, 1e-5, 1e-5]])
    given = (["as given", "+ linear drag"], ("fx", "fy", "fz", "tx", "ty", "tz"), rmse, 0.9 * rmse, 1.2 * rmse)
    units = {"force": "N", "torque": "N m"}
    with mpl.rc_context(style.RC):
        figure = waterfall._drawn(*given, 0.1 * rmse[0], units, {"tx"})
    panels = [panel for panel in figure.axes if panel.get_visible()]
    assert [panel.get_title() for panel in panels] == [
        "force x", "force y", "torque x, not judged", "torque y", "torque z",
    ]  # fmt: skip
    assert [panel.get_xlabel() for panel in panels[2:]] == ["held-out RMSE [\N{MICRO SIGN}N m]"] * 3
    assert [bar.get_width() for bar in panels[0].containers[0]] == pytest.approx([6.0, 2.0])
    assert [text.get_text().split(",")[0] for text in figure.legends[0].get_texts()] == [
        "95 % interval",
        "noise floor",
    ]
    waterfall.waterfall(*given, 0.1 * rmse[0], units, tmp_path / "w.png", refused={"tx"})
    assert (tmp_path / "w.png").stat().st_size > 5000
