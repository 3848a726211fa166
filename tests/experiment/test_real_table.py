"""The table of real flights: its cases, an answer from logs to JSON, and what is written of answers."""

import json
from pathlib import Path

import fast_flyer
import numpy as np
import pandas as pd
import pytest
import yaml

from infotraj.checking.codes import known
from infotraj.comparing.equation_error import AXES
from infotraj.effects.registry import catalogue
from infotraj.errors import InputError, UsageError
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.real.answering import answer_case
from infotraj.experiment.real.cases import RealCases, cut_case, flight_path, missing, read_cases
from infotraj.experiment.real.table import judged, right, write_real_table
from infotraj.flight import Flight, read_flight
from infotraj.models import load_model

CONFIG = Path(__file__).parents[2] / "config"
QUADROTOR = "vehicles/quadrotor.yaml"


def cases(folder: Path, **changes) -> Path:
    """A file with one case of two logs to fit and one held out."""
    case = {
        "name": "quad", "folder": "set", "mapping": "flight_table", "model": QUADROTOR, "fit": ["a.csv", "b.csv"],
        "held": [{"file": "c.csv", "from": 1.0, "to": 5.0}], "known": "drag", "must": [["linear_drag"]],
    }  # fmt: skip
    path = folder / "cases.yaml"
    path.write_text(yaml.safe_dump({"cases": [case | changes]}))
    return path


def effect(name, verdict, group=(), **more):
    return {
        "name": name, "verdict": verdict, "group": list(group) or [name], "heldout_change": -0.5, "ci95": [-0.6, -0.4],
        "parameters": {"d": [0.5, 0.25]}, "standard_errors": {"d": [0.01, 0.02]}, "reason": None, **more,
    }  # fmt: skip


def answer(effects, before=0.4, after=0.1, change=-0.9, error=0.1, **more):
    same = dict.fromkeys(AXES, 0.05)
    models = [{"rmse": same | {"fx": v}, "floor": same} for v in (before, after)]
    against = {"relative_change": dict.fromkeys(AXES, 0.0), "standard_error": dict.fromkeys(AXES, 0.1)}
    against["relative_change"]["fx"], against["standard_error"]["fx"] = change, error
    models[1]["against_first"] = against
    axes = {a: {"judged": a != "tz", "reason": "all effects explain 32 %", "coherence": 0.1} for a in AXES}
    return {
        "case": "quad", "seconds": 4.25, "rejected": [],
        "answer": {"effects": effects, "axes": axes, "unexplained": [{"axis": "vx"}], **more},
        "held_out": {"models": models, "floor": same, "flights": [{}]},
    }  # fmt: skip


def written(folder, result, **changes):
    """The table's text and rows for one answer."""
    path = folder / "answer.json"
    path.write_text(json.dumps(result))
    out = {"table": folder / "t.csv", "markdown": folder / "t.md"}
    write_real_table(cases=cases(folder, **changes), only=(), data_dir=folder, answers=[path], **out)
    return out["markdown"].read_text(), pd.read_csv(out["table"]).iloc[0]


def test_every_case_names_effects_codes_and_a_model_that_exist():
    for case in read_cases(Path(CONFIG).parent / ExperimentConfig().real_table.cases).cases:
        assert load_model(CONFIG / case.model).vehicle.mass > 0
        assert {*case.never, *(n for group in case.must for n in group)} <= set(catalogue()), case.name
        known(case.accept)
        for key in case.numbers:
            name, parameter = key.split(".")[:2]
            assert parameter in {p.name for p in catalogue()[name].parameters}, key
        assert case.must or case.never, case.name


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"fit": [{"file": "a", "from": 2, "to": 2}]}, "ends before it starts"),
        ({"fit": ["a.csv", "c.csv", "a.csv"]}, "a is used twice"),
        ({"never": ["linear_drag"]}, "linear_drag must and must never be found"),
        ({"windows": {}}, "windows"),
    ],
)
def test_a_case_that_contradicts_itself_is_refused(tmp_path, changes, why):
    with pytest.raises(UsageError, match=why):
        read_cases(cases(tmp_path, **changes))


