"""The report: what the page says is what the diagnosis found, no peak is lost, and nothing in it can run."""

import json
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from infotraj.cli import cli
from infotraj.comparing.equation_error import EquationError
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.report.reasons import why
from infotraj.diagnosis.report.steps import HeldOut
from infotraj.diagnosis.report.summary import _effect
from infotraj.recording import read_back
from infotraj.report.again import FORM, read_content
from infotraj.report.bars import gains
from infotraj.report.combinations import Combinations, boxes
from infotraj.report.failing import _far_off, _reach, heat, leftover
from infotraj.report.figures import _places
from infotraj.report.flown import _covers
from infotraj.report.formats import minus
from infotraj.report.page import clauses, page
from infotraj.report.series import unpacked
from infotraj.report.traces import read_part

TOP = Path(__file__).parents[1]
AXES = ("fx", "fy", "fz", "tx", "ty", "tz")


def command(*words, cwd=None):
    return subprocess.run(
        [sys.executable, "-m", "infotraj.cli", "report", *map(str, words)], capture_output=True, text=True, cwd=cwd
    )


@pytest.fixture(scope="module")
def content(quad_report):
    return read_content(quad_report / "report.json")


def test_what_a_flight_covers_is_the_range_of_its_height_and_the_greatest_of_its_speed():
    """From 1 m to 2.5 m above z = 0 the height ranges over 1.5 m; of what the log does not hold nothing is said."""
    coverage = {"pz": {"q01": 1.0, "q99": 2.5}, "speed": {"q99": 3.0, "rms": 1.1}, "wx": {"q99": 0.7, "rms": 0.2}}
    said = _covers(SimpleNamespace(coverage=coverage))
    assert {k: x for k, x in said.items() if x is not None} == {"height_range": 1.5, "speed": 3.0, "rate_x": 0.2}
    assert {k for k, x in said.items() if x is None} == {"tilt", "rate_y", "rate_z", "vertical_acceleration"}


def test_more_effects_than_boxes_share_the_last_box():
    assert boxes([("a",), ("b",)]) == (("a",), ("b",))
    assert boxes([]) == ()
    assert boxes([(x,) for x in "abcdef"]) == (("a",), ("b",), ("c",), ("d", "e", "f"))
    assert boxes([("a",), ("b",), ("c",), ("d", "e")], True) == (("a",), ("b",), ("c",), ("d", "e"))
    assert boxes([("a",), ("b",), ("c",), ("d",), ("e", "f")], True) == (("a",), ("b",), ("c", "d"), ("e", "f"))


def test_the_dashed_line_of_the_rms_lies_over_the_mean(content):
    for drawn in _places(content):
        glyphs = [getattr(r, "glyph", None) for r in drawn.renderers]
        lines = [g for g in glyphs if g.__class__.__name__ == "Line"]
        assert [line.y for line in lines] == ["mean", "rms"]
        assert lines[-1].line_dash


def test_the_bars_are_the_errors_of_the_series_that_are_drawn(content):
    """The page's two accounts of one thing: bars from sums over blocks, lines from what was squeezed."""
    fall, traces = content["fall"], content["traces"]
    assert len(fall["rmse"]) == 2 ** len(fall["boxes"]) == 2
    for k, row in enumerate(fall["rmse"]):
        for axis in AXES:
            left = []
            for flight in traces["flights"]:
                own = read_part(flight)["axes"][axis]
                left.append(own["measured"] - own["model"][k])
            rms = float(np.sqrt(np.nanmean(np.concatenate(left) ** 2)))
            assert rms == pytest.approx(row[axis], rel=1e-3)
    # Nothing is fitted in the model as given: its held-out error is its error.
    for axis, before in content["answer"]["error"]["before"].items():
        assert fall["rmse"][0][axis] == pytest.approx(before, rel=1e-9)


def test_the_effect_that_is_named_is_what_makes_the_error_fall(content, quad_report):
    assert content["answer"]["verdict"]["supported"] == ["rotor_effectiveness"]
    assert (quad_report / "stdout").read_text() == "Missing: rotor_effectiveness.\n"
    (gain,) = gains(content)
    assert gain["axis"] in ("tx", "ty")
    assert gain["low"] < gain["after"] < gain["high"] < 0.02 * gain["before"]
    heat = {row["axis"]: row["cells"] for row in content["heat"]["rows"]}
    assert all(cell["before"] > 10 > 2 > cell["after"] for cell in heat["tx"])
    assert "rotor_effectiveness" in (quad_report / "new.yaml").read_text()


