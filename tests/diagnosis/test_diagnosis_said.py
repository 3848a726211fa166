"""What an answer says of errors, files and commands, and how errors of held-out stretches are told."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from infotraj.comparing.equation_error import AXES
from infotraj.diagnosis.gates.doubt import Doubt
from infotraj.diagnosis.judge.evidence import Evidence
from infotraj.diagnosis.judge.numbers import FileNumber
from infotraj.diagnosis.judge.unexplained import NOTHING_LEFT, Structure, Unexplained
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.linear.change import Change
from infotraj.diagnosis.report.parts import parts
from infotraj.diagnosis.report.reasons import why
from infotraj.diagnosis.report.steps import HeldOut
from infotraj.diagnosis.report.summary import as_dict, as_text, sentence, stays
from infotraj.effects.registry import effect_class
from infotraj.flight import Flight
from infotraj.report.formats import changes
from infotraj.sparse_commands import COMMAND_STEPS
from infotraj.suggested import again

ONES = np.ones(6)
HEALTHY = SimpleNamespace(flights=())
KNOWN = [SimpleNamespace(name=name, cls=effect_class(name)) for name in ("linear_drag", "time_offset", "gyro_bias")]


def evidence_of(rise):
    return Evidence(-0.5, (-0.6, -0.4), (3, 4), 0.97, rise, "fx", gain=0.4, probability=0.99, form_error=0.2)


def answer(**changed):
    """As much of a diagnosis as its words are made of."""
    vehicle = SimpleNamespace(mass=1.0, inertia=1.0)
    observation = SimpleNamespace(command_step=0.004, balance=frozenset())
    statistics = {
        name: SimpleNamespace(rmse=scale * ONES, floor=floor * ONES)
        for name, scale, floor in (("before", 1.0, 0.07), ("after", 0.1, 0.08))
    }
    made = SimpleNamespace(
        **statistics,
        supported=(),
        findings=(),
        beside=(),
        healthy=None,
        healthy_numbers=lambda finding: None,
        changes=lambda finding: (),
        usual=np.full(6, np.nan),
        as_ever=frozenset(),
        of_day=np.full(6, np.nan),
        by_file=np.zeros(6),
        judged=True,
        refused={},
        doubts=(),
        file=(),
        unexplained=Unexplained(False, ()),
        model=SimpleNamespace(vehicle=vehicle, effects=()),
        errors_of=(),
        coherence=0.5 * ONES,
        faint={},
        accepted=[],
        at_bound={},
        command_steps=1,
        search=SimpleNamespace(observation=observation, known=KNOWN),
        samples=(),
    )
    made.finding = lambda name: next(f for f in made.findings if f.name == name)
    for key, value in changed.items():
        setattr(made, key, value)
    return made


def found(name, verdict="Supported", group=(), rise=1.0):
    return Finding(name, verdict, group or (name,), evidence_of(rise), {}, {})


def test_an_error_stays_that_is_three_times_the_floor_of_the_new_model_on_a_judged_axis():
    after = SimpleNamespace(rmse=np.array([0.3, 0.2, 0.25, 0.9, np.nan, 0.1]), floor=0.08 * ONES)
    made = answer(after=after, refused={"tx": "why"})
    assert stays(made) == {"fx": 0.3, "fz": 0.25}
    assert "0.25 N of error stay on fz" in as_text(made)
    untold = {k: SimpleNamespace(rmse=np.full(6, np.nan), floor=np.full(6, np.nan)) for k in ("before", "after")}
    assert "after      floor" in as_text(made)
    text = as_text(answer(**untold))
    assert "error before and after: cannot be said; an accelerometer, a velocity or rates tell it\n" in text
    assert "floor" not in text


def test_a_torque_that_hardly_goes_with_the_prediction_is_spoken_of():
    text = as_text(answer(faint={"ty": 0.49, "tz": 0.1}, refused={"tz": "why"}))
    assert text.count("of the measured torque, noise left aside, goes") == 1
    assert "ty: only 49 % of the measured torque, noise left aside, goes with what the model predicts" in text


def test_errors_are_told_before_and_after_beside_the_floor_of_the_new_model():
    error = as_dict(answer())["error"]
    assert error == {
        "before": dict.fromkeys(AXES, 1.0),
        "after": dict.fromkeys(AXES, 0.1),
        "floor": dict.fromkeys(AXES, 0.08),
    }


def test_the_sentence_names_effects_with_those_that_they_cannot_be_told_from():
    pair = ("mass_offset", "thrust_scale")
    findings = (found("mass_offset", "Not separable", pair), found("linear_drag"), found("thrust_scale", group=pair))
    made = answer(findings=findings, supported=("mass_offset", "linear_drag"))
    assert sentence(made) == ("Missing: mass_offset (or thrust_scale: not separable on these flights), linear_drag.")
    by = {"thrust_scale": (Change("factor", True, 0.9, 0.02),)}
    made.healthy, made.usual, made.changes = HEALTHY, 0.1 * ONES, lambda finding: by.get(finding.name, ())
    assert sentence(made) == (
        "Changed: mass_offset (or thrust_scale, factor 0.9 +- 0.02 times the healthy one: not separable on these "
        "flights), linear_drag."
    )
    assert sentence(answer()) == "No missing effect is supported."
    assert sentence(answer(judged=False, refused={"fx": "it hovers"})).endswith("missing: it hovers.")


def test_what_is_of_the_log_is_told_apart_from_what_the_vehicle_lacks():
    names = ("linear_drag", "time_offset", "gyro_bias")
    made = answer(findings=[found(x) for x in names], supported=names)
    assert sentence(made) == "Missing: linear_drag; in its log: time_offset, gyro_bias."
    both = ("time_offset", "linear_drag")
    made = answer(findings=[found("time_offset", "Not separable", both)], supported=("time_offset",))
    assert sentence(made) == "Missing: time_offset (or linear_drag: not separable on these flights)."
    made = answer(findings=[found("time_offset")], supported=("time_offset",))
    assert sentence(made) == "No missing effect of the vehicle is supported; in its log: time_offset."


def test_every_rotor_that_is_named_stands_in_the_table_and_in_the_sentence():
    rotors = ({"rotor": 1, "factor": 1.062}, {"rotor": 2, "factor": 1.061})
    errors = {"factor": 0.09}
    of_two = replace(
        found("rotor_effectiveness"),
        parameters=rotors[0],
        standard_errors=errors,
        instances=rotors,
        instance_errors=(errors, errors),
    )
    made = answer(findings=[of_two], supported=("rotor_effectiveness",))
    assert "\n                    and rotor=2 factor=1.061\n" in as_text(made)
    assert "and rotor" not in as_text(answer(findings=[replace(of_two, verdict="Not needed")]))
    assert sentence(made) == "Missing: rotor_effectiveness (1 2)."


def test_a_number_of_the_file_is_not_called_unneeded_beside_its_line():
    weak = FileNumber("rotor_2.thrust, factor", 1.0, 0.88, 0.01, False, label="rotor_effectiveness 2")
    made = answer(findings=[found("rotor_effectiveness", "Not needed"), found("wind", "Not needed")], file=(weak,))
    text = as_text(made)
    assert "Numbers of your vehicle file, below: rotor_effectiveness\nNot needed: wind\n" in text
    assert "Not needed: rotor_effectiveness, wind" in as_text(answer(findings=made.findings, file=()))


def test_noise_of_measured_rotors_may_be_what_stays():
    after = SimpleNamespace(rmse=0.9 * ONES, floor=0.08 * ONES)

    def said(commanded):
        flight = Flight(pd.DataFrame({"t": [0.0, 1.0]}), {COMMAND_STEPS: 1})
        recorded = SimpleNamespace(rotor_commanded=commanded)
        one = SimpleNamespace(flight=flight, prepared=SimpleNamespace(recorded=recorded))
        return as_text(answer(after=after, samples=(one,)))

    assert "stay on tx: noise of the measured rotors, the file's own errors, or what has no name" in said(False)
    assert "stay on tx: the file's own errors, or what has no name" in said(True)


def test_what_numbers_of_the_file_alone_take_off_is_said_where_it_is_more_than_half():
    after = SimpleNamespace(rmse=np.array([0.4, 0.1, 0.6, 0.2, 0.9, 1.0]), floor=0.01 * ONES)
    made = answer(after=after, by_file=1.0 - after.rmse, beside=("mass_offset",), refused={"fy": "why"})
    assert "corrected, 60 to 80 % of it is gone on fx, tx" in sentence(made)
    assert "corrected" not in sentence(answer(after=after))
    one = SimpleNamespace(rmse=np.array([0.4, 1, 1, 1, 1, 1]), floor=0.01 * ONES)
    assert "corrected, 60 % of it is gone on fx" in sentence(
        answer(after=one, by_file=1.0 - one.rmse, beside=("mass_offset",))
    )


@pytest.mark.parametrize(
    ("large", "ordinary", "said"), [(True, False, True), (False, False, False), (True, True, False)]
)
def test_a_file_is_out_of_line_in_the_sentence_where_that_is_large_and_not_ordinary(large, ordinary, said):
    number = FileNumber("mass", 1.0, 2.5, 0.1, ordinary, "kg", takes=0.9 * large)
    made = answer(file=(number,))
    assert ("out of line: mass 2.5 kg" in sentence(made)) == said
    (entry,) = as_dict(made)["file"]
    assert (entry["declared"], entry["value"], entry["standard_error"]) == (1.0, 2.5, 0.1)
    assert "mass: 2.5 +- 0.1 kg, not 1" in as_text(made)


def test_doubts_refuse_warn_or_are_accepted():
    doubts = (
        Doubt("a", "motion", ("fx",), "refuses"),
        Doubt("b", "stamps", (), "warns", refuses=False),
        Doubt("c", "file", ("fy",), "overruled", accepted=True),
    )
    made = as_dict(answer(doubts=doubts, refused={"fx": "refuses"}))
    assert made["refused"] == {"motion": "refuses"}
    assert made["warnings"] == ["warns"]
    assert made["axes"]["fx"] == {"judged": False, "reason": "refuses", "coherence": 0.5}
    assert made["axes"]["fy"]["judged"]


def test_effects_of_one_verdict_stand_by_how_much_they_raise_the_error():
    findings = (found("a", "Plausible", rise=0.1), found("b", rise=0.2), found("c", rise=3.0), found("d", "Plausible"))
    lines = as_text(answer(findings=findings, supported=("b", "c"))).splitlines()
    assert [line[0] for line in lines if line[:2] in ("a ", "b ", "c ", "d ")] == ["c", "b", "d", "a"]
    assert "3/4" in lines[1]
    assert "0.97" in lines[1]
    made = as_dict(answer(findings=findings))["effects"][2]
    assert (made["probability"], made["selected"], made["rise"], made["form_error"]) == (0.99, 0.97, 3.0, 0.2)
    assert made["ci95"] == [-0.6, -0.4]


def test_structure_is_told_with_its_held_out_share_and_what_it_goes_with():
    left = Structure("vx", 0.42, 0.1, 2.0, (("wx", -0.7),), "vx goes with wx", 0.3)
    made = answer(unexplained=Unexplained(True, (left,)))
    assert "left on vx: 42 % of the slow error can be predicted; it goes with wx (-0.70)" in as_text(made)
    assert "hint, not a result: vx goes with wx (30 % held out)" in as_text(made)
    (entry,) = as_dict(made)["unexplained"]
    assert (entry["heldout_share"], entry["hint_heldout_share"], entry["rise"]) == (0.42, 0.3, 2.0)
    assert "structured error is left on vx" in sentence(made)


def test_a_delay_of_half_the_time_between_sparse_commands_cannot_be_told():
    sparse = SimpleNamespace(observation=SimpleNamespace(command_step=0.02, balance=frozenset()))
    assert "a delay or lag below 10 ms cannot be told" in as_text(answer(search=sparse))
    assert "cannot be told" not in as_text(answer())
    meta = {"channels": {"rotor_command": {"rate_hz": 50.0}, "rate": {"rate_hz": 1000.0}}}
    filled = SimpleNamespace(flight=SimpleNamespace(meta=meta, t=np.arange(0.0, 1.0, 0.001)))
    told = as_text(answer(samples=(filled,)))
    assert "commands: every 20 ms, held over the rows between" in told
    assert "a delay or lag below 10 ms cannot be told" in told
    read = as_text(answer(command_steps=2))
    assert "commands: every 4 ms, read as 2 steps" in read
    assert "a delay or lag below 2 ms" in read
    assert [again("compare", command_steps=n) for n in (1, 2)] == ["", " --command-steps 2"]


def test_one_reason_of_several_axes_is_told_once_with_its_numbers_only_where_they_agree():
    assert why({"fx": "0.1 of it: order", "fy": "0.2 of it: order", "fz": "hovers"}) == [
        ("order", ["fx", "fy"]),
        ("hovers", ["fz"]),
    ]
    assert why({"fx": "0.1 of it: order", "fy": "0.1 of it: order"}) == [("0.1 of it: order", ["fx", "fy"])]


def test_the_error_of_held_out_stretches_is_over_all_their_rows():
    """Two stretches of one flight: 10 rows with a square of 4 each, and 30 of 1."""
    squares, rows = np.array([[40.0] * 6, [30.0] * 6]), np.array([[10.0] * 6, [30.0] * 6])
    rows[:, 5] = squares[:, 5] = 0.0
    made = HeldOut((), squares, rows, np.zeros(2, dtype=int))
    assert made.rmse[:5] == pytest.approx(np.sqrt(70.0 / 40.0) * np.ones(5))
    assert np.isnan(made.rmse[5])
    low, high = made.interval(np.random.default_rng(0))
    # Either stretch may be drawn twice.
    assert (low[0], high[0]) == pytest.approx((1.0, 2.0))


def test_an_interval_holds_95_percent_of_what_stretches_may_be():
    """A hundred stretches of ten rows whose squares are 1 to a deviation of 0.5 of each stretch's mean."""
    mean = 1.0 + 0.5 * np.random.default_rng(1).standard_normal(100)
    made = HeldOut((), 10.0 * np.tile(mean[:, None], (1, 6)), np.full((100, 6), 10.0), np.zeros(100, dtype=int))
    low, high = made.interval(np.random.default_rng(0))
    assert high[0] - low[0] == pytest.approx(2 * 1.96 * 0.5 * 0.5 / np.sqrt(100), rel=0.25)


