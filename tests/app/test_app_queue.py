"""What the page looks at by itself, in which order, and what ends it."""

import re
import shutil
from pathlib import Path

import pytest
from app_server import filled

QUAD = Path(__file__).parents[2] / "examples/quad"


@pytest.mark.long
def test_a_reload_ends_nothing_and_cancel_ends_all(server, chromium):
    from playwright.sync_api import expect

    for name in ("a.yaml", "b.yaml"):
        shutil.copy(QUAD / "vehicle.yaml", server.folder / name)
    tab = chromium.new_page()
    tab.goto(server.address)
    said = [tab.locator(f"tr[data-name='flight_{k}.parquet'] summary") for k in range(3)]
    tab.locator("#choose").set_input_files([QUAD / f"flight_{k}.parquet" for k in range(3)])
    tab.locator("tr[data-name='flight_2.parquet']").wait_for(timeout=60000)
    assert tab.locator("#files summary").count() < 3
    tab.reload()
    for k, one in enumerate(said):
        expect(one).to_have_text("passed for a.yaml", timeout=60000)
        expect(tab.get_by_label(f"Ask flight_{k}.parquet")).to_be_checked()
    # Of another model: Diagnose waits for nobody, and Cancel leaves nothing that would go on.
    tab.locator("#model").select_option("b.yaml")
    tab.locator("#cancel:not([disabled])").wait_for()
    expect(tab.locator("#diagnose")).to_be_enabled()
    tab.locator("#cancel").click()
    expect(tab.locator("#cancel")).to_be_disabled()
    tab.wait_for_timeout(1000)
    expect(tab.locator("#cancel")).to_be_disabled()
    assert [one.inner_text() for one in said].count("passed for a.yaml") >= 2
    # What is ticked is looked at for it; the others wait until they are.
    tab.locator("#ask-all").uncheck()
    tab.get_by_label("Ask flight_2.parquet").check()
    expect(said[2]).to_have_text("passed for b.yaml", timeout=60000)
    expect(tab.locator("#cancel")).to_be_disabled()
    expect(said[1]).to_have_text("passed for a.yaml")
    tab.close()


def test_a_diagnosis_goes_before_looking_at_files(server, chromium):
    from playwright.sync_api import expect

    filled(server.folder)
    tab = chromium.new_page()
    tab.goto(server.address)
    tab.locator("#ask-all").check()
    tab.locator("#diagnose").click()
    expect(tab.locator("#step")).to_contain_text("diagnosis running", timeout=60000)
    expect(tab.locator("#diagnose")).to_be_disabled()
    assert tab.locator("#files").get_by_text("not looked at").count() >= 1
    tab.close()


def test_a_model_that_cannot_be_read_is_told_at_once_and_no_other_one_replaces_what_was_chosen(server, chromium):
    from playwright.sync_api import expect

    right = (QUAD / "vehicle.yaml").read_text()
    (server.folder / "a.yaml").write_text(re.sub(r"(?m)^mass: .*", "mass: -1", right))
    (server.folder / "saved.yaml").write_text("vehicle: vehicle.yaml\neffects: []\n")
    (server.folder / "vehicle.yaml").write_text(right)
    tab = chromium.new_page()
    tab.goto(server.address)
    chosen, said = tab.locator("#model"), tab.locator("#model-said")
    # By default it is one that can be read, and one that was not saved by a diagnosis.
    expect(said).to_contain_text("4 rotors", timeout=60000)
    expect(chosen).to_have_value("vehicle.yaml")
    assert chosen.locator("option").all_inner_texts() == ["vehicle.yaml", "saved.yaml", "a.yaml"]
    chosen.select_option("a.yaml")
    expect(said).to_contain_text("a.yaml: mass: Input should be greater than 0")
    expect(tab.locator("#diagnose")).to_be_disabled()
    # It stays chosen, and is read again as soon as it is mended.
    (server.folder / "a.yaml").write_text(right)
    expect(said).to_contain_text("4 rotors", timeout=60000)
    expect(tab.locator("#diagnose")).to_be_enabled()
    chosen.select_option("vehicle.yaml")
    (server.folder / "0.yaml").write_text(right)
    tab.reload()
    expect(chosen.locator("option")).to_have_count(4)
    expect(chosen).to_have_value("vehicle.yaml")
    tab.close()
