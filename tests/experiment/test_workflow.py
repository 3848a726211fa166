"""The workflow: its graph, what an edit reruns, how it refuses, resumes, and waits for flights of a real vehicle."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

TOP = Path(__file__).parents[2]
WORKFLOW = ("Snakefile", "workflow", "profiles", "config")
TINY = """
plants: [omav_a]
seeds: 1
added_points: [20]
task: {period: 4, cycles: 1}
modified: {period: 4, cycles: 1}
learning: {restarts: 0}
selection: {candidates: 3, draws: 2, task_draws: 2, region_points: 100}
"""


def copied(to: Path, *parts: str) -> Path:
    """A copy of parts of the project, with the tiny configuration."""
    for name in parts:
        if (TOP / name).is_dir():
            shutil.copytree(TOP / name, to / name, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        else:
            shutil.copy(TOP / name, to / name)
    (to / "tiny.yaml").write_text(TINY)
    return to


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """The workflow in a folder of its own, with the installed library."""
    return copied(tmp_path, *WORKFLOW)


@pytest.fixture(scope="module")
def finished_once(tmp_path_factory) -> Path:
    """A copy with its own library and every output there: empty files that snakemake takes for the present code's."""
    project = copied(tmp_path_factory.mktemp("finished"), *WORKFLOW, "src")
    for line in snakemake(project, "--summary").stdout.splitlines()[1:]:
        path = project / line.split("\t")[0]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    done = snakemake(project, "--touch", "--forceall")
    assert done.returncode == 0, done.stderr
    return project


@pytest.fixture
def finished(finished_once: Path, tmp_path: Path) -> Path:
    return shutil.copytree(finished_once, tmp_path, dirs_exist_ok=True)


def environment(project: Path, **more: str) -> dict[str, str]:
    kept = {k: v for k, v in os.environ.items() if k != "INFOTRAJ_DATA"}
    own = {"PYTHONPATH": str(project / "src")} if (project / "src").exists() else {}
    return {**kept, **own, **more}


def command(*arguments: str, config: str = "tiny.yaml") -> list[str]:
    return [sys.executable, "-m", "snakemake", "--cores", "2", *arguments, "--configfile", config]


def snakemake(project: Path, *arguments: str, config: str = "tiny.yaml", **more: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        command(*arguments, config=config),
        cwd=project,
        env=environment(project, **more),
        capture_output=True,
        text=True,
    )


def planned(project: Path, *arguments: str, **more: str) -> dict[str, int]:
    """What a dry run would run: {rule: jobs}; nothing where all is done."""
    return jobs_of(snakemake(project, "-n", *arguments, "--quiet", "rules", **more))


def jobs_of(done: subprocess.CompletedProcess) -> dict[str, int]:
    assert done.returncode == 0, done.stderr
    lines = (done.stdout + done.stderr).splitlines()
    starts = [k for k, line in enumerate(lines) if line.startswith("Job stats")]
    if not starts:
        assert any("Nothing to be done" in line for line in lines)
        return {}
    start = starts[0] + 3
    jobs = {}
    for line in lines[start:]:
        if not line.strip():
            break
        rule, count = line.split()
        jobs[rule] = int(count)
    return {rule: count for rule, count in jobs.items() if rule not in ("all", "total")}


@pytest.fixture(scope="module")
def quick(tmp_path_factory) -> subprocess.CompletedProcess:
    """A dry run of the quick experiment where no data set is."""
    project = copied(tmp_path_factory.mktemp("quick"), *WORKFLOW)
    return snakemake(project, "-n", "--quiet", "rules", config="config/quick.yaml")


def test_the_quick_graph_has_every_stage(quick):
    jobs = jobs_of(quick)
    assert jobs["fly"] == 2 * 6, "prior, test, task, random, paper and informative flight of two seeds"
    assert jobs["learn"] == 2 * 4
    assert jobs["choose"] == 2 * 2, "our cost and the paper's"
    assert jobs["validate"] == jobs["record"] == jobs["correlate"] == jobs["choose_random"] == 2
    assert {"figure_2", "figure_3", "figure_4", "figure_5", "table_1", "claims", "figure_costs"} <= set(jobs)
    assert {"hidden_summary", "hidden_today_1", "story", "points_needed"} <= set(jobs)
    assert "judge_pool" not in jobs, "there are no real flights here"


@pytest.mark.long
def test_rounds_repeat_the_loop(project):
    (project / "two.yaml").write_text(TINY + "iterations: 2\n")
    once, twice = planned(project), planned(project, config="two.yaml")
    assert twice["choose"] == 2 * once["choose"] == 4
    assert twice["validate"] == 2
    assert twice["fly"] == once["fly"] + 4
    assert twice["learn"] == 2 * once["learn"]


