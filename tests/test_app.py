"""The app: its whole way in a browser, hostile requests, and windows that do not disturb each other."""

import base64
import http.client
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import quote, urlsplit

import numpy as np
import pytest
import yaml
from app_server import Server
from writers_bag import write_bag2

from infotraj.app.folder import MODELS, Folder, safe_name
from infotraj.app.window import Window
from infotraj.errors import UsageError
from infotraj.flight import read_flight
from infotraj.trajectories.reference import read_reference

TOP = Path(__file__).parents[1]
QUAD = TOP / "examples/quad"


@pytest.fixture
def server(tmp_path):
    folder = tmp_path / "flights"
    folder.mkdir()
    one = Server(folder)
    yield one
    one.close()
    left = {p.name for p in folder.iterdir() if p.name.startswith(".")}
    assert left == set(), "what the server wrote for itself is still there"


def filled(folder):
    for k in range(3):
        shutil.copy(QUAD / f"flight_{k}.parquet", folder)
    shutil.copy(QUAD / "vehicle.yaml", folder)


def test_the_whole_way_from_a_dropped_log_to_a_saved_model(server, chromium, tmp_path):
    from playwright.sync_api import expect

    context = chromium.new_context(accept_downloads=True, viewport={"width": 1400, "height": 1000})
    tab = context.new_page()
    complaints, asked = [], []
    tab.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    tab.on("pageerror", lambda e: complaints.append(str(e)))
    tab.on("request", lambda r: asked.append(r.url))
    tab.goto(server.address)
    # A broken log first: its finding is on the page, and the rest goes on.
    broken = tmp_path / "broken.parquet"
    broken.write_bytes((QUAD / "flight_0.parquet").read_bytes()[:5000])
    tab.locator("#choose").set_input_files(
        [broken, *(QUAD / f"flight_{k}.parquet" for k in range(3)), QUAD / "vehicle.yaml"]
    )
    row = tab.locator("tr[data-name='broken.parquet']")
    row.locator(".rejected").wait_for(timeout=60000)
    assert "broken.parquet" in row.locator("pre").inner_text()
    assert row.get_by_label("Mapping of").count() == 0  # none would mend it
    for k in range(3):
        tab.locator(f"tr[data-name='flight_{k}.parquet'] .passed").wait_for(timeout=60000)
    # What is rejected cannot be asked, and is not.
    expect(row.locator("input[type=checkbox]")).to_have_count(0)
    expect(tab.locator("#model-said")).to_contain_text("4 rotors", timeout=60000)
    # Cancelled, and asked again.
    tab.locator("#diagnose").click()
    tab.locator("#cancel:not([disabled])").click()
    expect(tab.locator("#step")).to_contain_text("diagnosis cancelled", timeout=60000)
    tab.locator("#diagnose:not([disabled])").click()
    expect(tab.locator("#step")).to_contain_text("diagnosing 3 flights", timeout=60000)
    tab.locator("#answer").wait_for(timeout=180000)
    assert tab.locator("#summary").inner_text() == "Missing: rotor_effectiveness."
    frame = tab.frame_locator("#report")
    frame.locator("html[data-complete=yes]").wait_for(state="attached", timeout=60000)
    bar = frame.locator("table.bars[data-axis=tx] tr.now")
    before = float(bar.get_attribute("data-value"))
    frame.locator("#falls-box-0").uncheck()
    assert float(bar.get_attribute("data-value")) > 50 * before
    # With nothing ticked there is nothing to save; with the effect the model is written.
    tab.locator("#save").click()
    expect(tab.locator("#error")).to_contain_text("Nothing is ticked", timeout=60000)
    frame.locator("#falls-box-0").check()
    tab.locator("#save").click()
    expect(tab.locator("#note")).to_have_text("improved.yaml is written")
    model = yaml.safe_load((server.folder / "improved.yaml").read_text())
    (effect,) = model["effects"]
    assert effect["name"] == "rotor_effectiveness"
    assert effect["parameters"]["factor"] == pytest.approx(0.856, abs=0.002)
    with tab.expect_download() as download:
        tab.locator("#download").click()
    assert "Missing: rotor_effectiveness." in Path(download.value.path()).read_text()
    # The next flight is designed in the room that is given; the report shows it, and no one takes it for a flight.
    (server.folder / "next.csv").write_text("t,ref_px,mine\n")
    tab.locator("#box").fill("1x1x0.5")
    tab.locator("#seconds").fill("8")
    tab.locator("#design").click()
    expect(tab.locator("#note")).to_contain_text("next-2.csv is written", timeout=120000)
    frame.locator("html[data-complete=yes]").wait_for(state="attached", timeout=60000)
    expect(frame.locator("#next")).to_contain_text("next-2.csv: 8 s")
    assert frame.locator("[data-root=next-above] canvas").count() > 0
    assert read_reference(server.folder / "next-2.csv").t[-1] == pytest.approx(8.0)
    assert (server.folder / "next.csv").read_text() == "t,ref_px,mine\n"
    assert tab.locator("tr[data-name^='next']").count() == 0
    # The recording is served by rerun's viewer, on this machine, under a policy that lets it ask no other.
    tab.locator("#record").click()
    tab.locator("#viewer:not([hidden])").wait_for(timeout=60000)
    page = tab.url.removeprefix(server.address.rstrip("/")) + "viewer/"
    for _ in range(100):
        status, headers, body = server.ask("GET", page)
        if status == 200:
            break
        time.sleep(0.1)
    assert b"re_viewer.js" in body
    allowed = re.search("connect-src ([^;]*);", headers["Content-Security-Policy"])[1].split()
    assert allowed[0] == "'self'"
    assert [urlsplit(a).hostname for a in allowed[1:]] == ["127.0.0.1"]
    assert server.ask("GET", page + "other.js")[0] == 404
    server.viewer = urlsplit(allowed[1]).port
    assert complaints == []
    outside = [u for u in asked if not u.startswith((server.address, "data:", "blob:"))]
    assert outside == []
    # A second window of the same browser knows the folder, and nothing of the first one's answer.
    second = context.new_page()
    second.goto(server.address)
    second.locator("tr[data-name='flight_0.parquet']").wait_for()
    assert second.locator("#answer").is_hidden()
    assert "improved.yaml" in second.locator("#model").inner_text()
    assert tab.locator("#answer").is_visible()
    context.close()


