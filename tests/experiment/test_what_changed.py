"""The judgement of answers about flights with a known change, and their table and figure."""

import json
from pathlib import Path

import pytest

from infotraj.experiment.real.what_changed import judged, read_study, write_what_changed

STUDY = Path(__file__).parents[2] / "config" / "studies" / "what_changed.yaml"


def told(name, parameters, healthy, group=()):
    errors = dict.fromkeys(parameters, 0.01)
    return {
        "name": name,
        "group": list(group or (name,)),
        "parameters": parameters,
        "standard_errors": errors,
        "healthy": healthy,
    }


def weak(rotor, factor):
    return told("rotor_effectiveness", {"rotor": rotor, "factor": factor}, {"factor": 1.0})


def answer(condition, *found, refused=""):
    return {"group": "motor_data", "condition": condition, "log": "E8_log00", "found": list(found), "refused": refused}


@pytest.mark.parametrize(
    ("given", "word"),
    [
        (answer("cut_propeller_M3_3mm_3mm_41mm", weak(2, 0.7)), "right"),
        (answer("cut_propeller_M3_3mm_3mm_41mm", weak(0, 0.7)), "wrong"),
        (answer("cut_propeller_M3_3mm_3mm_41mm", weak(2, 1.3)), "wrong"),
        (answer("cut_propeller_M3_3mm_3mm_41mm"), "nothing"),
        (answer("cut_propeller_M3_3mm_3mm_41mm", refused="no flight"), "refused"),
        (answer("normal_flight", weak(2, 0.9)), "wrong"),
        (answer("normal_flight"), "nothing"),
        (answer("add_weight_W1_near_M4", told("com_offset", {"r": [1e-3, 2e-3, 0]}, {"r": [0, 0, 0]})), "right"),
        (answer("add_weight_W1_near_M4", told("com_offset", {"r": [-1e-3, -2e-3, 0]}, {"r": [0, 0, 0]})), "wrong"),
    ],
)
def test_an_answer_is_right_in_rotor_side_and_sign(given, word):
    assert judged(given, read_study(STUDY)) == word


def test_one_wrong_name_beside_a_right_one_is_wrong():
    given = answer("cut_propeller_M3_3mm_3mm_41mm", weak(2, 0.7), told("time_offset", {"dt": 0.01}, {"dt": 0.0}))
    assert judged(given, read_study(STUDY)) == "wrong"


def test_table_and_figure(tmp_path):
    answers = tmp_path / "a.json"
    answers.write_text(json.dumps([answer("normal_flight"), answer("cut_propeller_M3_3mm_3mm_41mm", weak(2, 0.7))]))
    out = [tmp_path / name for name in ("t.csv", "t.md", "f.pdf", "f.png")]
    write_what_changed(STUDY, [answers], *out)
    assert "rotor 3 gives 0.70 +- 0.01 (healthy 1.00)" in out[1].read_text()
    assert all(p.stat().st_size > 0 for p in out)