@pytest.mark.long
def test_real_flights_join_where_they_are(project, tmp_path):
    (tmp_path / "data" / "nanobench").mkdir(parents=True)
    jobs = planned(project, INFOTRAJ_DATA=str(tmp_path / "data"))
    assert jobs["judge_pool"] == 5
    assert jobs["figure_pool"] == jobs["summarise_pool"] == 1


def test_their_absence_is_said_in_a_line_that_tells_how_to_get_them(quick):
    lines = [line for line in quick.stderr.splitlines() if line.startswith("Skipped: ")]
    assert len(lines) == 1
    assert "infotraj data get nanobench" in lines[0]


@pytest.mark.long
def test_a_case_of_real_flights_is_skipped_where_its_own_logs_are_not(project, tmp_path):
    logs = tmp_path / "data" / "crazyswarm2" / "logs"
    logs.mkdir(parents=True)
    for name in ("log182", "log183", "log184"):
        (logs / name).touch()
    here = {"INFOTRAJ_DATA": str(tmp_path / "data")}
    assert planned(project, "real_table", **here) == {"real_case_flights": 1, "real_case": 1, "real_table": 1}
    said = snakemake(project, "-n", "real_table", **here).stderr
    assert "Skipped: nanobench: data set nanobench is not here" in said
    assert "Skipped: crazyswarm2_free: data set crazyswarm2 holds no logs/log160" in said
    assert "Skipped: crazyswarm2_loaded_slow" not in said


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("seds: 3\n", "seds: unknown key"),
        pytest.param("selection: {drws: 3}\n", "selection.drws: unknown key", marks=pytest.mark.long),
        pytest.param("plants: [omav_z]\n", "plants: omav_z is not in config/plants", marks=pytest.mark.long),
        ("hidden_effects: {study: nope.yaml}\n", "nope.yaml: cannot be read"),
        pytest.param(
            "hidden_effects: {only: [nothing_like_it]}\n", "no case matches nothing_like_it", marks=pytest.mark.long
        ),
    ],
)
def test_a_wrong_configuration_is_refused_in_one_line(project, content, says):
    (project / "wrong.yaml").write_text(content)
    done = snakemake(project, "-n", config="wrong.yaml")
    assert done.returncode != 0
    last = done.stderr.splitlines()[-1]
    assert says in last
    assert "expected" in last or "unknown key" in last
    assert not {"Traceback", "UsageError", "File"} & set(done.stderr.split())
    assert not (project / "results").exists()


@pytest.mark.long
def test_the_page_over_all_results_shows_what_is_there_and_makes_none_of_it(project):
    for name, text in (("table_1.md", "| made | by hand |\n|---|---|\n| 7 | 8 |\n"), ("recordings/x/a.rrd", "")):
        (project / "results" / name).parent.mkdir(parents=True, exist_ok=True)
        (project / "results" / name).write_text(text)
    done = snakemake(project, "index", "--quiet", "rules")
    assert jobs_of(done) == {"index": 1}
    page = (project / "results/index.html").read_text()
    assert "by hand" in page
    assert "recordings/x/a.rrd" in page
    assert "Figure 2" not in page


def append(project: Path, module: str, text: str) -> None:
    path = project / "src" / "infotraj" / module
    path.write_text(path.read_text() + text)


FIGURES = {"figure_2", "figure_3", "figure_4", "figure_5", "figure_costs", "table_1", "claims"}
LEARNED = {"learn_prior", "learn", "choose", "fly", "correlate", "validate_start", "validate"}


@pytest.mark.long
def test_a_finished_experiment_has_nothing_to_do_and_a_remark_changes_nothing(finished):
    append(finished, "plots/style.py", "\n# a remark\n")
    assert planned(finished) == {}


@pytest.mark.long
def test_an_edit_of_the_library_reruns_exactly_what_it_touches(finished):
    append(finished, "plots/style.py", "\nADDED = 1\n")
    assert set(planned(finished)) == FIGURES
    append(finished, "recording/scene.py", "\nADDED = 1\n")
    assert set(planned(finished)) == FIGURES | {"record"}


@pytest.mark.long
def test_an_edit_of_the_learner_reruns_all_but_the_references(finished):
    append(finished, "residual/subset.py", "\nADDED = 1\n")
    touched = set(planned(finished))
    assert touched >= LEARNED
    assert "write_references" not in touched


@pytest.mark.long
def test_a_changed_setting_reruns_exactly_what_reads_it(finished):
    (finished / "tiny.yaml").write_text(TINY + "correlation: {candidates: 7}\n")
    assert set(planned(finished)) == {"correlate", "gather_errors", "figure_2", "claims"}


@pytest.mark.long
def test_a_changed_truth_reruns_what_that_plant_flies(finished):
    truth = finished / "config/plants/omav_a.yaml"
    truth.write_text(truth.read_text() + "# another\n")
    touched = set(planned(finished))
    assert touched >= LEARNED
    assert "write_references" not in touched


