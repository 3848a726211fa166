from dataclasses import replace

import numpy as np
import pytest

from infotraj.checking import Check, Finding, Loaded, check, examine
from infotraj.errors import InputError, UsageError
from infotraj.experiment.common.config import CheckCorpus
from infotraj.experiment.corpus import judging as corpus_judging
from infotraj.experiment.corpus.injected_errors import INJECTED
from infotraj.experiment.corpus.judging import judge, segments
from infotraj.experiment.corpus.measuring import summary, tables, write
from infotraj.experiment.corpus.real import read_sources, real_recipes
from infotraj.experiment.corpus.recipes import ExactRecipe, KinematicRecipe, Log, Right, injected, simulated_recipes
from infotraj.experiment.rough import PROFILES
from infotraj.flight import Flight
from infotraj.plots.check_corpus import errors_of_check

LOG = ExactRecipe(3, 2, "autopilot").make()


def finding(code="gaps", severity="warning", start=None, **values):
    spans = () if start is None else ((start, start + 1.0),)
    return Finding(code, severity, "what", "effect", "remedy", spans=spans, values=values)


class Recipe:
    source, moving = "made", True

    def __init__(self, log=None):
        self.log = log

    def make(self):
        if self.log is None:
            raise InputError("no such log")
        return self.log


def test_every_simulated_source_is_made_and_takes_its_numbers_from_the_seed():
    recipes = simulated_recipes(0, 2)
    assert {"exact", "kinematic", "mujoco omav", "mujoco omav, autopilot", *PROFILES} == {r.source for r in recipes}
    one, again, other = (ExactRecipe(seed, 1, "nanodrone").make().flight.table for seed in (0, 0, 1))
    assert one.equals(again)
    assert not one.equals(other)


def test_errors_are_put_in_where_they_can_be_seen():
    names = {name for name, _ in injected(LOG, 0)}
    assert names == set(INJECTED)
    poses = replace(
        LOG, loaded=Loaded(PROFILES["motion_capture"].log(LOG.flight, LOG.vehicle, np.random.default_rng(0)))
    )
    few = {name for name, _ in injected(poses, 0)}
    assert "time in milliseconds" in few
    assert not any("velocity" in name or "acceleration" in name for name in few)
    assert "rotor speeds signed" not in {name for name, _ in injected(replace(LOG, vehicle=None), 0)}


@pytest.mark.parametrize("name", INJECTED)
def test_an_error_changes_the_log_and_keeps_it_a_flight_table(name):
    spoiled = dict(injected(LOG, 0))[name].flight
    assert len(spoiled.table) == len(LOG.flight.table)
    assert not spoiled.table.equals(LOG.flight.table)


def test_what_is_right_is_no_false_finding():
    assert Right("gap*").covers(finding("gaps"))
    assert not Right("gap*").covers(finding("spikes"))
    assert Right("*", start=31.0).covers(finding(start=30.9))
    assert not Right("*", start=31.0).covers(finding(start=12.0))
    assert Right("*_clock_offset", lag=(0.0, 0.01)).covers(finding("imu_clock_offset", lag=0.008))
    assert not Right("*_clock_offset", lag=(0.0, 0.01)).covers(finding("imu_clock_offset", lag=-0.05))


def test_segments_are_of_ten_seconds_and_in_the_air():
    pieces = list(segments(LOG.loaded))
    assert len(pieces) >= 2
    for piece in pieces:
        assert piece.flight.t[-1] - piece.flight.t[0] == pytest.approx(10.0, abs=0.05)
        assert np.median(piece.flight.get("pz")) > 0.3


def test_a_flight_that_stays_at_its_height_is_cut_into_segments_too():
    table = LOG.flight.between(6.0, 30.0).table
    hovering = Loaded(Flight(table.assign(pz=1.0 + 0.01 * table["px"])))
    assert len(list(segments(hovering))) == 2