def test_cases_are_chosen_by_pattern_and_by_name(tmp_path):
    case = yaml.safe_load(cases(tmp_path).read_text())["cases"][0]
    two = RealCases.model_validate({"cases": [case, case | {"name": "other"}]})
    assert [c.name for c in two.chosen(["oth*"])] == ["other"]
    assert len(two.chosen()) == 2
    with pytest.raises(UsageError, match="no case matches x"):
        two.chosen(["x"])
    with pytest.raises(UsageError, match="one of quad, other"):
        two.get("x")
    with pytest.raises(ValueError, match="two cases are called quad"):
        RealCases.model_validate({"cases": [case, case]})


def test_what_is_not_here_is_said_and_not_read(tmp_path, monkeypatch):
    monkeypatch.delenv("INFOTRAJ_DATA", raising=False)
    case = read_cases(cases(tmp_path)).get("quad")
    assert missing(case, tmp_path) == "data set set is not here: set INFOTRAJ_DATA to the folder that holds it"
    (tmp_path / "set").mkdir()
    (tmp_path / "set/a.csv").touch()
    assert missing(case, tmp_path) == "data set set holds no b.csv, c.csv"
    with pytest.raises(InputError, match=r"quad: data set set holds no b\.csv, c\.csv"):
        cut_case(case, tmp_path / "flights", tmp_path)
    write_real_table(
        cases=tmp_path / "cases.yaml", only=(), data_dir=tmp_path, answers=[], table=tmp_path / "t.csv",
        markdown=tmp_path / "t.md",
    )  # fmt: skip
    assert "- quad: data set set holds no b.csv, c.csv." in (tmp_path / "t.md").read_text()


@pytest.mark.long
def test_from_raw_logs_to_an_answer_that_predicts_flights_it_never_saw(tmp_path, monkeypatch):
    monkeypatch.setenv("INFOTRAJ_DATA", str(tmp_path))
    (tmp_path / "set").mkdir()
    for seed, name in enumerate("abc"):
        flown = fast_flyer.fly(CONFIG / QUADROTOR, 6.0, seed, {"linear_drag": 0.3})
        flown.to_csv(tmp_path / f"set/{name}.csv", index=False)
    still = pd.read_csv(tmp_path / "set/a.csv")
    still.loc[:, [c for c in still if c != "t"]] = still.iloc[0][[c for c in still if c != "t"]].to_numpy()
    still.to_csv(tmp_path / "set/still.csv", index=False)
    path = cases(tmp_path, fit=["a.csv", "b.csv", "still.csv"], accept=["low_flight"])
    flights = tmp_path / "flights"
    case = read_cases(path).get("quad")
    cut_case(case, flights)
    held = read_flight(flight_path(flights, case.held[0]))
    assert (held.t[0], held.t[-1]) == pytest.approx((1.0, 4.995))
    assert held.meta["accept"] == ["low_flight"]

    out = {"numbers": tmp_path / "n.json", "text": tmp_path / "n.txt", "model": tmp_path / "m.yaml"}
    answer_case(cases=path, name="quad", config=CONFIG, flights=flights, **out)
    result = json.loads(out["numbers"].read_text())
    assert [line.split(":")[0] for line in result["rejected"]] == ["still"]
    assert right(case, result["answer"]["effects"])
    assert result["seconds"] > 0
    assert "linear_drag" in [e.name for e in load_model(out["model"]).effects]
    assert "linear_drag" in out["text"].read_text()
    before, after = (m["rmse"]["fx"] for m in result["held_out"]["models"])
    assert after < 0.6 * before
    text, row = written(tmp_path, result, fit=["a.csv", "b.csv", "still.csv"])
    assert str(tmp_path) not in text
    assert row["as_known"].startswith("linear_drag found")
    assert row["fx_after"] == pytest.approx(after)
    assert "still: " in text


def test_flights_that_are_all_rejected_are_an_answer_with_its_reason(tmp_path):
    flights = tmp_path / "flights"
    path = cases(tmp_path, fit=["a.csv"], held=[])
    table = fast_flyer.fly(CONFIG / QUADROTOR, 3.0, 0)
    table.loc[:, [c for c in table if c != "t"]] = 0.0
    table["qw"] = 1.0
    Flight(table).write(flight_path(flights, read_cases(path).get("quad").fit[0]))
    out = {"numbers": tmp_path / "n.json", "text": tmp_path / "n.txt", "model": tmp_path / "m.yaml"}
    answer_case(cases=path, name="quad", config=CONFIG, flights=flights, **out)
    result = json.loads(out["numbers"].read_text())
    assert result["answer"] is None
    assert result["rejected"][-1] == "none of the flights can be used"
    assert load_model(out["model"]).vehicle == load_model(CONFIG / QUADROTOR).vehicle
    text, row = written(tmp_path, result, fit=["a.csv"], held=[])
    assert not row["right"]
    assert "| rejected: a: " in text
    assert "| linear_drag missed | - |" in text