def lively(moves, seconds=100.0):
    """Rates in a flight at 20 Hz."""
    t = 5.0 + np.arange(0.0, seconds, 0.05)
    rate = moves(t)
    return Flight(pd.DataFrame({"t": t, "wx": rate, "wy": 0.0 * t, "wz": 0.0 * t}))


def test_flights_share_the_seconds_evenly_and_the_short_ones_leave_theirs():
    made = [lively(lambda t: np.sin(t), s) for s in (10.0, 200.0, 100.0)]
    used, _ = parts(made, 90.0)
    assert [round(f.t[-1] - f.t[0]) for f in used] == [10, 40, 40]
    assert parts(made, 400.0)[0] == made


def test_a_steady_turn_is_no_motion_and_seconds_count_by_the_root_of_their_variance():
    turning = lively(lambda t: np.where(t < 50.0, 3.0, np.sin(3.0 * t)))
    (used,), _ = parts([turning], 20.0)
    assert used.t[0] >= 49.0
    # Ten seconds of a small motion are more than one second that is ten times as large in its square.
    hard = lively(
        lambda t: np.where(t < 50.0, np.sin(9.0 * t), np.where((t > 80.0) & (t < 81.0), 3.0, 0.0) * np.sin(9 * t))
    )
    (used,), _ = parts([hard], 10.0)
    assert used.t[0] < 50.0


