"""The app's way from a dropped log to a saved model, in a browser; windows beside each other."""

import re
import shutil
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import yaml
from app_server import filled

from infotraj.trajectories.reference import read_reference

TOP = Path(__file__).parents[2]
QUAD = TOP / "examples/quad"


@pytest.mark.long
def test_the_whole_way_from_a_dropped_log_to_a_saved_model(server, chromium, tmp_path):
    from playwright.sync_api import expect

    context = chromium.new_context(accept_downloads=True, viewport={"width": 1400, "height": 1000})
    tab = context.new_page()
    complaints, asked = [], []
    tab.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    tab.on("pageerror", lambda e: complaints.append(str(e)))
    tab.on("request", lambda r: asked.append(r.url))
    tab.goto(server.address)
    expect(tab.get_by_text("Nothing is in this folder yet")).to_be_visible()
    expect(tab.locator("#files")).to_be_hidden()
    # A broken log first: its finding is on the page, and the rest goes on.
    broken = tmp_path / "broken.parquet"
    broken.write_bytes((QUAD / "flight_0.parquet").read_bytes()[:5000])
    tab.locator("#choose").set_input_files(
        [broken, *(QUAD / f"flight_{k}.parquet" for k in range(3)), QUAD / "vehicle.yaml"]
    )
    row = tab.locator("tr[data-name='broken.parquet']")
    row.locator(".rejected").wait_for(timeout=60000)
    expect(tab.locator("#nothing")).to_be_hidden()
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
    frame = tab.frame_locator("#report")
    frame.locator("html[data-complete=yes]").wait_for(state="attached", timeout=60000)
    # The verdict is said once, by the report; the window's title has it, too.
    assert frame.locator("h1").inner_text() == "Missing: rotor_effectiveness."
    assert "rotor_effectiveness" not in tab.locator("main").inner_text()
    assert tab.title() == "infotraj: Missing: rotor_effectiveness."
    bar = frame.locator("table.bars[data-axis=tx] tr.now")
    before = float(bar.get_attribute("data-value"))
    frame.locator("#falls-box-0").uncheck()
    assert float(bar.get_attribute("data-value")) > 50 * before
    # With nothing ticked there is nothing to save; with the effect the model is written.
    tab.locator("#save").click()
    expect(tab.locator("#error")).to_contain_text("Nothing is ticked", timeout=60000)
    frame.locator("#falls-box-0").check()
    tab.locator("#new-name").fill("improved")
    tab.locator("#save").click()
    expect(tab.locator("#note")).to_have_text("improved.yaml is written")
    model = yaml.safe_load((server.folder / "improved.yaml").read_text())
    (effect,) = model["effects"]
    assert effect["name"] == "rotor_effectiveness"
    assert effect["parameters"]["factor"] == pytest.approx(0.856, abs=0.002)
    with tab.expect_download() as download:
        tab.locator("#download").click()
    sent = Path(download.value.path()).read_text()
    assert "Missing: rotor_effectiveness." in sent
    assert "infotraj_app" not in sent
    assert "new.yaml" in sent
    # The next flight is designed in the room that is given; the report shows it, and no one takes it for a flight.
    (server.folder / "next.csv").write_text("t,ref_px,mine\n")
    # What was said of the last file goes when the next thing is refused.
    tab.locator("#box").fill("1x1x0.5")
    tab.locator("#seconds").fill("-3")
    tab.locator("#design").click()
    expect(tab.locator("#error")).to_contain_text("expected a positive time in s")
    expect(tab.locator("#note")).to_be_empty()
    complaints.clear()  # the browser's own word for what the server refuses
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
    status, said = server.act(first, "cancel")
    assert status == 200
    assert said["job"]["state"] == "cancelled"
    assert said["job"]["seconds"] > 0.0  # it has not gone yet
    state = server.finished(first)
    assert state["job"]["state"] == "cancelled"
    assert state["answer"] is None
    written = {p.name for p in server.folder.iterdir() if not p.name.startswith(".")}
    assert written == {"vehicle.yaml", *(f"flight_{k}.parquet" for k in range(3))}


def test_one_box_asks_all_flights_but_the_healthy_ones(server, chromium):
    from playwright.sync_api import expect

    filled(server.folder)
    tab = chromium.new_page()
    tab.goto(server.address)
    asked = [tab.get_by_label(f"Ask flight_{k}.parquet") for k in range(3)]
    every = tab.locator("#ask-all")
    expect(asked[2]).to_be_visible()
    expect(every).not_to_be_checked()
    tab.get_by_label("Healthy flight_0.parquet").check()
    every.check()
    expect(tab.get_by_label("Healthy flight_0.parquet")).to_be_checked()
    assert [one.is_checked() for one in asked] == [False, True, True]
    asked[1].uncheck()
    assert every.evaluate("one => one.indeterminate")
    asked[1].check()
    assert every.is_checked()
    every.uncheck()
    assert [one.is_checked() for one in asked] == [False, False, False]
    tab.close()


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


@pytest.mark.long
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