def test_two_windows_run_at_once_and_one_is_cancelled(server):
    filled(server.folder)
    first, second = server.window(), server.window()
    assert first != second
    ask = {"model": "vehicle.yaml", "flights": [f"flight_{k}.parquet" for k in range(3)]}
    assert server.act(first, "diagnose", **ask)[0] == 200
    assert server.act(second, "check", name="flight_1.parquet")[0] == 200
    status, said = server.act(first, "check", name="flight_0.parquet")
    assert status == 400
    assert "still running" in said["error"]
    assert server.finished(second)["files"]["flight_1.parquet"]["outcome"] == "passed"
    assert server.act(first, "cancel")[0] == 200
    state = server.finished(first)
    assert state["job"]["state"] == "cancelled"
    assert state["answer"] is None
    written = {p.name for p in server.folder.iterdir() if not p.name.startswith(".")}
    assert written == {"vehicle.yaml", *(f"flight_{k}.parquet" for k in range(3))}


def test_what_was_found_in_a_file_is_known_in_every_window_until_it_changes(server):
    log = server.folder / "broken.parquet"
    log.write_bytes((QUAD / "flight_0.parquet").read_bytes()[:5000])
    first = server.window()
    assert server.act(first, "check", name=log.name)[0] == 200
    assert server.finished(first)["files"][log.name]["outcome"] == "rejected"
    second = server.window()
    state = server.state(second)
    assert state["files"][log.name]["outcome"] == "rejected"
    assert state["job"] is None
    shutil.copy(QUAD / "flight_0.parquet", log)
    assert server.state(second)["files"] == {}
    assert server.state(first)["files"] == {}


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


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("../../evil.parquet", "evil.parquet"),
        ("..\\..\\evil.parquet", "evil.parquet"),
        ("/etc/cron.d/x.csv", "x.csv"),
        ("-rf.parquet", "rf.parquet"),
        (".hidden.csv", "hidden.csv"),
        ("a b<script>.csv", "a_b_script.csv"),
        ("x\x00y.csv", "x_y.csv"),
        ("x" * 400 + ".csv", "x" * 100 + ".csv"),
        ("....csv", "file.csv"),
        ("flight_0.parquet", "flight_0-2.parquet"),
    ],
)
def test_a_name_is_only_a_name(server, name, written):
    shutil.copy(QUAD / "flight_0.parquet", server.folder)
    before = (server.folder / "flight_0.parquet").read_bytes()
    status, _, said = server.ask("POST", f"{server.window()}/upload?name={quote(name, safe='')}", b"t,px\n0,1\n")
    assert status == 200, said
    assert json.loads(said)["name"] == written
    assert (server.folder / written).read_bytes() == b"t,px\n0,1\n"
    assert (server.folder / "flight_0.parquet").read_bytes() == before
    assert {p.name for p in server.folder.parent.iterdir()} == {"flights"}