def loud(axis, share=0.3, rise=1.0):
    return Structure(axis, share, 0.0, rise, (), None, 0.0)


def test_an_error_far_above_what_healthy_flights_leave_is_a_change_without_a_name():
    after = SimpleNamespace(rmse=np.array([0.385, 0.36, 0.05, 0.3, 0.33, 0.02]), floor=0.0185 * ONES)
    usual = np.array([0.02, 0.02, 0.02, 0.29, np.nan, 0.02])
    made = answer(after=after, healthy=HEALTHY, usual=usual, refused={"fy": "why"})
    said = "omething changed that has no name here: the error is 19.2 times what the healthy flights leave on fx"
    assert sentence(made) == f"S{said}; nothing can be said about fy: why."
    assert list(as_dict(made)["verdict"]["unnamed_change"]) == ["fx"]
    # The healthy flights leave as much on tx, and do not say what they leave on ty.
    assert "on tx: what has no name; the healthy flights leave at most 0.29" in as_text(made)
    made = answer(after=after, healthy=HEALTHY, usual=0.01 * ONES, unexplained=Unexplained(True, (loud("vz"),)))
    assert (
        "38.5 times what the healthy flights leave on fx, 36 times on fy, 33 times on ty, 30 times on tx, 5 times on fz"
        in sentence(made)
    )
    made.findings, made.supported = (found("linear_drag"),), ("linear_drag",)
    assert sentence(made).startswith("Changed: linear_drag; something else changed that has no name here: the error is")