@pytest.mark.long
def test_a_deleted_flight_is_not_missed_and_is_made_anew_on_request_with_what_follows(finished):
    """As results/README.md says."""
    flight = "results/omav_a/seed0/flown/test.parquet"
    (finished / flight).unlink()
    assert planned(finished) == {}
    assert planned(finished, "--forcerun", flight) == {
        "fly": 1, "prediction_errors": 1, "record": 1, "gather_errors": 1,
    }  # fmt: skip
    (finished / "results/figures/figure_3.pdf").unlink()
    assert set(planned(finished)) >= {"figure_3"}


@pytest.mark.long
def test_the_workflow_is_lint_clean(project):
    done = snakemake(project, "--lint")
    assert done.returncode == 0, done.stderr
    assert "good condition" in done.stderr


def test_scripts_are_adapters_of_at_most_15_lines():
    scripts = list((TOP / "workflow" / "scripts").rglob("*.py"))
    assert len(scripts) > 50
    for path in scripts:
        lines = [line for line in path.read_text().splitlines() if line.strip()]
        assert len(lines) <= 15, path.name


@pytest.mark.long
def test_an_interrupted_run_resumes_where_it_was(project):
    target, first = "results/omav_a/seed0/prior.npz", project / "results/omav_a/seed0/flown/prior.parquet"
    with open(project / "run.log", "w") as log:
        run = subprocess.Popen(
            command(target), cwd=project, env=environment(project), stdout=log, stderr=log, start_new_session=True
        )
        deadline = time.monotonic() + 120
        while not first.exists() and run.poll() is None and time.monotonic() < deadline:
            time.sleep(0.02)
        os.killpg(run.pid, signal.SIGINT)
        run.wait(timeout=60)
    assert first.exists(), (project / "run.log").read_text()
    references = project / "results/references/task.csv"
    made = references.stat().st_mtime_ns
    done = snakemake(project, target)
    assert done.returncode == 0, done.stderr
    assert (project / target).exists()
    assert references.stat().st_mtime_ns == made
    assert planned(project, target) == {}


def own_vehicle(project: Path, target: str, more: str = "") -> list[str]:
    """What a run with `execution: log` says last: a line for each flight that it waits for."""
    (project / "own.yaml").write_text(TINY.replace("plants: [omav_a]\n", "execution: log\n") + more)
    done = snakemake(project, target, config="own.yaml")
    waiting = [line for line in done.stderr.splitlines() if line.startswith("Waiting: ")]
    assert (done.returncode == 0) == (not waiting), done.stderr
    return waiting


@pytest.mark.long
def test_a_flight_is_asked_for_when_its_model_is_there_and_only_by_the_run_that_says_so(project):
    stale = project / "results/logs/own/seed0/receive/informative_1.log"
    stale.parent.mkdir(parents=True)
    stale.write_text("results/own/seed0/round1/informative.csv: no flight yet\n")
    (waiting,) = own_vehicle(project, "results/prediction.csv")
    assert "results/references/task.csv: no flight yet" in waiting
    assert "flights/seed0/prior.parquet or .csv" in waiting
    assert "Fly the reference with no learned model in the controller" in waiting


@pytest.mark.long
def test_with_a_vehicle_of_your_own_the_run_waits_for_each_flight_and_goes_on(project):
    """A separate process that shares no code with the plant flies what the workflow asks for."""
    target = "results/prediction.csv"
    flights = project / "flights" / "seed0"
    flights.mkdir(parents=True)

    def fly(reference: str, name: str, seed: int) -> None:
        flyer, vehicle = TOP / "tests" / "support" / "independent_flyer.py", project / "config/vehicles/omav.yaml"
        arguments = [project / reference, vehicle, flights / f"{name}.csv", str(seed)]
        subprocess.run([sys.executable, flyer, *arguments], check=True)

    def asked(name: str, line: str, reference: str, model: str) -> None:
        assert f"{reference}: no flight yet" in line
        assert f"flights/seed0/{name}.parquet or .csv" in line
        assert f"Fly the reference with {model} in the controller" in line

    task, informative = "results/references/task.csv", "results/own/seed0/round1/informative.csv"
    learned = "the learned model results/own/seed0/prior.npz"
    (waiting,) = own_vehicle(project, target)
    asked("prior", waiting, task, "no learned model")
    fly(task, "prior", 0)
    waiting = own_vehicle(project, target)
    later = {"informative_1": informative, "task_1": task, "test": task}
    for (name, reference), line in zip(later.items(), waiting, strict=True):
        asked(name, line, reference, learned)
    for seed, (name, reference) in enumerate(later.items(), 1):
        fly(reference, name, seed)
    assert own_vehicle(project, target) == []
    errors = pd.read_csv(project / target).set_index("source")["error"]
    assert errors["task"] < 0.2 * errors["none"]
    assert errors["informative"] < 0.2 * errors["none"]
