"""Logs that the app imports, and those that need a mapping or a fix."""

import os
import shutil
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pytest
import yaml
from flights_made import made_flight
from writers_crazyflie import floats, micro_sd
from writers_ulog import write_ulog

from infotraj.flight import read_flight

TOP = Path(__file__).parents[2]
QUAD = TOP / "examples/quad"


def test_a_log_is_imported_and_a_damaged_one_told(server):
    window = server.window()
    log = (QUAD / "log/board.csv").read_bytes()
    for name, body in (
        ("board.csv", log),
        ("noise.ulg", os.urandom(4000)),
        ("vehicle.yaml", b"mass: [1, 2"),
        ("e.bag", b""),
    ):
        status, _, said = server.ask("POST", f"{window}/upload?name={name}", body)
        assert status == 200, said
        assert server.act(window, "check", name=name)[0] == 200
        found = server.finished(window)["files"][name]
        assert found["outcome"] == "rejected", found
        assert name in found["report"]
        assert "Traceback" not in found["report"]
    assert server.process.poll() is None


def crazyflie_log(path):
    """A log as the Crazyflie's card holds it: its name has no suffix."""
    flight = made_flight(3.0)
    columns = {**floats("stateEstimate.", "x y z", flight.get("px", "py", "pz"))}
    columns |= floats("gyro.", "x y z", np.degrees(flight.get("wx", "wy", "wz")))
    columns |= floats("stateEstimate.q", "w x y z", flight.get("qw", "qx", "qy", "qz"))
    return micro_sd(path, flight.t, columns)


@pytest.mark.long
def test_a_log_without_a_suffix_is_told_by_its_first_bytes(server, chromium, tmp_path):
    from playwright.sync_api import expect

    log = crazyflie_log(tmp_path / "log07")
    crazyflie_log(server.folder / "there already")
    (server.folder / "notes").write_text("no log at all\n")
    os.mkfifo(server.folder / "pipe")  # nobody writes to it: whoever opens it waits forever
    tab = chromium.new_page()
    tab.goto(server.address)
    tab.locator("#choose").set_input_files(log)  # at once, before the page knows the folder
    row = tab.locator("tr[data-name='log07']")
    expect(row.locator("summary")).to_contain_text("imported as log07.parquet", timeout=60000)
    assert tab.get_by_label("Ask log07.parquet").is_checked()
    assert (server.folder / "log07").read_bytes() == log.read_bytes()
    assert read_flight(server.folder / "log07.parquet").table["pz"].notna().any()
    # What lies in the folder is found by its first bytes, too; what is no log is not listed.
    names = tab.locator("#files tbody tr").evaluate_all("rows => rows.map(r => r.dataset.name)")
    assert names == ["log07", "log07.parquet", "there already"]
    # Of what is none nothing is kept, and the reason is on the page.
    (tmp_path / "log08").write_text("no log at all\n")
    tab.locator("#choose").set_input_files(tmp_path / "log08")
    expect(tab.locator("#error")).to_contain_text("log08: no known suffix, and no known log", timeout=60000)
    assert not (server.folder / "log08").exists()
    # The reason stands while what came with it is looked at, and two are both told.
    crazyflie_log(tmp_path / "log10")
    (tmp_path / "log11").write_text("none either\n")
    tab.locator("#choose").set_input_files([tmp_path / "log08", tmp_path / "log11", tmp_path / "log10"])
    expect(tab.locator("tr[data-name='log10.parquet']")).to_have_count(1, timeout=60000)
    assert all(name in tab.locator("#error").inner_text() for name in ("log08: no known", "log11: no known"))
    # In a folder that is dropped it is looked for quietly.
    dropped = tmp_path / "card"
    dropped.mkdir()
    crazyflie_log(dropped / "log09")
    (dropped / "LICENSE").write_text("no log at all\n")
    tab.locator("#choose-folder").set_input_files(dropped)
    expect(tab.locator("tr[data-name='log09.parquet']")).to_have_count(1, timeout=60000)
    expect(tab.locator("#error")).to_be_hidden()
    tab.close()