def test_an_error_that_healthy_numbers_explain_as_a_day_may_have_them_is_no_change():
    """Of twenty times what healthy flights leave nearly all of fx goes with a day's numbers, and a half of fy."""
    after = SimpleNamespace(rmse=np.array([0.4, 0.4, 0.05, 0.05, 0.05, 0.02]), floor=0.0185 * ONES)
    of_day = np.array([0.05, 0.2, 0.05, np.nan, 0.05, 0.02])
    made = answer(after=after, healthy=HEALTHY, usual=0.02 * ONES, of_day=of_day)
    assert sentence(made) == (
        "Something changed that has no name here: the error is 20 times what the healthy flights leave on fy."
    )
    assert list(as_dict(made)["verdict"]["unnamed_change"]) == ["fy"]
    of_a_day = "on fx: what the healthy flights leave open, or differs from one day to the next; the healthy flights"
    for left in (NOTHING_LEFT, Unexplained(True, (loud("fx"),))):
        made.unexplained = left
        assert f"0.4 N of error stay {of_a_day} leave at most 0.02" in as_text(made)
        assert "0.4 N of error stay on fy: what has no name; the healthy flights leave at most 0.02" in as_text(made)
    made.of_day = np.full(6, np.nan)
    assert list(as_dict(made)["verdict"]["unnamed_change"]) == ["fx", "fy"]