def test_both_sides_of_the_heat_map_are_over_one_floor():
    """The floor of a residual that is not white depends on its model; the arrow compares errors, not floors."""
    rng = np.random.default_rng(0)
    measured, unit = rng.standard_normal((50, 6)), {"force": "N", "torque": "N m"}
    made = []
    for left, own in ((0.8, 0.4), (0.2, 0.1)):
        error = EquationError(
            np.arange(50.0),
            measured,
            (1 - left) * measured,
            np.full(6, own),
            np.ones(6),
            unit,
            "velocity",
            0.15,
            {},
            {},
        )
        made.append(HeldOut((error,), np.ones((1, 6)), np.ones((1, 6)), np.zeros(1)))
    none = np.zeros((2, 6))
    found = Combinations((("a",),), tuple(made), none, none, np.full(6, 0.1), np.full((1, 6), 0.1))
    for row in heat(found, ["one"])["rows"]:
        (cell,) = row["cells"]
        assert cell["before"] / cell["after"] == pytest.approx(4.0)


def test_the_floor_of_the_page_is_that_of_the_printed_answer(content):
    floor = content["answer"]["error"]["floor"]
    assert content["fall"]["floor"] == floor
    # Of each flight beside its errors: the flights' errors over their floors come to the error of all over its floor.
    for row in content["heat"]["rows"]:
        squares = [cell["after"] ** 2 for cell in row["cells"]]
        whole = content["fall"]["rmse"][-1][row["axis"]] / floor[row["axis"]]
        assert np.sqrt(np.mean(squares)) == pytest.approx(whole, rel=0.05)
    assert "after: the new model, fitted to all of these flights; floor: that of the new model" in content["text"]
    text = re.sub(r"\s+", " ", page(content))
    assert "One floor stands under both sides" in text
    assert "the error after a fit to all of these flights, which is usually smaller" in text


def test_what_a_place_says_is_short_sentences(content):
    text = page(content)
    for part in content["places"][0]["sentence"].split("; "):
        assert minus(f"{part[1:]}.") in text


def test_the_next_command_uses_the_model_that_was_written(content, quad_report):
    commands = [row["command"] for row in content["next"]]
    assert any(c.startswith(f"infotraj compare {quad_report / 'new.yaml'} ") for c in commands)
    assert not any("--save-model" in c for c in commands)


def test_the_command_that_shows_the_worst_flight_records_both_models(content, tmp_path, monkeypatch):
    (said,) = (row["command"] for row in content["next"] if "three dimensions" in row["why"])
    words = shlex.split(said.removeprefix("infotraj "))
    words[words.index("--recording") + 1] = str(tmp_path / "worst.rrd")
    monkeypatch.chdir(TOP)
    assert CliRunner().invoke(cli, words, catch_exceptions=False).exit_code == 0
    shown = read_back(tmp_path / "worst.rrd")
    lines = {"predicted": "predicted by new", "predicted_2": "predicted by vehicle"}
    assert {k: shown[f"wrench/fx/{k}"]["SeriesLines:names"] for k in lines} == {k: [n] for k, n in lines.items()}


def normalised(text):
    """Bokeh counts its models on through a process."""
    return re.sub(r'"p\d+"', '"p"', text)


