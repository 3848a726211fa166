"""A served folder, empty at first."""

import pytest
from app_server import Server


@pytest.fixture
def server(tmp_path):
    folder = tmp_path / "flights"
    folder.mkdir()
    one = Server(folder)
    yield one
    one.close()
    left = {p.name for p in folder.iterdir() if p.name.startswith(".")}
    assert left == set(), "what the server wrote for itself is still there"
