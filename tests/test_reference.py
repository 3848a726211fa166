"""The reference file: what it holds comes back, and it is refused in one line where it is not a reference."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.errors import InputError
from infotraj.trajectories.reference import COLUMNS, Reference, read_reference


@pytest.fixture
def reference() -> Reference:
    rng = np.random.default_rng(0)
    n = 40
    arrays = {name: rng.normal(size=(n, len(labels))) for name, labels in COLUMNS.items()}
    arrays["attitude"] = rotations.normalize(arrays["attitude"])
    return Reference(t=0.01 * np.arange(n), **arrays)


def test_a_reference_comes_back_as_it_was_written(reference, tmp_path):
    path = tmp_path / "deep" / "reference.csv"
    reference.write(path)
    back = read_reference(path)
    assert back.dt == pytest.approx(0.01)
    for name in ("t", *COLUMNS):
        assert np.allclose(getattr(back, name), getattr(reference, name), rtol=1e-11, atol=1e-11), name
    assert [p.name for p in path.parent.iterdir()] == ["reference.csv"]


def test_the_file_holds_the_columns_of_the_format(reference, tmp_path):
    reference.write(tmp_path / "r.csv")
    header = (tmp_path / "r.csv").read_text().splitlines()[0].split(",")
    assert header[:8] == ["t", "ref_px", "ref_py", "ref_pz", "ref_qw", "ref_qx", "ref_qy", "ref_qz"]
    assert len(header) == 20


def test_attitudes_are_normalised_on_reading(reference, tmp_path):
    table = reference.table()
    table[list(COLUMNS["attitude"])] *= 1.001
    table.to_csv(tmp_path / "r.csv", index=False)
    assert np.allclose(np.linalg.norm(read_reference(tmp_path / "r.csv").attitude, axis=1), 1.0)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f: f.drop(columns=["ref_wx", "ref_wz"]), "no columns ref_wx, ref_wz"),
        (lambda f: f.assign(ref_px=np.nan), "holds cells that are not numbers"),
        (lambda f: f.drop(index=7), "t is not uniform"),
        (lambda f: f.iloc[::-1], "t is not uniform"),
    ],
)
def test_what_is_not_a_reference_is_refused_in_one_line(reference, tmp_path, change, says):
    path = tmp_path / "r.csv"
    change(reference.table()).to_csv(path, index=False)
    with pytest.raises(InputError, match=says) as caught:
        read_reference(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("rows", [0, 1])
def test_too_few_rows_are_refused(reference, tmp_path, rows):
    path = tmp_path / "r.csv"
    reference.table().head(rows).to_csv(path, index=False)
    with pytest.raises(InputError):
        read_reference(path)


def test_text_in_a_column_is_refused(reference, tmp_path):
    path = tmp_path / "r.csv"
    pd.DataFrame(reference.table().astype(object)).assign(ref_py="here").to_csv(path, index=False)
    with pytest.raises(InputError, match="holds cells that are not numbers") as caught:
        read_reference(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="Check the path"):
        read_reference(tmp_path / "none.csv")