@pytest.mark.parametrize("name", ["x.pkl", "x.pickle", "x.npy", "x.py", "x", "x.parquet.exe", "", "x.yaml/"])
def test_what_could_run_is_not_taken(server, name):
    status, _, said = server.ask("POST", f"{server.window()}/upload?name={quote(name, safe='')}", b"cos\nsystem\n")
    assert status == 400
    assert "expected .parquet, .csv" in json.loads(said)["error"]
    assert [p for p in server.folder.iterdir() if not p.name.startswith(".")] == []


def test_an_upload_is_limited_also_where_it_does_not_say_its_size(tmp_path):
    (tmp_path / "flights").mkdir()
    server = Server(tmp_path / "flights", "--upload-limit", "1")
    window = server.window()
    wire = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    chunks = (b"0,1\n" * 25000 for _ in range(30))
    try:
        wire.request("POST", f"{window}/upload?name=big.csv", chunks, {"Origin": server.origin}, encode_chunked=True)
        status = wire.getresponse().status
    except (ConnectionError, http.client.HTTPException):
        status = 400  # the server hung up while we were still sending
    finally:
        wire.close()
    assert status == 400
    assert server.ask("POST", f"{window}/upload?name=small.csv", b"0,1\n" * 250)[0] == 200
    assert {p.name for p in server.folder.iterdir() if not p.name.startswith(".")} == {"small.csv"}
    until = time.monotonic() + 20.0
    while list(server.folder.glob(".*/**/*.part")) and time.monotonic() < until:
        time.sleep(0.1)  # the connection that was hung up on is cleared away later than the next one answers
    assert list(server.folder.glob(".*/**/*.part")) == []
    server.close()


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1.evil.example:80"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": None},
        {"Sec-Fetch-Site": "cross-site"},
    ],
)
def test_only_its_own_page_may_ask(server, headers):
    filled(server.folder)
    window = server.window()
    body = json.dumps({"name": "flight_0.parquet"}).encode()
    assert server.ask("POST", f"{window}/check", body, **headers)[0] == 403
    assert server.ask("POST", f"{window}/upload?name=x.csv", b"1", **headers)[0] == 403
    assert server.state(window)["job"] is None
    assert not (server.folder / "x.csv").exists()
    if "Origin" not in headers:
        assert server.ask("GET", f"{window}/state", **headers)[0] == 403


def test_only_listed_files_are_used_and_no_other_is_served(server, tmp_path):
    filled(server.folder)
    secret = tmp_path / "secret.parquet"
    shutil.copy(QUAD / "flight_0.parquet", secret)
    (server.folder / "link.parquet").symlink_to(secret)
    window = server.window()
    for name in (
        "../secret.parquet",
        str(secret),
        "link.parquet",
        "./flight_0.parquet",
        "",
        None,
        {"a": 1},
        "vehicle.yaml",
    ):
        status, said = server.act(window, "diagnose", model="vehicle.yaml", flights=[name])
        assert status == 400, name
        assert "no file" in said["error"]
    assert server.act(window, "save", name="new.yaml", effects=[])[0] == 400
    assert server.act(window, "design", box="2x2x1", seconds="20")[0] == 400
    for path in (
        "/etc/passwd",
        f"{window}/../../etc/passwd",
        f"{window}/app.py",
        f"{window}/report",
        "/w/" + "A" * 32 + "/state",
    ):
        assert server.ask("GET", path)[0] == 404, path
    for body in (b"[1]", b"{", b'{"flights": "x"}'):
        assert server.ask("POST", f"{window}/diagnose", body)[0] == 400
    assert server.ask("POST", f"{window}/diagnose", b" " * 1_100_000)[0] in (400, 413)
    assert server.state(window)["job"] is None