def test_the_page_is_drawn_again_from_its_json_without_computing(quad_report, tmp_path):
    done = command("--from-json", quad_report / "report.json", "-o", tmp_path / "again.html")
    assert done.returncode == 0, done.stderr
    first, again = ((f / n).read_text() for f, n in ((quad_report, "report.html"), (tmp_path, "again.html")))
    assert normalised(first) == normalised(again)
    code = (
        "import sys, infotraj.report.page, infotraj.report.again; "
        "heavy = {'scipy', 'numba', 'matplotlib', 'infotraj.diagnosis.diagnosis'} & set(sys.modules); "
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_nothing_of_a_file_name_or_a_finding_can_run_in_the_page(content):
    hostile = "</script><script>document.title='hurt'</script><img src=x onerror=alert(1)>"
    changed = json.loads(json.dumps(content))
    changed["flights"][0]["name"] = changed["answer"]["verdict"]["summary"] = hostile
    changed["windows"][0]["name"] = changed["fall"]["boxes"][0]["label"] = hostile
    changed["answer"]["effects"][0]["reason"] = changed["next"][0]["command"] = hostile
    text = page(changed)
    assert "<script>document.title" not in text
    assert "<img" not in text
    assert "&lt;/script&gt;" in text


def test_what_the_page_needs_is_in_it(quad_report):
    text = (quad_report / "report.html").read_text()
    assert not re.search(r"<(?:script|img|link|iframe)[^>]+(?:src|href)=[\"'](?!data:)", text)
    assert "default-src 'none'" in text
    assert len(text) < 1e6


@pytest.mark.parametrize(
    ("text", "said"),
    [("not json", "Expecting value"), ('{"form": 99}', "form 99"), ("[]", "form none"), (None, "No such file")],
)
def test_a_content_of_another_kind_is_one_line_and_no_page(text, said, tmp_path):
    path = tmp_path / "report.json"
    if text is not None:
        path.write_text(text)
    done = command("--from-json", path, "-o", tmp_path / "out" / "page.html")
    assert done.returncode == 3
    assert said in done.stderr
    assert f"form {FORM}" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("text", ["not json", "[]", '{"reference": "ref.csv"}'])
def test_a_design_that_is_none_is_one_line_and_no_page(text, quad_report, tmp_path):
    (tmp_path / "design.json").write_text(text)
    words = ["--from-json", quad_report / "report.json", "--design", tmp_path / "design.json"]
    done = command(*words, "-o", tmp_path / "page.html")
    assert done.returncode == 3
    assert len(done.stderr.splitlines()) == 1
    assert "infotraj design --json" in done.stderr
    assert not (tmp_path / "page.html").exists()


@pytest.mark.parametrize("again", [True, False])
def test_a_design_for_another_model_is_refused_before_anything_is_computed(again, content, quad_report, tmp_path):
    circle = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]
    drawn = {"t": [0.0, 1.0], "position": circle, "speed": [0.0, 0.0], "rate": [0.0, 0.0], "simulated": None}
    made = {
        "reference": "next.csv", "model": {"path": "other.yaml", "sha256": "0"}, "flown": [], "seconds": 1.0,
        "greatest": {"speed": 0.0, "rate": 0.0}, "told": [], "simulated": None, "warning": None,
        "hardly_worth": None, "fly": True, "tried": 3, "drawn": drawn,
    }  # fmt: skip
    design, page = tmp_path / "design.json", tmp_path / "page.html"
    quad = Path(__file__).parents[1] / "examples/quad"
    flights = [quad / "vehicle.yaml", quad / "flight_0.parquet"]
    given = ["--from-json", quad_report / "report.json"] if again else flights
    design.write_text(json.dumps(made))
    done = command(*given, "--design", design, "-o", page)
    assert done.returncode == 3
    assert "designed for other.yaml, and the page is about " in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not page.exists()
    if again:
        made["model"]["sha256"] = content["provenance"]["model_sha256"]
        design.write_text(json.dumps(made))
        assert command(*given, "--design", design, "-o", page).returncode == 0


