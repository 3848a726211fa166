"""Progress: time left on a terminal, nothing anywhere else."""

import io
import re
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import click
import numpy as np
import pytest

from infotraj import progress as module
from infotraj.progress import progress, waiting

QUAD = Path(__file__).parents[1] / "examples/quad"


@pytest.fixture
def terminal(monkeypatch):
    """A terminal and its clock; `said` is what was written to it."""
    screen = io.StringIO()
    screen.isatty = lambda: True
    made = SimpleNamespace(now=0.0, said=screen.getvalue)
    monkeypatch.setattr(module, "sys", SimpleNamespace(stderr=screen))
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: made.now))
    return made


def run(clock, count, label="check", step=3.0):
    for _ in progress(range(count), label):
        clock.now += step


def test_a_terminal_is_told_how_long_it_will_take_and_left_clean(terminal):
    run(terminal, 4)
    said = terminal.said()
    lines = [line.strip() for line in said.split("\r") if line.strip()]
    assert lines == ["check 2 of 4, 9 s left", "check 3 of 4, 6 s left", "check 4 of 4, 3 s left"]
    assert said.endswith("\r")
    assert "\n" not in said
    assert "\x1b" not in said
    assert max(map(len, said.split("\r"))) < 80


def test_long_waits_are_told_in_minutes_and_long_labels_are_cut(terminal):
    run(terminal, 3, label="x" * 100, step=300.0)
    assert max(map(len, terminal.said().split("\r"))) < 80
    run(terminal, 3, step=300.0)
    assert "2 of 3, 10 min left" in terminal.said()


def test_what_nobody_can_tell_the_length_of_says_how_long_it_has_run(terminal, monkeypatch):
    monkeypatch.setattr(module, "_EVERY", 0.001)
    with waiting("diagnosing"):
        time.sleep(0.02)
        assert terminal.said() == ""
        terminal.now = 12.0
        wait_for(lambda: "diagnosing, 12 s so far" in terminal.said())
        terminal.now = 150.0
        wait_for(lambda: "2 min so far" in terminal.said())
        module.step(2, 4, "searching")
        wait_for(lambda: "diagnosing: 2 of 4, searching, 2 min so far" in terminal.said())
    assert terminal.said().endswith("\r")
    assert "\n" not in terminal.said()
    with pytest.raises(ValueError, match="its own"), waiting("diagnosing"):
        raise ValueError("its own")
    with waiting("fitting"):  # what another said is gone
        terminal.now += 30.0
        wait_for(lambda: "fitting, 30 s so far" in terminal.said())
    assert not [t for t in threading.enumerate() if "_so_far" in t.name]


def test_one_long_item_says_how_long_it_has_run(terminal, monkeypatch):
    """A single flight of an hour is no reason for silence."""
    monkeypatch.setattr(module, "_EVERY", 0.001)
    for _ in progress(range(1), "preparing flight"):
        terminal.now += 12.0
        wait_for(lambda: "preparing flight 1 of 1, 12 s so far" in terminal.said())
    assert terminal.said().endswith("\r")


def test_the_time_left_counts_down_while_an_item_takes_longer(terminal, monkeypatch):
    monkeypatch.setattr(module, "_EVERY", 0.001)
    for k in progress(range(3), "check"):
        terminal.now += 10.0
        if k == 1:
            wait_for(lambda: "check 2 of 3, 10 s left" in terminal.said())
            terminal.now += 60.0
            wait_for(lambda: "check 2 of 3, 0 s left" in terminal.said())


def test_alike_steps_tell_the_time_left(terminal, monkeypatch):
    monkeypatch.setattr(module, "_EVERY", 0.001)
    with waiting("checking"):
        module.step(1, 3, "a.csv", alike=True)
        terminal.now = 10.0
        wait_for(lambda: "checking: 1 of 3, a.csv, 10 s so far" in terminal.said())
        module.step(2, 3, "b.csv", alike=True)
        wait_for(lambda: "checking: 2 of 3, b.csv, 20 s left" in terminal.said())


