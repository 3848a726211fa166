"""What the app refuses: names, uploads, other pages, paths out of its folder."""

import http.client
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import quote

import pytest
from app_server import Server, filled

from infotraj.app.folder import MODELS, Folder, safe_name
from infotraj.app.window import Window
from infotraj.errors import UsageError

TOP = Path(__file__).parents[2]
QUAD = TOP / "examples/quad"


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


@pytest.mark.parametrize("name", ["x.pkl", "x.pickle", "x.npy", "x.py", "x", "x.parquet.exe", "Makefile", ".profile"])
def test_what_could_run_is_not_taken(server, name):
    status, _, said = server.ask("POST", f"{server.window()}/upload?name={quote(name, safe='')}", b"cos\nsystem\n")
    assert status == 400
    assert "expected .parquet, .csv" in json.loads(said)["error"]
    assert [p for p in server.folder.iterdir() if not p.name.startswith(".")] == []


@pytest.mark.parametrize("name", ["", "x.yaml/", "..", "///", "\x00"])
def test_a_name_of_nothing_is_refused(server, name):
    status, _, said = server.ask("POST", f"{server.window()}/upload?name={quote(name, safe='')}", b"\xbc\x02\x00")
    assert status == 400
    assert "a file without a name" in json.loads(said)["error"]
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
    with pytest.raises(UsageError, match=r"no room; expected three|no flight time; expected a positive"):
        window.design(box, seconds)
    assert window.job is None


@pytest.mark.parametrize("seconds", ["-3", "0", "nan", "inf", "soon"])
def test_a_flight_time_is_positive(tmp_path, seconds):
    (tmp_path / "work").mkdir()
    window = Window("key", Folder(tmp_path, tmp_path / "work"))
    window.asked = {"model": Path("vehicle.yaml"), "flights": [], "reference": False}
    window.answer = {"number": 1, "summary": "", "boxes": [], "reference": False}
    with pytest.raises(UsageError, match="no flight time; expected a positive time"):
        window.design("2x2x1", seconds)


def test_what_is_not_ticked_is_not_saved(tmp_path, monkeypatch):
    """All that was named is written as the diagnosis wrote it; of a part of it the numbers are fitted anew."""
    (tmp_path / "work").mkdir()
    window, started = Window("key", Folder(tmp_path, tmp_path / "work")), []
    monkeypatch.setattr(window, "_start", started.append)
    window.asked = {"model": Path("vehicle.yaml"), "flights": [Path("a.csv")], "reference": False}
    boxes = [["mass_offset"], ["rotor_effectiveness 2"]]
    window.answer = {"number": 1, "summary": "", "boxes": boxes, "reference": False}
    (window.work / "new.yaml").write_text("both")
    window.save("one.yaml", ["rotor_effectiveness 2"])
    (job,) = started
    assert job.words[2:] == [
        "add", "vehicle.yaml", "rotor_effectiveness:2", "--fit", "a.csv", "-o", "one.yaml",
    ]  # fmt: skip
    assert not (tmp_path / "one.yaml").exists()
    window.save("all.yaml", ["rotor_effectiveness 2", "mass_offset"])
    assert (tmp_path / "all.yaml").read_text() == "both"
    assert len(started) == 1
    # A name without a suffix is given one; without a name nothing is written.
    window.save("evil", ["rotor_effectiveness 2", "mass_offset"])
    assert window.note == "evil.yaml is written"
    for name, said in (("", "a model without a name"), (None, "a model without a name"), ("evil.txt", ".txt")):
        with pytest.raises(UsageError, match=said):
            window.save(name, ["rotor_effectiveness 2", "mass_offset"])


def test_the_recording_after_a_diagnosis_holds_the_new_model_and_the_one_as_given(tmp_path, monkeypatch):
    (tmp_path / "work").mkdir()
    window, started = Window("key", Folder(tmp_path, tmp_path / "work")), []
    monkeypatch.setattr(window, "_start", started.append)
    window.asked = {"model": Path("vehicle.yaml"), "flights": [Path("a.csv")], "reference": False}
    (window.work / "new.yaml").write_text("a model")
    end = ["a.csv", "--recording", "work/key/worst.rrd"]
    for boxes, models in (
        ([["mass_offset"]], ["work/key/new.yaml", "--against", "vehicle.yaml"]),
        ([], ["vehicle.yaml"]),
    ):
        window.answer = {"number": 1, "summary": "", "boxes": boxes, "reference": False}
        window.record()
        assert started.pop().words[2:] == ["compare", *models, *end]


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