def test_a_crash_of_check_counts_as_a_false_rejection(monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("of course")

    monkeypatch.setattr(corpus_judging, "examine", broken)
    (row, *_) = judge(Recipe(LOG), 0, spoil=False)
    assert [(f["code"], f["severity"]) for f in row["false"]] == [("crashed", "reject")]
    assert "of course" in row["false"][0]["what"]


def test_verdicts_are_counted_by_source_and_kind(tmp_path):
    flight = KinematicRecipe(0, 1).make().flight.between(0.0, 12.0)
    spoiled = dict(injected(Log("made", "one", "clean", Loaded(flight)), 0))["rates in deg/s"]
    rows = judge(Recipe(spoiled), 0, spoil=False) + judge(
        Recipe(Log("made", "good", "rough", Loaded(flight))), 0, False
    )
    rows += judge(Recipe(), 0, spoil=True)
    for found in (True, True, False):
        rows.append({"source": "made", "kind": "rough", "log": "x", "part": "injected", "error": "e", "found": found,
                     "said": []})  # fmt: skip
    result = {"base_seed": 0, "absent": [], **summary(rows), "rows": rows}
    made = result["sources"]["made"]
    assert (made["whole"]["rejections"]["count"], made["whole"]["rejections"]["of"]) == (1, 2)
    assert (made["found"]["count"], made["found"]["of"]) == (2, 3)
    assert result["sources"]["all clean"]["whole"]["rejections"]["count"] == 1
    assert result["sources"]["all rough"]["whole"]["rejections"]["count"] == 0
    assert "rate_unit" in result["false_findings"]["made"]
    assert result["unreadable"][0]["why"] == "no such log"
    assert result["errors"]["e"]["rough"]["count"] == 2
    text = tables(result)
    assert "| made | 2 | 1: 50 %" in text
    assert "Not imported: 1 of made (no such log)." in text
    write(result, tmp_path / "numbers.json", tmp_path / "table.md", tmp_path / "errors.png")
    assert (tmp_path / "table.md").read_text() == text
    assert (tmp_path / "errors.png").stat().st_size > 5000


def test_a_figure_of_nothing_is_refused(tmp_path):
    with pytest.raises(InputError, match="no sources"):
        errors_of_check({}, tmp_path / "errors.png")


def test_the_file_of_real_sources_is_strict(tmp_path):
    path = tmp_path / "sources.yaml"
    path.write_text("sources:\n- {name: a, folder: a, files: '*', spiol: 3}\n")
    with pytest.raises(UsageError, match="spiol"):
        read_sources(path)
    with pytest.raises(UsageError, match="cannot be read"):
        read_sources(tmp_path / "none.yaml")


def test_real_logs_are_found_once_each_and_an_absent_data_set_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("INFOTRAJ_DATA", str(tmp_path))
    (tmp_path / "arpl_crazyflie").mkdir()
    for name, content in (("log10", "a"), ("log15", "b"), ("log16", "b")):
        (tmp_path / "arpl_crazyflie" / name).write_text(content)
    recipes, absent = real_recipes(CheckCorpus().real)
    assert [r.path.name for r in recipes] == ["log10", "log15"]
    assert "nanobench" in absent
    assert judge(recipes[0], 0, spoil=True)[0]["part"] == "unreadable"


@pytest.mark.parametrize("profile", ["", *PROFILES])
def test_check_rejects_and_cuts_no_log_for_being_logged_roughly(profile):
    log = ExactRecipe(2, 2, profile).make()
    piece = next(iter(segments(log.loaded)))
    wrong = [f for f in check(piece.flight, log.vehicle) if f.severity in ("reject", "cut")]
    assert wrong == []


@pytest.mark.parametrize(
    "name", ["rates in deg/s", "velocity in the body frame", "acceleration in g", "IMU 60 ms late"]
)
def test_check_names_errors_in_an_autopilots_log(name):
    spoiled = dict(injected(LOG, 0))[name]
    assert INJECTED[name].found(examine(spoiled.loaded, spoiled.vehicle), spoiled.spoiled)


def test_an_error_of_one_column_is_found_where_that_column_alone_is_named():
    error = INJECTED["one rotor's sensor dead"]
    assert dict(injected(LOG, 0))["one rotor's sensor dead"].spoiled in {(f"rotor_{k}",) for k in range(6)}
    for channels, right in ((("rotor_2",), True), (("rotor_1",), False), (("rotor_1", "rotor_2"), False)):
        said = [Finding("dead_column", "warning", "what", "effect", "remedy", channels=channels)]
        assert error.found(Check("log", 1, 0.0, 1.0, 1.0, 1.0, "", said, []), ("rotor_2",)) is right