def test_parts_tell_about_how_much_time_is_left(terminal, monkeypatch):
    monkeypatch.setattr(module, "_EVERY", 0.001)
    module.parts({"reading": 1.0, "writing": 1.0})  # by something that nobody waited for
    with waiting("diagnosing"):
        terminal.now = 12.0
        wait_for(lambda: "diagnosing, 12 s so far" in terminal.said())
        module.step(2, 3, "searching")
        module.parts({"search": 60.0, "judge": 10.0})
        module.pieces("judge", 4)
        module.reached("search")
        wait_for(lambda: "diagnosing: 2 of 3, searching, 12 s so far" in terminal.said())
        terminal.now = 24.0
        module.reached("search", 1, 5)
        wait_for(lambda: "2 of 3, searching, about 90 s left" in terminal.said())
        terminal.now += 45.0
        wait_for(lambda: "searching, about 80 s left" in terminal.said())  # no less: what comes after is left
        module.reached("judge")
        wait_for(lambda: "searching, about 40 s left" in terminal.said())
        module.reached("judge", 9, 10)
        wait_for(lambda: "searching, a few seconds left" in terminal.said())
    with waiting("fitting"):
        terminal.now += 30.0
        wait_for(lambda: "fitting, 30 s so far" in terminal.said())


def test_what_nobody_waits_for_may_say_how_far_it_is(terminal):
    module.pieces("judge", 4)
    module.reached("judge", 1, 4)
    assert terminal.said() == ""


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.0, "a few seconds left"),
        (3.9, "a few seconds left"),
        (4.1, "about 5 s left"),
        (32.0, "about 30 s left"),
        (44.0, "about 40 s left"),
        (99.0, "about 100 s left"),
        (100.0, "about 2 min left"),
        (900.0, "about 15 min left"),
    ],
)
def test_an_estimate_is_said_no_more_exactly_than_it_is(seconds, words):
    assert module._about(seconds) == words


def test_of_a_long_line_the_time_is_not_cut_off(terminal, monkeypatch):
    monkeypatch.setattr(module, "_EVERY", 0.001)
    with waiting("diagnosing " + "x" * 100):
        terminal.now = 12.0
        wait_for(lambda: "xx, 12 s so far" in terminal.said())
    assert max(map(len, terminal.said().split("\r"))) < 80


def test_of_two_lines_the_inner_one_is_seen(terminal, monkeypatch):
    monkeypatch.setattr(module, "_EVERY", 0.001)
    with waiting("searching"):
        for _ in progress(range(1), "computing"):
            terminal.now += 5.0
            before = len(terminal.said())
            wait_for(lambda: "computing 1 of 1, 5 s so far" in terminal.said())
            time.sleep(0.02)
            assert "searching" not in terminal.said()[before:]
        wait_for(lambda: "searching, 5 s so far" in terminal.said())


def test_what_is_printed_meanwhile_has_a_line_of_its_own(terminal):
    for k in progress(range(3), "check"):
        terminal.now += 3.0
        if k == 1:
            module.interrupted()
            assert terminal.said().endswith(" \r")


def wait_for(what, longest=5.0):
    begun = time.monotonic()
    while not what():
        assert time.monotonic() - begun < longest
        time.sleep(0.002)


def test_what_is_quick_or_asked_to_be_quiet_says_nothing(terminal):
    run(terminal, 10, step=0.1)
    with click.Context(click.Command("any")) as context:
        context.params["quiet"] = True
        run(terminal, 4)
        with waiting("diagnosing"):
            terminal.now += 60.0
            time.sleep(0.01)
    assert terminal.said() == ""


def test_a_pipe_hears_nothing(monkeypatch, capsys):
    monkeypatch.setattr(module, "_QUICK", -1.0)
    assert list(progress(range(3), "check")) == [0, 1, 2]
    assert list(progress(iter([1, 2]), "check")) == [1, 2]
    assert capsys.readouterr().err == ""


