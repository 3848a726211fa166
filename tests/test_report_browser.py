"""The report in a browser: everything is there, nothing leaves the page, and a tick changes bars and series."""

import json

import numpy as np
import pytest

from infotraj.comparing.equation_error import EquationError
from infotraj.diagnosis.report.steps import HeldOut
from infotraj.locating.windows import TimeWindow
from infotraj.report.again import read_content
from infotraj.report.combinations import Combinations
from infotraj.report.designed import beside, read_design
from infotraj.report.page import write_page
from infotraj.report.traces import flight_traces, read_part

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
SECTIONS = ("verdict", "data", "where", "missing", "falls", "leftover", "next", "provenance")
LINE = "(f => [...infotraj.model('series-{axis}').data.{line}].map(x => isFinite(x) ? x / f : null))"
LINE += "(infotraj.model('trace-{axis}').tags[0])"  # drawn in mN, told in N


class Opened:
    """A page that was opened from a file, with all that it asked for and complained about."""

    def __init__(self, chromium, path, **how):
        self.context = chromium.new_context(**({"viewport": {"width": 1400, "height": 900}} | how))
        self.tab = self.context.new_page()
        self.asked, self.complaints = [], []
        self.tab.on("request", lambda r: self.asked.append(r.url))
        self.tab.on("console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None)
        self.tab.on("pageerror", lambda e: self.complaints.append(str(e)))
        self.session = self.context.new_cdp_session(self.tab)
        self.session.send("Performance.enable", {"timeDomain": "threadTicks"})
        self.tab.goto(path.as_uri())
        self.tab.wait_for_selector("html[data-complete=yes]", state="attached", timeout=120000)

    @property
    def seconds(self):
        """CPU time (s) of the page's main thread until now: what else the machine does is no matter."""
        found = self.session.send("Performance.getMetrics")["metrics"]
        return next(m["value"] for m in found if m["name"] == "TaskDuration")

    def line(self, axis, line):
        """A series as it is drawn, NaN where there is none."""
        numbers = self.tab.evaluate(LINE.format(axis=axis, line=line))
        return np.array([np.nan if x is None else x for x in numbers])

    def bar(self, axis):
        """What is ticked: the value that the bar stands for, its width (share), and its text."""
        row = self.tab.locator(f"table.bars[data-axis={axis}] tr.now")
        width = row.locator(".fill").evaluate("e => parseFloat(e.style.width)")
        return float(row.get_attribute("data-value")), width, row.locator(".value").inner_text()


@pytest.fixture(scope="module")
def content(quad_report):
    return read_content(quad_report / "report.json")


@pytest.fixture
def opened(chromium, quad_report):
    page = Opened(chromium, quad_report / "report.html")
    yield page
    page.context.close()


def test_every_section_is_there_and_nothing_leaves_the_page(opened, content, quad_report):
    assert opened.tab.locator("main > section").evaluate_all("s => s.map(x => x.id)") == list(SECTIONS)
    assert opened.tab.locator("h1").inner_text() == content["answer"]["verdict"]["summary"]
    assert opened.complaints == []
    own = (quad_report / "report.html").as_uri()
    assert [u for u in opened.asked if not u.startswith(("data:", "blob:"))] == [own]
    # Six series, the places, six correlations: each drawn on a canvas that has a size.
    plots = opened.tab.locator(".plot")
    assert plots.count() == 12 + len(content["places"])
    sizes = plots.evaluate_all("p => p.map(x => x.clientWidth * x.clientHeight)")
    assert min(sizes) > 10000
    assert opened.tab.locator("#missing tbody tr").count() >= len(content["answer"]["effects"])
    # A canvas with nothing on it would be of one colour.
    drawn = opened.tab.locator("[data-root=trace-tx]").screenshot()
    assert len(drawn) > 3000


def test_a_tick_swaps_the_series_and_moves_the_bar(opened, content):
    fall, series = content["fall"], read_part(content["traces"]["flights"][0])["axes"]["tx"]
    value, width, said = opened.bar("tx")
    assert value == pytest.approx(fall["rmse"][1]["tx"])
    np.testing.assert_allclose(opened.line("tx", "ticked"), series["model"][1])
    opened.tab.locator("#falls-box-0").uncheck()
    off, wide, says = opened.bar("tx")
    assert off == pytest.approx(fall["rmse"][0]["tx"])
    assert wide == pytest.approx(width * off / value)
    assert says != said
    np.testing.assert_allclose(opened.line("tx", "ticked"), series["model"][0])
    np.testing.assert_allclose(opened.line("tx", "given"), series["model"][0])
    left = series["measured"] - series["model"][0]
    np.testing.assert_allclose(opened.line("tx", "left_ticked"), left, atol=1e-7)
    # Both rows of boxes say the same, and the sentence under them.
    assert not opened.tab.locator("#where-box-0").is_checked()
    assert "nothing beyond it" in opened.tab.locator("#shown").inner_text()
    assert opened.tab.evaluate("infotraj.ticked()") == []


def test_the_model_as_given_can_be_taken_out_of_the_figures(opened):
    seen = "infotraj.model('trace-fz').renderers.filter(r => r.visible).map(r => r.tags?.[1])"
    span = "(r => r.end - r.start)(infotraj.model('trace-fz').y_range)"
    assert set(opened.tab.evaluate(seen)) == {"measured", "given", "ticked"}
    wide = opened.tab.evaluate(span)
    opened.tab.locator("#given").uncheck()
    assert set(opened.tab.evaluate(seen)) == {"measured", "ticked"}
    for _ in range(100):  # what is left fills the figure; asked from here, for the page allows no `eval`
        if opened.tab.evaluate(span) < wide:
            break
        opened.tab.wait_for_timeout(50)
    assert opened.tab.evaluate(span) < wide
    opened.tab.locator("input[value=left]").check()
    assert opened.tab.evaluate(seen) == ["left_ticked"]


def test_the_keyboard_is_enough(opened, content):
    opened.tab.locator("#where-box-0").focus()
    opened.tab.keyboard.press("Space")
    assert opened.bar("fz")[0] == pytest.approx(content["fall"]["rmse"][0]["fz"])
    opened.tab.locator("[data-move=in]").focus()
    before = opened.tab.evaluate("(r => r.end - r.start)(infotraj.model('trace-fz').x_range)")
    opened.tab.keyboard.press("Enter")
    assert opened.tab.evaluate("(r => r.end - r.start)(infotraj.model('trace-fz').x_range)") == before / 2
    # Every axis moved, and everything that can be pressed can be reached.
    assert opened.tab.evaluate("infotraj.model('trace-tz').x_range === infotraj.model('trace-fz').x_range")
    assert opened.tab.locator("[tabindex='-1']:is(a, button, input, select)").count() == 0


def test_a_window_that_is_clicked_is_shown(opened, content):
    k, w = next((k, w) for k, w in enumerate(content["windows"]) if w["flight"] == 2)
    opened.tab.locator(f"[data-window='{k}']").click()
    assert opened.tab.locator("#flight").input_value() == "2"
    shown = opened.tab.evaluate("(r => [r.start, r.end])(infotraj.model('trace-tx').x_range)")
    assert shown[0] <= w["from"] < w["to"] <= shown[1]
    assert shown[1] - shown[0] == pytest.approx(w["to"] - w["from"] + 4)
    own = read_part(content["traces"]["flights"][2])["axes"]["tx"]
    np.testing.assert_allclose(opened.line("tx", "measured"), own["measured"])
    opened.tab.locator("input[value=left]").check()
    seen = opened.tab.evaluate("infotraj.model('trace-tx').renderers.filter(r => r.visible).map(r => r.tags?.[1])")
    assert set(seen) >= {"left_given", "left_ticked"}
    assert "measured" not in seen


def test_a_browser_that_cannot_unpack_is_told_and_keeps_the_tables(chromium, quad_report):
    context = chromium.new_context()
    tab = context.new_page()
    complaints = []
    tab.on("pageerror", lambda e: complaints.append(str(e)))
    tab.add_init_script("delete window.DecompressionStream")
    tab.goto((quad_report / "report.html").as_uri())
    assert tab.get_by_text("need a browser of 2023 or later").is_visible()
    assert tab.locator("#missing tbody tr").first.is_visible()
    assert complaints == []
    context.close()


@pytest.mark.parametrize("width", [1400, 800, 400])
def test_it_fits_the_width_it_is_given(chromium, quad_report, width):
    page = Opened(chromium, quad_report / "report.html", viewport={"width": width, "height": 900})
    assert page.tab.evaluate("document.documentElement.scrollWidth") == width
    cut = page.tab.locator(".wide:not(details *)").evaluate_all(
        "t => t.filter(x => x.scrollWidth > x.clientWidth).length"
    )
    assert (cut == 0) == (width == 1400)  # what is wider than a small screen scrolls by itself
    page.context.close()


@pytest.mark.long
def test_it_fits_a_phone_with_long_names_of_files(chromium, content, tmp_path):
    """A file name without a blank is wider than the screen: it is broken where it stands in a sentence."""
    name = f"/data/{'_'.join(['healthy', 'flight', 'of', 'november'] * 4)}.parquet"
    answer = content["answer"] | {
        "reference": {"flights": [name, name], "balance_only": [name]},
        "warnings": [f"{name} is short"],
        "accepted": [{"code": "gap", "what": name}],
    }
    rejected = [{"path": name, "reason": f"{name}: 0 bytes"}]
    write_page(content | {"answer": answer, "rejected": rejected}, tmp_path / "long.html")
    page = Opened(chromium, tmp_path / "long.html", viewport={"width": 400, "height": 900})
    assert name in page.tab.locator("#missing").inner_text()
    assert page.tab.evaluate("document.documentElement.scrollWidth") == 400
    page.context.close()


@pytest.mark.long
def test_in_the_dark_page_and_lines_change_and_paper_stays_white(chromium, quad_report):
    page = Opened(chromium, quad_report / "report.html", color_scheme="dark")
    color = "getComputedStyle(document.body).backgroundColor"
    line = "infotraj.model('trace-tx').renderers.find(r => r.tags?.[1] == 'ticked').glyph.line_color.value"
    assert page.tab.evaluate(color) == "rgb(21, 24, 27)"
    assert page.tab.evaluate(line) == "#56b4e9"
    page.tab.emulate_media(media="print")
    width = page.tab.evaluate("document.querySelector('[data-root=trace-tx]').clientWidth")
    page.tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.tab.evaluate(color) == "rgb(255, 255, 255)"
    shown = "(p => [p.style.filter, parseFloat(p.style.zoom)])(document.querySelector('[data-root=trace-tx]'))"
    turned, zoom = page.tab.evaluate(shown)
    assert turned.startswith("invert(1)")
    assert zoom * width == pytest.approx(680)  # the width of a sheet, from a wider figure
    page.tab.evaluate("dispatchEvent(new Event('afterprint'))")
    page.tab.evaluate("document.querySelector('[data-root=trace-tx]').style.width = '540px'")
    page.tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.tab.evaluate(shown)[1] * 540 == pytest.approx(680)  # and from a narrower one
    assert page.tab.locator("details:not([open])").count() == 0
    # Unfolded they take no more room than they need, and nothing is cut at the edge of the sheet.
    heights = page.tab.locator("details .effects tbody tr").evaluate_all("r => r.map(x => x.clientHeight)")
    assert len(heights) > 20
    assert np.median(heights) < 60
    assert page.tab.locator("pre").is_hidden()  # all of it stands in the tables
    page.context.close()


@pytest.mark.long
def test_from_a_narrow_window_two_figures_share_the_width_of_a_sheet_and_no_table_begins_with_its_head_alone(
    chromium, quad_report
):
    page = Opened(chromium, quad_report / "report.html", viewport={"width": 800, "height": 900})
    plot = "document.querySelector('[data-root=trace-tx]')"
    width = page.tab.evaluate(f"{plot}.clientWidth")
    page.tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert width * page.tab.evaluate(f"parseFloat({plot}.style.zoom)") == pytest.approx(330)
    page.tab.emulate_media(media="print")
    assert len(page.tab.evaluate(f"getComputedStyle({plot}.closest('.grid')).gridTemplateColumns").split()) == 2
    breaks = page.tab.evaluate("getComputedStyle(document.querySelector('.effects thead')).breakAfter")
    assert breaks == "avoid"
    page.context.close()


def made_design(flights):
    """What `infotraj design --json` writes (tests/design holds it against that): a circle, and what it will tell."""
    t = np.linspace(0.0, 10.0, 50)
    circle = np.stack([np.cos(t), np.sin(t), 1.5 + 0 * t], axis=1)
    told = {"question": "linear_drag from rotor_drag", "decided": {"now": 0.0, "again": 0.12, "after": 0.95}}
    numbers = [{"name": "mass.dm, kg", "standard_error": {"now": 0.02, "again": 0.015, "after": 0.0041}}]
    return {
        "reference": "next.csv", "model": {"path": "vehicle.yaml", "sha256": "0"},
        "flown": [{"path": f["path"], "sha256": f["sha256"]} for f in flights],
        "seconds": 10.0, "greatest": {"speed": 1.0, "rate": 2.0},
        "told": [{**told, "numbers": []}, {"question": "mass", "decided": None, "numbers": numbers}],
        "simulated": {"from_reference": 0.31}, "tried": 60, "fly": False,
        "warning": "it strays by 31 cm", "hardly_worth": None,
        "drawn": {
            "t": t.tolist(), "position": circle.tolist(), "speed": (1.0 + 0 * t).tolist(), "rate": t.tolist(),
            "simulated": (1.1 * circle).tolist(),
        },
    }  # fmt: skip


@pytest.mark.long
def test_the_next_flight_is_drawn_with_what_it_will_tell(chromium, content, tmp_path):
    (tmp_path / "design.json").write_text(json.dumps(made_design(content["flights"])))
    design = read_design(tmp_path / "design.json")
    write_page(content | {"design": beside(design, content["flights"])}, tmp_path / "same.html")
    page = Opened(chromium, tmp_path / "same.html", viewport={"width": 400, "height": 900})
    said = page.tab.locator("#next").inner_text()
    assert "Do not fly it as it is: it strays by 31 cm" in said
    assert "Fly it with" not in said
    rows = page.tab.locator("#next tbody tr").all_inner_texts()
    assert [r.split("\t") for r in rows] == [
        ["telling linear_drag from rotor_drag", "open", "12\xa0%", "95\xa0%"],
        ["standard error of mass.dm, kg", "0.02", "0.015", "0.0041"],
    ]
    line = "infotraj.model('next-{}').renderers.find(r => r.tags[0] == '{}').data_source.data.{}"
    for view, role, column, values in (
        ("above", "ticked", "y", np.array(design["drawn"]["position"])[:, 1]),
        ("side", "given", "y", 1.1 * np.array(design["drawn"]["position"])[:, 2]),
        ("speed", "given", "y", design["drawn"]["rate"]),
    ):
        shown = page.tab.evaluate(f"[...{line.format(view, role, column)}]")
        np.testing.assert_allclose(shown, values, rtol=1e-6)
    assert page.tab.evaluate("document.documentElement.scrollWidth") == 400
    assert page.complaints == []
    assert "Designed after other flights" not in said
    page.context.close()
    nothing = {"told": [], "hardly_worth": "nothing is open", "warning": None, "fly": True}
    write_page(content | {"design": beside(design | nothing, content["flights"][:2])}, tmp_path / "other.html")
    other = Opened(chromium, tmp_path / "other.html")
    said = other.tab.locator("#next").inner_text()
    assert "Hardly worth flying for this: nothing is open." in said
    assert "Fly it with" not in said
    assert other.tab.locator("#next table").count() == 0
    assert "Designed after other flights than those of this page" in said
    other.context.close()


def long_flights(count, seconds, rate, boxes):
    """Errors of long flights: slow motion, noise, and one spike of one row a flight."""
    rng = np.random.default_rng(0)
    combinations = [[] for _ in range(2**boxes)]
    t, floor = np.arange(0.0, seconds, 1.0 / rate), np.full(6, 0.1)
    unit = {"force": "N", "torque": "N m"}
    for flight in range(count):
        measured = np.sin(0.5 * t)[:, None] + 0.1 * rng.standard_normal((len(t), 6))
        measured[1000 * (flight + 1), 0] = 99.0
        for k, held in enumerate(combinations):
            predicted = np.sin(0.5 * t)[:, None] * (1 + k) / 2**boxes * np.ones((1, 6))
            held.append(EquationError(t, measured, predicted, floor, floor, unit, "velocity", 0.15, {}, {}))
    ones = np.ones((count, 6))
    made = tuple(HeldOut(tuple(e), ones / (1 + k), ones, np.arange(count)) for k, e in enumerate(combinations))
    rmse = np.array([m.rmse for m in made])
    return Combinations(
        tuple((f"effect_{k}",) for k in range(boxes)), made, 0.9 * rmse, 1.1 * rmse, floor, np.tile(floor, (count, 1))
    )


@pytest.mark.long
def test_six_flights_of_ten_minutes_stay_small_and_quick(chromium, content, tmp_path):
    found = long_flights(6, 600.0, 100.0, 3)
    windows = [TimeWindow(2, "fx", 29.5, 31.5, 1.0, 5.0, 5.0, 0.1)] * 10
    labels = [g[0] for g in found.groups]
    tables = {"rmse": found.rmse, "low": found.low, "high": found.high}
    fall = {key: [dict(zip(AXES, row, strict=True)) for row in table.tolist()] for key, table in tables.items()} | {
        "boxes": [{"label": x, "effects": [x], "corrects": False} for x in labels],
        "steps": ["as given", *labels],
        "at": [0, 1, 3, 7],
    }
    names = [f"flight {k}" for k in range(6)]
    flights = [content["flights"][0] | {"name": n, "seconds": 599.99} for n in names]
    long = content | {
        "traces": flight_traces(found, names, windows),
        "fall": content["fall"] | fall,
        "flights": flights,
    }
    long["windows"] = [content["windows"][0] | {"flight": 2, "from": 29.5, "to": 31.5}] * 10
    write_page(long, tmp_path / "long.html")
    assert (tmp_path / "long.html").stat().st_size < 4e6  # 6.9 MB as single precision
    page = Opened(chromium, tmp_path / "long.html")
    # 2 s and 0.15 s of CPU time (docs/report.md); a machine with other things to do is slower at them, too.
    opened = page.seconds
    assert 0.1 < opened < 6.0
    zoom = """async () => { infotraj.moveTo(100, 200);
        for (let k = 0; k < 2; k++) await new Promise(r => requestAnimationFrame(() => setTimeout(r))); }"""
    for _ in range(3):
        page.tab.evaluate(zoom)
    assert (page.seconds - opened) / 3 < 0.6
    # The spike of one row in 60 000 is drawn, and a window is drawn row by row.
    assert np.nanmax(page.line("fx", "measured")) == pytest.approx(99.0, abs=0.002)
    assert "lowest and highest" in page.tab.locator("#bucket").inner_text()
    page.tab.locator("[data-window='0']").click()
    shown = page.tab.evaluate("[...infotraj.model('series-fx').data.t]")
    assert np.median(np.diff(shown)) == pytest.approx(0.01, rel=1e-3)
    assert page.tab.locator("#bucket").inner_text() == ""
    assert page.complaints == []
    page.context.close()
