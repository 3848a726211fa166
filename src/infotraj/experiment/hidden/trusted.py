"""The README's numbers to trust, from published results: unseen runs of the study, and labelled real flights."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

BEGIN, END = "<!-- numbers: snakemake readme_numbers -->", "<!-- end of numbers -->"
_CUT = re.compile(r"cut_propeller_M3_([2-9])mm_\1mm")


def trusted(runs: Sequence[Path], changed: Path) -> str:
    """The lines of the README between its markers.

    runs: tables of the study's runs on unseen seeds (CSV); changed: the published table of what changed (markdown).
    """
    rows = [row for path in runs for row in csv.DictReader(path.read_text().splitlines())]
    # A plant that could not be flown was asked nothing.
    rows = [row for row in rows if row["right"] in ("True", "False") and not row.get("failed")]
    single = [row for row in rows if "/single/" in row["case"]]
    beside = [row for row in single if row["case"].endswith("~3%")]
    nothing = [row for row in rows if "/nothing/" in row["case"]]
    unlisted = [row for row in rows if "/unlisted/" in row["case"]]
    alarms = sum(bool(row["invented"].strip("[]")) for row in nothing)
    cut, in_group, wrong, flights, healthy = _changes(changed.read_text().splitlines())
    simulated = (
        "- Simulated, on seeds that no version had seen, mostly with rough logs or a vehicle file wrong by 3 %: "
        f"a single effect was named right in **{_share(single)}** runs (beside 3 %: {_share(beside)}), and with "
        f"nothing hidden **{alarms} of {len(nothing)}** gave a wrong name. Physics that the catalogue lacks is the "
        f"weak side: **{_share(unlisted)}** right. The runs, their dates and what changed since: "
        "[docs/hidden_effects_results.md](docs/hidden_effects_results.md)."
    )
    real = (
        "- Real flights with 2 mm and more cut off both tips of a propeller: that rotor was named in "
        f"**{cut[0]} of {cut[1]}**, {in_group} of them in a group of names, and {wrong} wrong names came from "
        f"{flights} changed and {healthy} healthy flights: "
        "[docs/what_changed.md](docs/what_changed.md). More real flights: [docs/real_flights.md](docs/real_flights.md)."
    )
    return f"{simulated}\n{real}"


def _share(rows: Sequence[dict[str, str]]) -> str:
    return f"{sum(row['right'] == 'True' for row in rows)} of {len(rows)}"


def _changes(lines: Iterable[str]) -> tuple[tuple[int, int], int, int, int, int]:
    """Of the table of what changed: right and all of those cut at both tips, and in a group of names; wrong names;
    changed, healthy flights."""
    right = all_cut = grouped = wrong = changed = healthy = 0
    for line in lines:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        told = re.findall(r"(\d+) (right|nothing|refused|wrong)", cells[2]) if len(cells) == 4 else []
        counts = {what: int(n) for n, what in told}
        if not counts:
            continue
        total = sum(counts.values())
        wrong += counts.get("wrong", 0)
        if cells[1] == "normal_flight":
            healthy += total
        else:
            changed += total
        if _CUT.match(cells[1]):
            right, all_cut = right + counts.get("right", 0), all_cut + total
            grouped += sum(" or " in answer and "rotor" in answer for answer in cells[3].split(" / "))
    return (right, all_cut), grouped, wrong, changed, healthy


def write_numbers(readme: Path, text: str) -> None:
    """Puts the text between the markers of a README. ValueError where they are missing."""
    page = readme.read_text()
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{readme}: no {BEGIN} ... {END}")
    readme.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}")
