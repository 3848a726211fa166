"""Bags, which are folders."""

import base64
import shutil
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pytest
from app_server import Server
from writers_bag import write_bag2

from infotraj.flight import read_flight

TOP = Path(__file__).parents[2]
QUAD = TOP / "examples/quad"


def test_a_ros_2_bag_is_a_folder_and_one_log(server, tmp_path):
    flight = read_flight(QUAD / "flight_0.parquet")
    for axis in "xyz":  # the writer's messages hold velocities, too
        flight.table[f"v{axis}"] = np.gradient(flight.table[f"p{axis}"], flight.t)
    write_bag2(flight, server.folder / "run.1")
    window = server.window()
    (row,) = server.state(window)["listed"]
    assert row["name"] == "run.1"
    assert row["kind"] == "log"
    assert row["size"] > 100_000
    assert server.act(window, "check", name="run.1/metadata.yaml")[0] == 400
    assert server.act(window, "check", name="run.1")[0] == 200
    state = server.finished(window)
    assert state["files"]["run.1"]["name"] == "run.1.parquet", state["files"]
    assert [r["name"] for r in state["listed"]] == ["run.1", "run.1.parquet"]
    assert len(read_flight(server.folder / "run.1.parquet").table) > 500
    # A part that lies elsewhere: no bag.
    (part,) = (server.folder / "run.1").glob("*.mcap")
    shutil.move(part, tmp_path / part.name)
    part.symlink_to(tmp_path / part.name)
    assert not [r for r in server.state(window)["listed"] if r["kind"] == "log"]
    assert server.act(window, "check", name="run.1")[0] == 400


@pytest.fixture
def bag(tmp_path):
    flight = read_flight(QUAD / "flight_0.parquet")
    for axis in "xyz":  # the writer's messages hold velocities, too
        flight.table[f"v{axis}"] = np.gradient(flight.table[f"p{axis}"], flight.t)
    write_bag2(flight, tmp_path / "run.1")
    return tmp_path / "run.1"


@pytest.mark.long
def test_a_bag_is_dropped_as_a_folder_or_chosen_and_becomes_a_flight(server, chromium, bag, tmp_path):
    tab = chromium.new_page()
    complaints = []
    tab.on("pageerror", lambda e: complaints.append(str(e)))
    tab.goto(server.address)
    tab.locator("#choose-folder").set_input_files(bag)
    tab.locator("tr[data-name='run.1.parquet'] .passed").wait_for(timeout=60000)
    assert tab.locator("tr[data-name='run.1.parquet'] input").first.is_checked()
    # What a browser hands over of a dropped folder: entries, read in turns until nothing comes.
    tab.evaluate(
        """async (names) => {
      const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
      const made = names.map(([name, text]) => new File([bytes(text)], name));
      const files = made.map((file) => ({isFile: true, name: file.name, file: (take) => take(file)}));
      const turns = [files.slice(0, 1), files.slice(1), []];
      const folder = {isFile: false, name: "run.1", createReader: () => ({readEntries: (take) => take(turns.shift())})};
      const event = new Event("drop", {cancelable: true});
      event.dataTransfer = {items: [{webkitGetAsEntry: () => folder}], files: []};
      document.getElementById("drop").dispatchEvent(event);
    }""",
        [[p.name, base64.b64encode(p.read_bytes()).decode()] for p in sorted(bag.iterdir(), reverse=True)],
    )
    tab.locator("tr[data-name='run-2.1.parquet'] .passed").wait_for(timeout=60000)
    assert sorted(p.name for p in (server.folder / "run-2.1").iterdir()) == sorted(p.name for p in bag.iterdir())
    # Another folder: what can be read of it, and no word of the rest.
    other = tmp_path / "day"
    other.mkdir()
    shutil.copy(QUAD / "vehicle.yaml", other)
    (other / "notes.pdf").write_bytes(b"%PDF")
    tab.locator("#choose-folder").set_input_files(other)
    tab.locator("#model-said:not(:empty)").wait_for(timeout=60000)
    assert tab.locator("#error").is_hidden()
    assert not complaints


def test_a_bag_comes_with_its_metadata_first_and_names_that_are_only_names(tmp_path, bag):
    folder = tmp_path / "flights"
    folder.mkdir()
    server = Server(folder, "--upload-limit", "1")
    (part,) = bag.glob("*.mcap")
    metadata = (bag / "metadata.yaml").read_bytes()
    window = server.window()

    def sent(name, content):
        return server.ask("POST", f"{window}/upload?bag&name={quote(name, safe='')}", content)[0]

    assert sent(part.name, b"x") == 400  # no metadata
    assert server.act(window, "bag", name="run")[0] == 400
    assert sent("metadata.yaml", metadata) == 200
    for name in ("../x.mcap", "a/b.mcap", "x.py", "x .mcap", "..mcap"):
        assert sent(name, b"x") == 400, name
    assert server.act(window, "bag", name="run")[0] == 400  # no part
    assert sent("metadata.yaml", metadata) == 200
    assert sent(part.name, bytes(700_000)) == 200
    assert sent("second.mcap", bytes(700_000)) in (400, 413)  # all of it counts
    assert list(folder.glob("[!.]*")) == []
    status, said = server.act(window, "bag", name="../../run of today")
    assert (status, said["name"]) == (200, "run_of_today")
    assert sorted(p.name for p in (folder / "run_of_today").iterdir()) == sorted(["metadata.yaml", part.name])
    assert server.act(window, "bag", name="run")[0] == 400  # it is taken once
    server.close()