def test_nothing_changed_is_not_said_where_more_structured_error_is_left_than_on_healthy_flights():
    quiet = SimpleNamespace(rmse=0.1 * ONES, floor=0.08 * ONES)
    made = answer(after=quiet, healthy=HEALTHY, usual=0.1 * ONES)
    assert sentence(made) == "Nothing changed that these flights can tell."
    made.unexplained, made.as_ever = Unexplained(True, (loud("tx"),)), frozenset({"tx", "ty"})
    as_ever = "error without a name is left on tx, no more than on the healthy flights."
    assert sentence(made) == f"Nothing changed that these flights can tell; {as_ever}"
    made.as_ever = frozenset({"ty"})
    assert sentence(made).startswith("No change has a name here; structured error is left on tx that")
    made.unexplained = Unexplained(True, (loud("tx"), loud("ty")))
    assert sentence(made).endswith("explains; error without a name is left on ty, no more than on the healthy flights.")
    assert sentence(made).startswith("No change has a name here; structured error is left on tx that")
    assert "unnamed_change" not in as_dict(answer())["verdict"]


def test_a_change_that_is_plausible_is_told_and_nothing_changed_is_not_said():
    findings = (found("mass_offset", "Plausible", rise=0.1), found("com_offset", "Plausible", rise=0.4))
    made = answer(healthy=HEALTHY, usual=0.1 * ONES, findings=findings)
    assert sentence(made) == "No change is sure; plausible: com_offset, mass_offset."
    made.findings, made.supported = (found("linear_drag"), *findings), ("linear_drag",)
    assert sentence(made) == "Changed: linear_drag; plausible: com_offset, mass_offset."
    after = SimpleNamespace(rmse=np.array([0.385, *(0.05 * ONES[1:])]), floor=0.0185 * ONES)
    made = answer(healthy=HEALTHY, usual=0.1 * ONES, findings=findings, after=after)
    assert sentence(made).startswith(
        "Something changed that has no name here: the error is 3.85 times what the healthy"
    )
    assert sentence(made).endswith(" on fx; plausible: com_offset, mass_offset.")
    made.findings = [found(f"a{k}", "Plausible", rise=-k) for k in range(5)]
    assert sentence(made).endswith("; plausible: a0, a1, a2, 2 more.")
    assert sentence(answer(findings=findings)) == "No missing effect is supported."


