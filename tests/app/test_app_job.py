"""One command in a process of its own."""

import asyncio
import os

from infotraj.app.job import Job

STUBBORN = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(1, flush=True); time.sleep(60)"


def test_a_job_that_is_cancelled_counts_its_seconds_until_it_has_gone(tmp_path):
    async def run():
        job = Job("check", ["-c", STUBBORN], tmp_path).start(os.environ)
        while not job.printed:
            await asyncio.sleep(0.02)
        job.cancel()
        before = job.shown()
        job.kill()
        await job.task
        return before, job.shown(), job.shown()

    before, after, later = asyncio.run(run())
    assert before["state"] == after["state"] == "cancelled"
    assert 0.0 < before["seconds"] <= after["seconds"] == later["seconds"]