@pytest.mark.parametrize(
    ("name", "written"),
    [("FLIGHT.01", "FLIGHT_01"), ("../../run.sh", "run_sh"), (".bashrc", "bashrc"), ("a b<c>", "a_b_c")],
)
def test_a_log_of_any_other_name_has_no_suffix_in_the_folder(server, tmp_path, name, written):
    body = crazyflie_log(tmp_path / "log").read_bytes()
    window = server.window()
    status, _, said = server.ask("POST", f"{window}/upload?name={quote(name, safe='')}", body)
    assert status == 200, said
    assert [p.name for p in server.folder.iterdir() if not p.name.startswith(".")] == [written]
    assert server.act(window, "check", name=written)[0] == 200
    assert server.finished(window)["files"][written]["name"] == f"{written}.parquet"


@pytest.mark.long
def test_a_log_that_is_not_recognised_is_given_a_mapping_mended_and_asked(server, chromium):
    from playwright.sync_api import expect

    shutil.copy(QUAD / "log/board.yaml", server.folder)
    shutil.copy(QUAD / "vehicle.yaml", server.folder)
    original = (QUAD / "log/board.csv").read_bytes()
    tab = chromium.new_page()
    complaints = []
    tab.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    tab.on("pageerror", lambda e: complaints.append(str(e)))
    tab.goto(server.address)
    tab.locator("#choose").set_input_files(QUAD / "log/board.csv")
    row = tab.locator("tr[data-name='board.csv']")
    expect(row.locator("pre")).to_contain_text("no known layout", timeout=60000)
    # A mapping of the folder comes first; it is no model.
    choice = row.get_by_label("Mapping of board.csv")
    expect(choice.locator("option").first).to_have_text("board.yaml", timeout=60000)
    assert "euroc" in choice.locator("option").all_inner_texts()
    assert "px4_ulog" not in choice.locator("option").all_inner_texts()
    assert tab.locator("#model option").all_inner_texts() == ["vehicle.yaml"]
    expect(row.get_by_role("button", name="Fix board.csv")).to_have_count(0)
    row.get_by_role("button", name="Import board.csv").click()
    # Its rates are in deg/s: rejected, and Fix says what it would set.
    expect(row.locator("pre")).to_contain_text("rate_unit", timeout=60000)
    mend = row.get_by_role("button", name="Fix board.csv")
    assert "A setting mends this in a new flight beside it: rate.scale=0.0174533" in row.inner_text()
    assert not (server.folder / "board.parquet").exists()
    # On a phone every row is whole: nothing has to be found by scrolling sideways.
    tab.set_viewport_size({"width": 400, "height": 900})
    right = "b => b.map(x => x.getBoundingClientRect().right)"
    assert max(tab.locator("#files button, #files input").evaluate_all(right)) <= 400
    assert tab.evaluate("document.documentElement.scrollWidth") == 400
    mend.click()
    expect(row.locator("summary")).to_contain_text("mended as board-fixed.parquet", timeout=60000)
    expect(row.get_by_role("button", name="Fix board.csv")).to_have_count(0)
    made = tab.locator("tr[data-name='board-fixed.parquet']")
    assert made.locator("summary").inner_text().split(" for ")[0] in ("passed", "warning")
    assert "set rate.scale=0.0174533" in made.locator("pre").text_content()
    assert made.get_by_label("Ask board-fixed.parquet").is_checked()
    assert complaints == []
    tab.close()
    assert (server.folder / "board.csv").read_bytes() == original
    saved = yaml.safe_load((server.folder / "board-fixed.mapping.yaml").read_text())
    assert saved["extends"] == "board.yaml"
    assert saved["set"]["rate"]["scale"] == pytest.approx(0.0174533)
    assert read_flight(server.folder / "board-fixed.parquet").table["wx"].abs().max() < 10.0


