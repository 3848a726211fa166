"""One thread for linear algebra: the matrices are small, and more threads only slow them down. Remembered checks are
those of these tests."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"):
    os.environ.setdefault(name, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ["INFOTRAJ_CACHE"] = tempfile.mkdtemp(prefix="infotraj-tests-")

import numpy as np  # noqa: E402 - after the number of its threads

TOP = Path(__file__).parents[1]
FLIGHTS = [f"examples/quad/flight_{k}.parquet" for k in range(3)]


@pytest.fixture(autouse=True)
def random_numbers(request):
    """A module's `RNG` starts anew for each test: what a test draws does not depend on which tests ran before it."""
    if hasattr(request.module, "RNG"):
        request.module.RNG = np.random.default_rng(0)


@pytest.fixture(scope="session")
def quad_report(tmp_path_factory):
    """A folder with report.html, report.json and new.yaml of the example flights, made once for all workers."""
    folder = tmp_path_factory.getbasetemp()
    folder = (folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder) / "quad_report"
    try:
        folder.mkdir()
    except FileExistsError:
        while not (folder / "done").exists():
            time.sleep(0.2)
    else:
        try:
            written = [f"-o={folder}/report.html", f"--json={folder}/report.json", f"--save-model={folder}/new.yaml"]
            written = [word for option in written for word in option.split("=")]
            words = [sys.executable, "-m", "infotraj.cli", "report", "examples/quad/vehicle.yaml", *FLIGHTS, *written]
            done = subprocess.run(words, cwd=TOP, capture_output=True, text=True)
            (folder / "stdout").write_text(done.stdout)
            (folder / "stderr").write_text(done.stderr)
        finally:
            (folder / "done").touch()
    assert (folder / "report.html").exists(), (folder / "stderr").read_text()
    return folder


@pytest.fixture(scope="session")
def chromium():
    """A headless Chromium of this machine (CI installs Debian's); the test is skipped where there is none."""
    import shutil

    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if found is None:
        pytest.skip("no Chromium on this machine: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield browser
        browser.close()
