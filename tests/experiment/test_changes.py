"""The study of changes: its plan, what a day brings, how answers are scored, and its page."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from infotraj.errors import UsageError
from infotraj.experiment.changes.cases import Change, batches, changed_effects, changes, day, read_changes
from infotraj.experiment.changes.flying import fly_change
from infotraj.experiment.changes.scoring import judged, score_change, size_error
from infotraj.experiment.changes.table import summarise_changes
from infotraj.flight import read_flight
from infotraj.vehicle import load_vehicle

ROOT = Path(__file__).parents[2]
STUDY, HIDDEN = read_changes(ROOT / "config" / "studies" / "changes.yaml")
QUADROTOR = load_vehicle(ROOT / "config" / "vehicles" / "quadrotor.yaml")


def test_every_effect_that_can_be_hidden_alone_is_a_change_and_the_order_is_drawn():
    for vehicle, count in STUDY.cases.items():
        planned = changes(STUDY, HIDDEN, vehicle)
        assert planned == changes(STUDY, HIDDEN, vehicle)
        assert [c.number for c in planned] == list(range(count.single + count.several + count.nothing))
        alone = {n for n, e in HIDDEN.vehicles[vehicle].effects.items() if e.alone and e.voltage is None}
        assert {c.effects[0][0] for c in planned if c.kind == "single"} == alone
        assert len({c.kind for c in planned[: count.nothing]}) > 1
        for c in planned:
            assert all(1.0 <= size <= 2.0 for _, size in c.effects)
    assert sum(len(b) for b in batches(STUDY, HIDDEN).values()) == sum(
        len(changes(STUDY, HIDDEN, v)) for v in STUDY.cases
    )


def test_a_change_has_the_size_that_was_drawn():
    one = Change("quadrotor", "single", (("rotor_effectiveness", 2.0),), 3)
    ((name, values),) = changed_effects(one, HIDDEN, QUADROTOR)
    assert name == "rotor_effectiveness"
    # Usual is 0.85, and every number varies by up to 15 %.
    assert 2.0 * 0.85 * 0.15 <= 1.0 - values["factor"] <= 2.0 * 1.15 * 0.15


def test_what_a_day_brings_is_as_large_as_the_study_says():
    rng = np.random.default_rng(0)
    days = [dict((n, v) for n, v in day(STUDY.drift, QUADROTOR, rng) if "rotor" not in v) for _ in range(400)]
    common = [d["thrust_scale"]["factor"] for d in days]
    assert np.std(common) == pytest.approx(STUDY.drift.thrust, rel=0.15)
    reach = np.mean([np.linalg.norm(r.position) for r in QUADROTOR.rotors])
    assert np.std([d["com_offset"]["r"] for d in days]) == pytest.approx(STUDY.drift.trim * reach, rel=0.15)


def test_a_study_that_cannot_be_used_is_refused_in_one_line(tmp_path):
    content = yaml.safe_load((ROOT / "config" / "studies" / "changes.yaml").read_text())
    for key, value in (("cases", {"blimp": {"single": 1}}), ("file", "7%"), ("healthy", 0), ("sizes", [2, 1])):
        bad = tmp_path / "bad.yaml"
        bad.write_text(
            yaml.safe_dump({**content, "hidden": str(ROOT / "config/studies/hidden_effects.yaml"), key: value})
        )
        with pytest.raises(UsageError, match=r"bad\.yaml") as said:
            read_changes(bad)
        assert "\n" not in str(said.value)


def row(name, group=None, **parameters):
    return {name: {"name": name, "group": group or [name], "parameters": parameters, "verdict": "Supported"}}


def effect(name, **parameters):
    return {"name": name, "parameters": parameters}


def test_a_change_is_found_by_its_name_its_rotor_or_a_group_that_holds_it():
    rotor = effect("rotor_effectiveness", rotor=2, factor=0.8)
    right = judged([rotor], [["rotor_effectiveness"]], row("rotor_effectiveness", rotor=2, factor=0.8))
    assert (right["found"], right["wrong"]) == (["rotor_effectiveness"], [])
    other = judged([rotor], [["rotor_effectiveness"]], row("rotor_effectiveness", rotor=1, factor=0.8))
    assert (other["found"], other["wrong"]) == ([], ["rotor_effectiveness"])
    group = ["thrust_scale", "mass_offset"]
    held = judged([effect("mass_offset", dm=0.1)], [group], row("thrust_scale", group) | row("mass_offset", group))
    assert (held["found"], held["wrong"]) == (["mass_offset"], [])
    large = [*group, "battery_sag", "coaxial_loss", "axial_inflow"]
    assert judged([effect("mass_offset", dm=0.1)], [large], row("mass_offset", large))["found"] == []
    assert judged([], [["wind"]], row("wind"))["wrong"] == ["wind"]


def test_the_size_of_a_change_is_that_from_the_healthy_number():
    usual = {"parameters": {"factor": 0.9}}
    said = row("rotor_effectiveness", rotor=2, factor=0.72)["rotor_effectiveness"] | {"reference": usual}
    assert size_error(effect("rotor_effectiveness", rotor=2, factor=0.8), said, QUADROTOR) == pytest.approx(
        0.0, abs=1e-9
    )
    moved = row("com_offset", r=[0.005, 0.0, 0.0])["com_offset"] | {
        "reference": {"parameters": {"r": [0.001, 0.0, 0.0]}}
    }
    assert size_error(effect("com_offset", r=[0.005, 0.0, 0.0]), moved, QUADROTOR) == pytest.approx(0.2)


def test_the_page_counts_what_was_found_and_what_was_wrong(tmp_path):
    def case(number, kind, effects, **ways):
        said = {w: {"answered": True, "refusal": "", "cpu": 1.0, **a} for w, a in ways.items()}
        about = {"name": f"quadrotor/{kind}/x", "vehicle": "quadrotor", "kind": kind, "number": number, "failed": ""}
        return about | {"effects": effects, "sizes": [1.0] * len(effects), "ways": said}

    nothing = {"found": [], "wrong": [], "groups": []}
    drag = {"found": ["linear_drag"], "wrong": [], "groups": [["linear_drag"]]}
    false = {"found": [], "wrong": ["wind"], "groups": [["wind"]]}
    scores = [
        case(0, "single", [effect("linear_drag", d=[1, 1, 1])], **{"with": drag, "without": nothing}),
        case(1, "nothing", [], **{"with": nothing, "without": false}),
    ]
    (tmp_path / "scores.json").write_text(json.dumps(scores))
    summarise_changes([tmp_path / "scores.json"], 9, tmp_path / "t.csv", tmp_path / "t.md")
    text = (tmp_path / "t.md").read_text()
    assert "2 of 9 planned cases" in text
    lines = [line for line in text.splitlines() if line.startswith("| quadrotor |")]
    assert "1 of 1: 100 %" in lines[0]
    assert "0 of 1: 0 %" in lines[1]
    assert "**wrong: wind**" in text


@pytest.mark.long
def test_a_case_is_flown_to_two_folders_and_a_refusal_finds_nothing(tmp_path):
    flights = HIDDEN.vehicles["quadrotor"].flights.model_copy(update={"seconds": 2.0, "train": ("eight",)})
    vehicle = HIDDEN.vehicles["quadrotor"].model_copy(
        update={"flights": flights, "file": str(ROOT / "config/vehicles/quadrotor.yaml")}
    )
    hidden = HIDDEN.model_copy(update={"vehicles": {"quadrotor": vehicle}})
    study = STUDY.model_copy(update={"healthy": 2})
    one = Change("quadrotor", "single", (("thrust_scale", 1.0),), 0)
    shown, kept, answer = (tmp_path / k for k in ("shown", "kept", "answer"))
    fly_change(study, hidden, one, shown, kept)
    assert sorted(p.name for p in shown.iterdir()) == [
        "healthy_0.parquet",
        "healthy_1.parquet",
        "now_0.parquet",
        "vehicle.yaml",
    ]
    assert "cmd_fz" not in read_flight(shown / "now_0.parquet").table
    written = load_vehicle(shown / "vehicle.yaml")
    off = [a.thrust_coefficient / b.thrust_coefficient for a, b in zip(written.rotors, QUADROTOR.rotors, strict=True)]
    assert max(abs(np.log(off))) > 0.02
    # A drop of all thrusts by 8 % asks for faster rotors than any healthy day.
    commands = [
        np.mean([read_flight(shown / f"{n}.parquet").get(f"cmd_rotor_{k}").mean() for k in range(4)])
        for n in ("now_0", "healthy_0", "healthy_1")
    ]
    assert commands[0] > max(commands[1:])
    for way in ("with", "without"):
        (answer / way).mkdir(parents=True)
        (answer / way / "time.json").write_text(json.dumps({"cpu": 1.0, "error": "refused"}))
    score = score_change(shown, answer, kept)
    assert score["effects"][0]["name"] == "thrust_scale"
    assert score["ways"]["with"]["found"] == []
