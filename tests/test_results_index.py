"""The page over all results: what is there is on it, with captions that quote the configuration."""

import re
import urllib.parse
from pathlib import Path

import pytest
from jinja2 import UndefinedError

from infotraj.errors import InputError
from infotraj.report.results_index import blocks, write_index

TOP = Path(__file__).parents[1]


def entry(path, **more):
    return {"section": "Figures", "title": "A title", "path": path, "caption": "caption.rst"} | more


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results/a b").mkdir(parents=True)
    (tmp_path / "caption.rst").write_text(
        'Up to {{ snakemake.config["task"]["deg"] }} deg, {{ snakemake.params.points }}\nof ``it``.'
    )
    for name in ("one.png", "two.png", "two.pdf"):
        (tmp_path / "results/a b" / name).write_bytes(b"")
    (tmp_path / "results/table.md").write_text(
        "# Head\n\n| a | b |\n|---|--:|\n| [x](y.md) | <script> |\n\nText **here**.\n"
    )
    return tmp_path


def test_captions_quote_the_configuration_and_links_lead_to_files(folder):
    entries = [entry("results/a b"), entry("results/table.md", section="Tables")]
    write_index(entries, ["results/a b/one.png"], {"task": {"deg": 30}}, 100, Path("results/index.html"))
    text = (folder / "results/index.html").read_text()
    assert text.count("Up to 30 deg, 100 of it.") == 3
    links = re.findall(r'(?:href|src)="([^"#]+)"', text)
    own = [urllib.parse.unquote(x) for x in links if not x.startswith("data:")]
    assert sorted(set(own)) == ["a b/one.png", "a b/two.pdf", "a b/two.png", "table.md"]
    assert all((folder / "results" / x).exists() for x in own)
    assert "<td>&lt;script&gt;</td>" in text
    assert text.index("Figures</h2>") < text.index("Tables</h2>")


def test_a_caption_that_quotes_what_is_not_there_writes_no_page(folder):
    with pytest.raises(UndefinedError):
        write_index([entry("results/table.md")], [], {"other": 1}, 100, Path("results/index.html"))
    assert not (folder / "results/index.html").exists()


def test_without_a_result_there_is_no_page(folder):
    with pytest.raises(InputError, match="results: no results yet; expected figures"):
        write_index([], [], {}, 100, Path("results/index.html"))
    assert not (folder / "results/index.html").exists()


def test_tables_headings_and_text_of_a_result_are_told_apart():
    found = blocks("# Head\n\n| a | b |\n|---|--:|\n| [x](y.md) | `2` |\n\nText **here**\nand there.")
    assert found == [{"heading": "Head"}, {"head": ["a", "b"], "rows": [["x", "2"]]}, {"text": "Text here and there."}]


def test_the_results_that_are_published_are_tables_that_it_reads():
    for name in ("claims.md", "table_1.md", "closed_loop.md", "what_changed.md"):
        tables = [b for b in blocks((TOP / "docs/results" / name).read_text()) if "rows" in b]
        assert tables, name
        assert all(len(row) == len(t["head"]) for t in tables for row in t["rows"]), name


def test_a_long_table_is_read_on_a_phone_and_printed_from_the_first_page_on(folder, chromium):
    claim = "Figure 4: error, informative minus the choice of the paper's cost, mean over the sizes"
    rows = "".join(f"| {claim} [rad/s^2] | none | -0.0211 | [-0.0394, -0.00268] | yes |\n" for _ in range(32))
    table = "| claim | paper | ours | 95 % interval | holds |\n|---|---|---|---|---|\n" + rows
    (folder / "results/table.md").write_text(table)
    write_index([entry("results/table.md")], [], {"task": {"deg": 30}}, 100, Path("results/index.html"))
    tab = chromium.new_page(viewport={"width": 400, "height": 800})
    tab.goto((folder / "results/index.html").as_uri())
    assert tab.evaluate("document.documentElement.scrollWidth") <= 400
    assert tab.locator("tbody th").first.bounding_box()["width"] > 150
    printed = tab.pdf(format="A4")
    tab.close()
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) == 2


def test_a_page_that_is_printed_at_once_has_its_figures(folder):
    write_index([entry("results/a b")], [], {"task": {"deg": 30}}, 100, Path("results/index.html"))
    pictures = re.findall(r"<img [^>]*>", (folder / "results/index.html").read_text())
    assert len(pictures) == 2
    assert not any("lazy" in p for p in pictures)