def test_every_rotor_that_changed_is_told_with_its_change():
    rotors = ({"rotor": 0, "factor": 0.89}, {"rotor": 5, "factor": 0.93})
    weak = replace(
        found("rotor_effectiveness"), parameters=rotors[0], standard_errors={"factor": 0.01}, instances=rotors,
        instance_errors=({"factor": 0.01}, {"factor": 0.02}),
    )  # fmt: skip
    usual = {
        "parameters": {"factor": 0.98}, "standard_errors": {"factor": 0.05}, "from_flight_to_flight": {"factor": 0.0123}
    }  # fmt: skip
    made = answer(
        healthy=SimpleNamespace(flights=(SimpleNamespace(meta={}),) * 2, balance=()),
        usual=0.1 * ONES, findings=(weak,), supported=("rotor_effectiveness",), healthy_numbers=lambda f: usual,
        changes=lambda f: (Change("factor", True, f.parameters["factor"], f.standard_errors["factor"]),),
    )  # fmt: skip
    assert sentence(made) == (
        "Changed: rotor_effectiveness (rotor 0: factor 0.89 +- 0.01 times the healthy one; "
        "rotor 5: factor 0.93 +- 0.02 times the healthy one)."
    )
    lines = [line.strip() for line in as_text(made).splitlines()]
    k = lines.index("and rotor=5 factor=0.93")
    differ = "times the healthy one; 2 healthy flights differ by factor=0.012"
    assert lines[k - 1] == f"changed: factor 0.89 +- 0.01 {differ}"
    assert lines[k + 1 : k + 3] == [
        "now factor=0.93; healthy factor=0.98 +- 0.05", f"changed: factor 0.93 +- 0.02 {differ}"
    ]  # fmt: skip
    row = as_dict(made)["effects"][0]
    assert [c["times_healthy"] for c in (*row["change"], *row["other_changes"][0])] == [0.89, 0.93]
    assert changes(row) == [
        "rotor 0: factor 0.890 ± 0.010 times the healthy one", "rotor 5: factor 0.930 ± 0.020 times the healthy one"
    ]  # fmt: skip


def test_the_sentence_tells_the_axes_whose_error_is_largest_beside_its_floor():
    after = SimpleNamespace(rmse=np.array([0.1, 0.1, 18.0, 102.0, 162.0, 6.0]), floor=ONES)
    left = tuple(loud(a, rise=9.0 - k) for k, a in enumerate(("vz", "tz", "push y", "tx", "ty")))
    made = answer(after=after, unexplained=Unexplained(True, left))
    assert "structured error is left on ty, tx, vz that no effect" in sentence(made)


def test_a_large_error_that_the_motion_does_not_predict_is_not_called_structured():
    made = answer(unexplained=Unexplained(True, (loud("tx", share=0.0, rise=400.0), loud("fz"))))
    said = "No missing effect is supported; structured error is left on fz that no effect of the catalogue explains; "
    assert (
        sentence(made)
        == said + "a large error is left on tx that neither an effect of the catalogue nor the motion explains."
    )
    assert "left on tx: a large, slow error, 20 times its fast noise, that the motion does not predict\n" in as_text(
        made
    )
    assert "left on fz: 30 % of the slow error can be predicted\n" in as_text(made)


def test_what_corrects_the_file_is_said_with_its_numbers_in_the_order_of_the_rotors():
    """And that it is told above which of them the file has wrong, where it is."""
    gains = [effect_class("rotor_effectiveness")(rotor=k, factor=1.0 - 0.03 * k) for k in (3, 0, 2)]
    centre = effect_class("com_offset")(r=np.array([0.001, -0.002, 0.0]))
    effects = (gains[0], centre, *gains[1:])
    errors = tuple({"r": [0.1] * 3} if e is centre else {"factor": 0.01} for e in effects)
    known = {
        "model": SimpleNamespace(vehicle=SimpleNamespace(mass=1.0, inertia=1.0), effects=effects),
        "errors_of": errors,
        "beside": tuple(e.label for e in effects),
    }
    lines = as_text(answer(**known)).splitlines()
    first = lines.index("no effect is named; the new model corrects the file:")
    assert lines[first + 1 : first + 3] == [
        "  rotor_effectiveness (0 2 3) factor=1 0.94 0.91",
        "  com_offset r=[0.001, -0.002, 0]",
    ]
    assert lines[first + 3].endswith("which of them your file has wrong is not told")
    doubtful = FileNumber("mass", 1.0, 1.1, 0.01, True, "kg", doubt="why")
    for number, said in ((doubtful, "is not told"), (replace(doubtful, doubt=""), "your file should say is above")):
        assert any(line.endswith(said) for line in as_text(answer(**known, file=(number,))).splitlines())
