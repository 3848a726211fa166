"""What users do today: each way on regressions with a known answer, and on a flight with a strong effect."""

import numpy as np
import pandas as pd
import pytest
from hidden_flights import OMAV, fly, truth

from infotraj.errors import InputError
from infotraj.experiment.baselines import Regression, lasso, methods, named_by_each, stepwise
from infotraj.experiment.baselines_scoring import name_flights, score


def made(strength, rows=1500, seed=0):
    rng = np.random.default_rng(seed)
    X = rng.standard_normal((rows, 12))
    X[:, 5] += 0.6 * X[:, 2]
    y = X @ np.where(np.isin(np.arange(12), (2, 7)), strength, 0.0) + rng.standard_normal(rows)
    return Regression(y, X, np.repeat(np.arange(3), rows // 3), tuple(f"effect {k}" for k in range(12)))


@pytest.mark.parametrize("way", [stepwise, lasso])
def test_a_way_keeps_the_columns_that_matter(way):
    kept = way(made(0.5))
    assert {2, 7} <= set(kept)
    assert len(kept) <= 4


@pytest.mark.parametrize("way", [stepwise, lasso])
def test_a_way_keeps_next_to_nothing_of_noise(way):
    assert len(way(made(0.0))) <= 1


def test_columns_that_copy_each_other_are_no_failure():
    data = made(0.5)
    twice = Regression(data.y, np.concatenate([data.X, data.X[:, 2:3]], axis=1), data.flight, (*data.names, "copy"))
    assert twice.effects(stepwise(twice)) & {"effect 2", "copy"}
    assert twice.effects(lasso(twice)) & {"effect 2", "copy"}


def test_every_way_finds_a_strong_effect(tmp_path):
    factor = (1.0,) * 5 + (0.7,) + (1.0,) * 6
    flights = fly(truth(rotors={"thrust_factor": factor}), flights=2, seconds=6.0)
    found = named_by_each(OMAV, flights)
    assert set(found) == set(methods())
    for named in found.values():
        assert "rotor_effectiveness 5" in named.effects
        assert 0.0 < named.seconds < 60.0
    paths = []
    for k, flight in enumerate(flights):
        paths.append(tmp_path / f"{k}.parquet")
        flight.write(paths[-1])
    name_flights(vehicle="config/vehicles/omav.yaml", case="weak", flights=paths, table=tmp_path / "weak.csv")
    read = pd.read_csv(tmp_path / "weak.csv").set_index("method")["effects"]
    assert {m: frozenset(e.split("+")) for m, e in read.items()} == {m: n.effects for m, n in found.items()}


def table(path, case, *effects):
    rows = [{"case": case, "method": m, "effects": e, "seconds": 2.0} for m, e in zip("ab", effects, strict=True)]
    pd.DataFrame(rows).to_csv(path, index=False)
    return path


def test_the_score_counts_found_and_invented(tmp_path):
    tables = [
        table(tmp_path / "1.csv", "pair", "drag+mass", "drag"),
        table(tmp_path / "2.csv", "nothing", "", "drag+mass"),
    ]
    (tmp_path / "truths.csv").write_text("case,effects\npair,drag+mass\nnothing,\n")
    score(tables=tables, truths=tmp_path / "truths.csv", table=tmp_path / "s.csv", markdown=tmp_path / "s.md")
    got = pd.read_csv(tmp_path / "s.csv").set_index("method")
    assert got.loc["a", ["runs", "found", "exact", "false_alarms", "invented"]].tolist() == [2, 1.0, 1.0, 0.0, 0.0]
    assert got.loc["b", ["runs", "found", "exact", "false_alarms", "invented"]].tolist() == [2, 0.5, 0.0, 0.5, 1.0]
    assert "| a | 2 | 100% | 100% | 0% |" in (tmp_path / "s.md").read_text()


def test_a_case_without_a_truth_is_refused(tmp_path):
    (tmp_path / "truths.csv").write_text("case,effects\nother,drag\n")
    one = table(tmp_path / "1.csv", "pair", "drag", "drag")
    with pytest.raises(InputError, match="no truth for pair"):
        score(tables=[one], truths=tmp_path / "truths.csv", table=tmp_path / "s.csv", markdown=tmp_path / "s.md")