def three_of(clock):
    for k in progress(range(5), "check"):
        clock.now += 3.0
        if k == 2:
            raise ValueError("third")


def test_an_error_passes_through(terminal):
    with pytest.raises(ValueError, match="third"):
        three_of(terminal)
    assert "check 3 of 5" in terminal.said()


def test_what_an_earlier_step_said_is_not_said_of_the_next_wait(terminal, monkeypatch):
    monkeypatch.setattr(module, "_EVERY", 0.001)
    module.step(3, 3, "log7")  # by something that nobody waited for
    with waiting("diagnosing"):
        terminal.now = 12.0
        wait_for(lambda: "so far" in terminal.said())
    assert "log7" not in terminal.said()


def test_a_log_that_takes_long_to_import_and_figures_say_so(terminal, monkeypatch, tmp_path):
    """The commands wait under `waiting`: slowed down, each is told."""
    import infotraj.importing.reading as reading
    import infotraj.plots.comparison as comparison

    monkeypatch.setattr(module, "_EVERY", 0.001)

    def slow(run):
        def later(*arguments, **how):
            before = terminal.said()
            terminal.now += 12.0
            wait_for(lambda: "so far" in terminal.said()[len(before) :])
            return run(*arguments, **how)

        return later

    monkeypatch.setattr(reading, "read_streams", slow(reading.read_streams))
    monkeypatch.setattr(comparison, "comparison_figures", slow(lambda *_: []))
    run_command("import", QUAD / "log/board.csv", "--mapping", QUAD / "log/board.yaml", "-o", tmp_path / "b.parquet")
    assert "importing board.csv, 12 s so far" in terminal.said()
    run_command("compare", QUAD / "vehicle.yaml", QUAD / "flight_0.parquet", "--figures", tmp_path / "figures")
    assert "drawing, 12 s so far" in terminal.said()


def run_command(*words):
    from click.testing import CliRunner

    from infotraj.cli import cli

    done = CliRunner().invoke(cli, [str(word) for word in words], catch_exceptions=False)
    assert done.exit_code == 0, done.output


def test_every_part_of_a_plan_is_reached_somewhere():
    """A part that nobody reaches would never be over; one of another name would count for nothing."""
    import infotraj
    from infotraj.diagnosis import adding, lengths
    from infotraj.importing import command

    sources = "".join(p.read_text() for p in Path(infotraj.__file__).parent.rglob("*.py"))
    reached = set(re.findall(r'\breached\("([^"]+)"', sources))
    told = set(re.findall(r'\bpieces\("([^"]+)"', sources))
    against = [name.removeprefix(lengths.HEALTHY) for name in (*lengths._LEARNING, *lengths._AGAINST)]
    plans = (lengths.PARTS, against, adding._PARTS, *command._PARTS.values())
    assert {part for plan in plans for part in plan} <= reached
    assert reached | told <= {part for plan in plans for part in plan}


def test_what_is_searched_on_healthy_flights_and_on_those_in_question_is_told_apart(terminal, monkeypatch):
    """The same search runs twice: the second is ahead while the first runs, as long as its flights are."""
    from infotraj.diagnosis.lengths import HEALTHY, against

    monkeypatch.setattr(module, "_EVERY", 0.001)
    healthy, asked = SimpleNamespace(t=np.array([0.0, 60.0])), SimpleNamespace(t=np.array([5.0, 35.0]))
    lengths = against([asked], [healthy])
    whole, first = sum(lengths.values()), lengths[HEALTHY + "searching"]
    assert lengths["weighing"] == pytest.approx(0.5 * against([healthy], [healthy])["weighing"])
    with waiting("diagnosing"):
        module.parts(lengths)
        with module.within(HEALTHY):
            module.reached("searching")
            terminal.now += first
            module.reached("searching anew")
            told = module._about(whole - first)
            wait_for(lambda: told in terminal.said())
        terminal.now += whole - first - lengths["errors"]
        module.reached("errors")
        wait_for(lambda: "a few seconds left" in terminal.said())
