"""A short run of the fuzzer over all readers; `python tests/support/fuzz_readers.py --minutes 60` is the long one."""

from __future__ import annotations

from pathlib import Path

import fuzz_readers


def test_damaged_logs_of_every_kind_end_in_one_line_and_leave_nothing(tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    (tmp_path / "work").mkdir()
    logs = fuzz_readers.seeds(tmp_path / "logs")
    assert len(logs) >= 14
    fuzz_readers.warmed(logs)
    found = [fuzz_readers.run_case(case, logs, tmp_path / "work") for case in range(4 * len(logs))]
    assert [line for line in found if line["outcome"] == "failed"] == []
    assert {line["outcome"] for line in found} == {"flight", "refused"}


def test_a_case_is_repeated_by_its_number(tmp_path: Path) -> None:
    import numpy as np

    data = bytes(range(256)) * 40
    one, two = (fuzz_readers.mutated(data, [tmp_path], np.random.default_rng(5)) for _ in range(2))
    assert one == two != data