@pytest.mark.parametrize(
    "words",
    [
        ["-o", "page.html"],
        ["vehicle.yaml", "-o", "page.html"],
        ["--from-json", "r.json", "vehicle.yaml", "f.parquet", "-o", "page.html"],
        ["--from-json", "r.json", "--save-model", "new.yaml", "-o", "page.html"],
    ],
)
def test_either_flights_or_a_file_are_asked_for(words, tmp_path):
    done = command(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert list(Path(tmp_path).iterdir()) == []


def test_flights_without_a_measured_wrench_and_without_an_answer_have_a_page_too(content):
    """Poses alone are judged by the pose; flights that nothing can be judged on get their reason once."""
    bare = json.loads(json.dumps(content))
    nothing = {"bucket": None, "models": 1, "left": False, "steps": {}, "numbers": ""}
    bare["traces"] = {"axes": [], "peak": {}, "flights": [nothing] * 3, "windows": []}
    bare["fall"] |= {"axes": [], "boxes": content["fall"]["boxes"]}
    bare |= {"places": [], "windows": [], "offsets": [], "leftover": []}
    bare["heat"]["rows"] = []
    text = page(bare)
    assert "no measured wrench to draw" in text
    assert 'data-bit="0"' not in text
    assert 'data-bit="0"' in page(content)
    refused = json.loads(json.dumps(content))
    refused["answer"]["axes"] = {a: {"judged": False, "reason": "they hover", "coherence": None} for a in AXES}
    assert "Anything about fx, fy, fz, tx, ty, tz: they hover." in page(refused)


def test_a_reason_that_axes_share_is_said_once():
    end = "flights and vehicle file do not agree there"
    refused = {"fx": "no mass", "tx": f"7 % of the torque about x: {end}", "ty": f"5 % of the torque about y: {end}"}
    assert why(refused) == [("no mass", ["fx"]), (end, ["tx", "ty"])]
    assert why({"tx": refused["tx"]}) == [(refused["tx"], ["tx"])]
    assert why({"tx": refused["tx"], "ty": refused["tx"]}) == [(refused["tx"], ["tx", "ty"])]


def test_what_corrects_the_file_is_not_said_to_be_unsure(content):
    changed = json.loads(json.dumps(content))
    for row in changed["answer"]["effects"]:
        if row["name"] in ("thrust_scale", "linear_drag"):
            row["verdict"] = "Plausible"
    assert "That linear drag, thrust scale are absent" in page(changed)
    numbers = {"factor": 1.01}
    changed["answer"]["corrected"] = [{"name": "thrust_scale", "parameters": numbers, "standard_errors": numbers}]
    assert "That linear drag is absent" in page(changed)


def test_what_is_the_files_own_error_is_not_said_to_be_unsure(content):
    changed = json.loads(json.dumps(content))
    for row in changed["answer"]["effects"]:
        if row["name"] in ("thrust_scale", "linear_drag"):
            row["verdict"], row["of_file"] = "Plausible", row["name"] == "thrust_scale"
    assert "That linear drag is absent" in page(changed)
    told = Finding("thrust_scale", "Plausible", ("thrust_scale",), None, {}, {}, of_file=True)
    assert (_effect(told, None)["of_file"], _effect(replace(told, of_file=False), None)["of_file"]) == (True, False)


def test_a_disclaimer_and_a_gain_are_said_once(content):
    """Two effects that cannot be told apart, an axis of which nothing can be said, error that is left: each once."""
    changed = json.loads(json.dumps(content))
    group = ["actuation_delay", "rotor_lag"]
    for row in changed["answer"]["effects"]:
        if row["name"] in group:
            row |= {
                "verdict": "Not separable",
                "group": group,
                "reason": "these flights cannot tell one from the other",
            }
    reason = "flights and vehicle file do not agree there"
    changed["answer"]["axes"]["tz"] = {"judged": False, "reason": reason, "coherence": None}
    first = "Missing: rotor_effectiveness"
    rest = [f"nothing can be said about tz: {reason}", "structured error is left on fz that no effect explains"]
    changed["answer"]["verdict"] |= {"summary": "; ".join([first, *rest]) + ".", "unexplained": True}
    text = re.sub(r"\s+", " ", re.search(r"<section id=\"verdict\">(.*?)</section>", page(changed), re.DOTALL)[1])
    assert "<h1>Missing: rotor_effectiveness.</h1>" in text
    assert text.count("each explains these flights equally well") == 1
    assert text.count(reason) == text.count("tructured error") == text.count('class="gain"') == 1
    # Where the sentence does not say it, the list does.
    changed["answer"]["verdict"]["summary"] = f"{first}."
    assert f"Anything about tz: {reason}." in page(changed)


def test_a_page_that_names_nothing_says_how_large_the_error_is(content):
    changed = json.loads(json.dumps(content))
    for row in changed["answer"]["effects"]:
        row["verdict"] = "Not needed"
    changed["fall"]["boxes"] = []
    cells = [[{"before": 1.0 + i + 0.1 * k, "after": 1.0} for k in range(3)] for i in range(6)]
    changed["heat"]["rows"] = [{"axis": a, "cells": c} for a, c in zip(AXES, cells, strict=True)]
    changed["answer"]["axes"]["tz"] = {"judged": False, "reason": "it hovers", "coherence": None}
    text = page(changed)
    assert "is <b>5.2</b> times what the sensors' noise alone leaves (ty of flight_2)" in text
    assert "A name says that" not in text
    assert "A name says that" in page(content)
    assert "times what the sensors' noise" not in page(content)


def test_a_page_that_names_nothing_says_what_corrects_the_file(content):
    changed = json.loads(json.dumps(content))
    for row in changed["answer"]["effects"]:
        row["verdict"] = "Not needed"
    numbers = {"dm": 0.3}
    changed["answer"]["corrected"] = [{"name": "mass_offset", "parameters": numbers, "standard_errors": numbers}]
    text = page(changed)
    assert "With the vehicle file corrected the held-out error of" in text
    assert "No effect is named; the new model corrects the vehicle file." in text
    assert "What is named, on flights" not in text
    assert "one may stand for another" not in text
    changed["answer"]["corrected"] *= 2
    text = page(changed)
    assert "one may stand for another" in text
    assert "The 2 entries of the new model that correct the file" in text


def test_a_named_rotor_keeps_its_own_gain_beside_others_that_correct_the_file(content):
    """Both are rotor_effectiveness; the second box takes no error off, so that the rotor's gain is told by its own."""
    changed = json.loads(json.dumps(content))
    fall = changed["fall"]
    assert [box["corrects"] for box in fall["boxes"]] == [False]
    fall["boxes"].append({"label": "the file corrected", "effects": ["rotor_effectiveness 0"], "corrects": True})
    for key in ("rmse", "low", "high"):
        fall[key] = fall[key] * 2
    rotor, file = gains(changed)
    assert rotor["before"] > 10 * rotor["after"]
    assert file["before"] == file["after"]
    errors = {"factor": 0.01}
    entry = {"name": "rotor_effectiveness", "parameters": {"rotor": 0, "factor": 1.01}, "standard_errors": errors}
    changed["answer"]["corrected"] = [entry]
    named, corrects = re.findall(r'data-label="acts most on">(.*?)</td>', page(changed), re.DOTALL)
    assert "the file corrected" not in named
    assert named.split("<small>")[0] != corrects.split("<small>")[0]


def test_a_verdict_is_cut_where_it_adds_what_cannot_be_said():
    said = "Missing: a (or b: c; d); nothing can be said about tx: e; f; structured error is left on fz that g."
    assert clauses(said) == [
        "Missing: a (or b: c; d).",
        "Nothing can be said about tx: e; f.",
        "Structured error is left on fz that g.",
    ]
    assert clauses("No missing effect is supported.") == ["No missing effect is supported."]
    of_file = clauses("No missing effect is supported; the numbers of your vehicle file make most of the error: a, b.")
    assert of_file[1] == "The numbers of your vehicle file make most of the error: a, b."
    as_ever = clauses(
        "Nothing changed that these flights can tell; error without a name is left on tx, no more than x."
    )
    assert as_ever[1] == "Error without a name is left on tx, no more than x."
    assert clauses("No change is sure; plausible: a, b.") == ["No change is sure.", "Plausible: a, b."]
    assert clauses("Missing: a; your vehicle file is out of line: b 2.")[1] == "Your vehicle file is out of line: b 2."


def test_signs_are_signs_and_hyphens_stay():
    assert minus("-0.003 at -1e-05 N, 2-3 of log-7, x-1 (-4)") == "−0.003 at −1e-05 N, 2-3 of log-7, x-1 (−4)"


def test_a_residual_far_off_is_drawn_beside_its_mean_and_fills_the_axis():
    y = np.random.default_rng(0).normal(-84.0, 2.0, 4000)
    off = _far_off(y)
    assert off == pytest.approx(-84.0, abs=0.2)
    assert _far_off(y + 80.0) == 0.0
    reach = _reach(y - off, np.array([1.0, 3.0]), 0.5)
    assert reach["bottom"] < -4.0
    assert reach["top"] > 4.0
    assert reach["top"] - reach["bottom"] < 20.0
    # The band of the noise is in sight, whatever the points do.
    assert _reach(np.full(100, 9.0), np.array([9.0]), 1.0)["bottom"] < -2.0


def test_the_label_of_a_figure_says_which_mean_was_taken_off(content):
    changed = json.loads(json.dumps(content))
    place = changed["places"][0]
    labels = [_places(c)[0].yaxis[0].axis_label for c in (content, changed | {"places": [place | {"off": -0.0842}]})]
    assert "beside" not in labels[0]
    assert labels[1].split(" [")[0].endswith("residual beside −84.2")


def test_what_the_filter_makes_alike_is_no_memory_of_the_error():
    """Noise that the filter smoothed is one with itself and its neighbours, and with nothing beyond the filter."""
    t, noise = 0.01 * np.arange(6000), np.random.default_rng(0).standard_normal(6000)
    measured = np.zeros((6000, 6))
    measured[:, 0] = np.convolve(noise, np.ones(15) / 15, mode="same")
    some = dict(red=np.ones(6), unit={"force": "N"}, force_from="", window=0.15, reasons={}, left_out={})
    (row,) = leftover([EquationError(t, measured, 0.01 * np.sin(measured), np.full(6, 0.1), **some)])[:1]
    assert row["axis"] == "fx"
    assert max(unpacked(row["auto"])) == pytest.approx(1.0, abs=0.01)
    assert abs(row["largest_auto"]) < 0.2
