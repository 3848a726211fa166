"""Answers the cases of the study of changes with the public command, with the healthy flights and without.

Given the flight tables and the vehicle file alone.
"""

from __future__ import annotations

from pathlib import Path

from infotraj.experiment.hidden.diagnosing import answer

LIMIT = 300.0  # s of CPU for one diagnosis
WAYS = ("with", "without")


def answer_changes(*, flights: Path, answers: Path) -> None:
    """Writes answers/case_K/with (`diagnose vehicle.yaml now_* --reference healthy_*`) and .../without.

    Nothing for a case that could not be flown.
    """
    for case in sorted(flights.glob("case_*")):
        now, healthy = (sorted(str(p) for p in case.glob(f"{what}_*.parquet")) for what in ("now", "healthy"))
        for way in WAYS if now else ():
            folder = answers / case.name / way
            folder.mkdir(parents=True, exist_ok=True)
            options = ["--reference", *healthy] if way == "with" else []
            answer(case / "vehicle.yaml", now, folder, *options, limit=LIMIT)