def test_it_listens_on_this_machine_alone(server):
    listening = Path("/proc/net/tcp").read_text() if Path("/proc/net/tcp").exists() else None
    if listening is None:
        pytest.skip("no /proc/net/tcp on this system")
    places = [line.split()[1] for line in listening.splitlines()[1:] if line.split()[3] == "0A"]
    assert [p for p in places if p.endswith(f":{server.port:04X}")] == [f"0100007F:{server.port:04X}"]


def test_a_model_that_points_out_of_the_folder_is_refused(server, tmp_path):
    shutil.copy(QUAD / "vehicle.yaml", tmp_path / "outside.yaml")
    (server.folder / "model.yaml").write_text("vehicle: ../outside.yaml\neffects: []\n")
    window = server.window()
    server.act(window, "check", name="model.yaml")
    found = server.finished(window)["files"]["model.yaml"]
    assert found["outcome"] == "rejected"
    assert "outside the folder" in found["report"]


def test_a_folder_that_is_not_there_is_one_line(tmp_path):
    words = [sys.executable, "-m", "infotraj.cli", "app", str(tmp_path / "none"), "--port", "0", "--no-browser"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 3
    assert len(done.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("box", "seconds"), [("--json", "20"), ("2x2x1", "-o"), (None, None), ("2 x 2 x 1", "20"), ("", "")]
)
def test_a_room_is_numbers_and_no_option(tmp_path, box, seconds):
    (tmp_path / "work").mkdir()
    window = Window("key", Folder(tmp_path, tmp_path / "work"))
    window.asked = {"model": Path("vehicle.yaml"), "flights": [], "reference": False}
    window.answer = {"number": 1, "summary": "", "boxes": [], "reference": False}
    with pytest.raises(UsageError, match="no room"):
        window.design(box, seconds)
    assert window.job is None


def test_a_safe_name_has_one_of_the_suffixes(tmp_path):
    assert safe_name("../A model!.YAML", MODELS) == "A_model.yaml"
    with pytest.raises(UsageError):
        safe_name("model.yaml.txt", MODELS)
    folder = Folder(tmp_path, tmp_path)
    part = tmp_path / "part"
    for expected in ("a.yaml", "a-2.yaml", "a-3.yaml"):
        part.write_text(expected)
        assert folder.take(part, "a.yaml").name == expected
        assert (tmp_path / expected).read_text() == expected
        assert not part.exists()


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
    assert choice.locator("option").all_inner_texts()[0] == "board.yaml"
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


def test_a_log_is_checked_for_the_vehicle_that_is_chosen(server, chromium):
    from playwright.sync_api import expect

    shutil.copy(QUAD / "flight_0.parquet", server.folder)
    shutil.copy(QUAD / "vehicle.yaml", server.folder / "a.yaml")
    shutil.copy(TOP / "config/vehicles/acsl_x8.yaml", server.folder / "b.yaml")
    tab = chromium.new_page()
    tab.goto(server.address)
    tab.locator("#model").select_option("a.yaml")
    row = tab.locator("tr[data-name='flight_0.parquet']")
    row.get_by_role("button").click()
    expect(row.locator("summary")).to_have_text("passed for a.yaml", timeout=60000)
    tab.get_by_label("Ask flight_0.parquet").check()
    tab.locator("#model").select_option("b.yaml")
    # Of another vehicle it is rejected, and asked again as soon as the right one is chosen.
    expect(row.locator("summary")).to_have_text("rejected for b.yaml", timeout=60000)
    assert "8 rotors" in row.locator("pre").inner_text()
    expect(row.locator("input")).to_have_count(0)
    tab.locator("#model").select_option("a.yaml")
    expect(row.locator("summary")).to_have_text("passed for a.yaml", timeout=60000)
    expect(tab.get_by_label("Ask flight_0.parquet")).to_be_checked()
