"""A file that is no YAML is told from one that is not there and from a flight given in its place."""

import pytest

from infotraj.errors import InputError
from infotraj.models.file import read_model
from infotraj.vehicle import load_vehicle


@pytest.mark.parametrize("read", [read_model, load_vehicle])
@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "there is no such file"),
        (b"PAR1\x15\x9e\xff", "MODEL comes before FLIGHT"),
        (b"a: [", "cannot be read as YAML"),
    ],
)
def test_what_is_wrong_with_the_file_is_one_line(tmp_path, read, content, says):
    path = tmp_path / "vehicle.yaml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as refused:
        read(path)
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)
    assert "Errno" not in str(refused.value)