def test_the_table_says_what_was_found_in_which_group_and_what_got_worse(tmp_path):
    found = [
        effect("thrust_scale", "Not separable", ["mass_offset", "thrust_scale"], probability=0.98),
        effect("mass_offset", "Not separable", ["mass_offset", "thrust_scale"]),
        effect("linear_drag", "Plausible", reason="its number changes"),
        effect("gyro_bias", "Not needed"),
    ]
    number = {"name": "rotor_0.thrust_coefficient", "declared": 4.2e-6, "value": 4.31e-6, "standard_error": 2e-8}
    result = answer(found, after=0.6, change=0.8, file=[number | {"ordinary": False}])
    text, row = written(tmp_path, result, must=[["mass_offset"], ["linear_drag"]], cannot="mass from thrust")
    assert row["supported"] == "mass_offset+thrust_scale"
    assert row["plausible"] == "linear_drag"
    assert not row["right"]
    assert "Supported: mass_offset or thrust_scale. Plausible: linear_drag" in text
    assert "mass_offset found, not told from thrust_scale; linear_drag Plausible only | 4 |" in text
    assert "| quad | **0.4, 0.6 (0.05)** | 0.05, 0.05 (0.05) |" in text
    assert "| linear_drag | Plausible | d 0.5 +- 0.01, 0.25 +- 0.02 | -0.5 [-0.6, -0.4] | its number changes |" in text
    assert "needed: 0.98" in text
    assert "gyro_bias" not in text
    assert "| quad | rotor_0.thrust_coefficient | 4.2e-06 | 4.31e-06 +- 2e-08 | no |" in text
    assert "| quad | mass from thrust | tz: all effects explain 32 % | vx |" in text
    better, _ = written(tmp_path, answer(found), must=[["mass_offset"]])
    assert "| quad | 0.4, 0.1 (0.05) |" in better


def test_a_name_that_would_be_wrong_is_held_against_the_answer(tmp_path):
    case = read_cases(cases(tmp_path, must=[], never=["suspended_load"])).get("quad")
    wrong = [effect("suspended_load", "Supported")]
    assert judged(case, wrong) == ["suspended_load wrongly named"]
    assert not right(case, wrong)
    hedged = [effect("suspended_load", "Plausible")]
    assert judged(case, hedged) == ["nothing wrong named"]
    assert right(case, hedged)


def test_known_numbers_stand_beside_those_that_were_found(tmp_path):
    case = read_cases(cases(tmp_path, numbers={"linear_drag.d.1": 0.2, "rotor_lag.extra_time_constant": 0.1})).get(
        "quad"
    )
    lag = {"parameters": {"extra_time_constant": 0.09}}
    found = [effect("linear_drag", "Supported"), effect("rotor_lag", "Plausible", **lag)]
    assert judged(case, found) == [
        "linear_drag found", "d 0.25 for 0.2 (+25%)", "extra_time_constant 0.09 for 0.1 (-10%)"
    ]  # fmt: skip
    assert judged(case, [effect("linear_drag", "Not needed")]) == ["linear_drag missed"]


def test_numbers_that_there_are_none_of_are_written_as_dashes(tmp_path):
    blind = answer([effect("linear_drag", "Supported", ci95=None, standard_errors={})])
    for model in blind["held_out"]["models"]:
        model["rmse"]["tx"] = model["floor"]["tx"] = None
    blind["held_out"]["models"][1]["against_first"]["relative_change"]["tx"] = None
    text, row = written(tmp_path, blind)
    assert "| 0.05, 0.05 (0.05) | - | 0.05, 0.05 (0.05) |" in text
    assert "| d 0.5, 0.25 | - |" in text
    assert np.isnan(row["tx_before"])
