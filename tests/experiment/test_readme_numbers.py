"""The README's numbers to trust: counted from published runs, and written between its markers."""

import csv
import re
from pathlib import Path

import pytest

from infotraj.experiment.hidden.trusted import BEGIN, END, trusted, write_numbers

TOP = Path(__file__).parents[2]
TABLE = """| logs | what was done | of the flights | answered |
| --- | --- | --- | --- |
| a | cut_propeller_M3_2mm_2mm_43mm | 2 right, 1 wrong | rotor 3 / rotor 3 / wind or steady_force |
| a | cut_propeller_M3_1mm_46mm | 2 nothing, 1 wrong | x |
| b | cut_propeller_M3_4mm_4mm_39mm | 3 right | rotor 3 or steady_torque / rotor 3 / rotor 3 or wind |
| b | normal_flight | 5 nothing | x |
"""


def written(path: Path, rows: list[tuple[str, str, str]]) -> Path:
    with path.open("w", newline="") as file:
        out = csv.DictWriter(file, ["case", "right", "invented"])
        out.writeheader()
        out.writerows(dict(zip(("case", "right", "invented"), row, strict=True)) for row in rows)
    return path


def test_runs_and_flights_are_counted(tmp_path):
    rows = [
        ("omav/single/linear_drag-usual~3%", "True", "[]"),
        ("omav/single/linear_drag-usual~3%", "False", "['wind']"),
        ("omav/single/linear_drag-usual~10%", "True", "[]"),
        ("omav/single/failed-usual", "", ""),
        ("quadrotor/nothing/nothing~3%", "False", "['wind']"),
        ("quadrotor/nothing/nothing", "True", "[]"),
        ("quadrotor/unlisted/slosh", "True", "[]"),
    ]
    changed = tmp_path / "what_changed.md"
    changed.write_text(TABLE)
    text = " ".join(trusted([written(tmp_path / "runs.csv", rows)], changed).split())
    assert "named right in **2 of 3** runs (beside 3 %: 1 of 2)" in text
    assert "with nothing hidden **1 of 2** gave a wrong name" in text
    assert "**1 of 1** right" in text
    assert "named in **5 of 6**, 2 of them in a group of names, and 2 wrong names" in text
    assert "from 9 changed and 5 healthy flights" in text


def test_a_plant_that_could_not_be_flown_is_not_counted(tmp_path):
    changed, runs = tmp_path / "what_changed.md", tmp_path / "runs.csv"
    changed.write_text(TABLE)
    runs.write_text("case,right,invented,failed\na/single/x,True,,\na/single/y,False,,hidden: 0.23 m away\n")
    assert "named right in **1 of 1** runs" in trusted([runs], changed)


def test_only_what_stands_between_the_markers_is_written(tmp_path):
    page = tmp_path / "README.md"
    page.write_text(f"# Title\n{BEGIN}\nold\n{END}\nrest\n")
    write_numbers(page, "- new")
    assert page.read_text() == f"# Title\n{BEGIN}\n- new\n{END}\nrest\n"
    page.write_text("# Title\n")
    with pytest.raises(ValueError, match="no <!-- numbers"):
        write_numbers(page, "- new")


def test_the_readme_says_what_the_published_runs_say(tmp_path):
    rule = (TOP / "workflow/rules/publish.smk").read_text()
    seeds = re.search(r"hidden_effects_seeds_\{seed\}/runs.csv\", seed=\[([\d, ]+)\]", rule)[1].split(",")
    runs = [TOP / f"docs/results/hidden_effects_seeds_{seed.strip()}/runs.csv" for seed in seeds]
    said = (TOP / "README.md").read_text().partition(BEGIN)[2].partition(END)[0].strip()
    assert said == trusted(runs, TOP / "docs/results/what_changed.md")