@pytest.mark.long
def test_a_log_is_offered_mappings_that_read_its_kind(server, chromium):
    from playwright.sync_api import expect

    write_ulog(made_flight(3.0), server.folder / "x.ulg")
    shutil.copy(QUAD / "log/board.yaml", server.folder)
    (server.folder / "mine.yaml").write_text("extends: px4_ulog\n")
    window = server.window()
    assert server.act(window, "check", name="x.ulg", mapping="board.yaml")[0] == 200
    found = server.finished(window)["files"]["x.ulg"]
    assert (found["outcome"], found["kind"]) == ("rejected", "ulog")
    tab = chromium.new_page()
    tab.goto(server.address)
    choice = tab.get_by_label("Mapping of x.ulg")
    # Of those of the folder it is not known at once what they read.
    expect(choice.locator("option").first).to_have_text("mine.yaml", timeout=60000)
    expect(choice.get_by_text("board.yaml")).to_have_count(0)
    expect(choice).to_have_value("mine.yaml")
    assert choice.locator("option").all_inner_texts()[1:] == found["mappings"]
    assert "px4_ulog" in found["mappings"]
    tab.close()


@pytest.mark.long
def test_a_fix_overwrites_nothing_and_is_only_of_what_was_offered(server):
    # A flight table in deg/s, and files of the names that its mended form would take.
    flight = read_flight(QUAD / "flight_0.parquet")
    flight.table[["wx", "wy", "wz"]] *= 57.2957795
    flight.write(server.folder / "wrong.parquet")
    taken = {"wrong-fixed.parquet": b"mine", "wrong-fixed-2.mapping.yaml": b"mine, too"}
    for name, body in taken.items():
        (server.folder / name).write_bytes(body)
    before = (server.folder / "wrong.parquet").read_bytes()
    window = server.window()
    for name in ("wrong.parquet", "../wrong.parquet", "--fix", None):
        assert server.act(window, "fix", name=name)[0] == 400, name
    assert server.act(window, "check", name="wrong.parquet")[0] == 200
    found = server.finished(window)["files"]["wrong.parquet"]
    assert found["outcome"] == "rejected"
    assert found["fix"]
    assert found["mappings"] == []
    assert server.act(window, "fix", name="wrong.parquet")[0] == 200
    state = server.finished(window)
    assert state["files"]["wrong.parquet"]["fixed"] == "wrong-fixed-3.parquet"
    assert state["files"]["wrong-fixed-3.parquet"]["outcome"] in ("passed", "warning")
    assert (server.folder / "wrong.parquet").read_bytes() == before
    assert {name: (server.folder / name).read_bytes() for name in taken} == taken
    mended = read_flight(server.folder / "wrong-fixed-3.parquet").table
    true = read_flight(QUAD / "flight_0.parquet").table
    assert mended["wx"].to_numpy() == pytest.approx(true["wx"].to_numpy(), rel=1e-6)
    assert server.act(window, "fix", name="wrong.parquet")[0] == 400


@pytest.mark.parametrize(
    "text",
    ["extends: ../outside.yaml\n", "extends: inner.yaml\n", "extends: euroc\ndefinitions: [../outside.yaml]\n"],
)
def test_a_mapping_that_points_out_of_the_folder_is_refused(server, tmp_path, text):
    shutil.copy(QUAD / "log/board.yaml", tmp_path / "outside.yaml")
    shutil.copy(QUAD / "log/board.csv", server.folder)
    (server.folder / "inner.yaml").write_text("extends: ../outside.yaml\n")
    (server.folder / "mine.yaml").write_text(text)
    window = server.window()
    assert server.act(window, "check", name="board.csv", mapping="mine.yaml")[0] == 200
    found = server.finished(window)["files"]["board.csv"]
    assert found["outcome"] == "rejected"
    assert "outside the folder" in found["report"]
    for mapping in ("../outside.yaml", "px4_ulog", str(tmp_path / "outside.yaml"), "board.csv", "--fix", ["mine.yaml"]):
        assert server.act(window, "check", name="board.csv", mapping=mapping)[0] == 400, mapping
