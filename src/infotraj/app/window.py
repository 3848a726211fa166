"""What one browser window has asked and been told. Two windows share the folder and what was found in its files."""

from __future__ import annotations

import json
import math
import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from infotraj.app.dropped_bag import DroppedBag
from infotraj.app.folder import MODELS, Folder, safe_name
from infotraj.app.job import Job
from infotraj.app.viewer import Viewer
from infotraj.errors import UsageError, problem

_MOST_FLIGHTS = 100
_PLAIN = re.compile(r"[0-9.x]{1,30}")  # sizes, as the command reads them
_UNKNOWN: dict[str, Any] = {
    "fix": [],
    "kind": None,
    "mapping": None,
    "mappings": [],
    "model": None,
    "reads": [],
}  # of a file of which that was not said


class Window:
    """State of one window: the job that runs, and the last answer."""

    def __init__(self, key: str, folder: Folder) -> None:
        self.key, self.folder = key, folder
        self.work = folder.work / key
        self.work.mkdir()
        self.bag = DroppedBag(folder.work / f"{key}.bag")
        self.job: Job | None = None
        self.asked: dict[str, Any] | None = None
        self.answer: dict[str, Any] | None = None
        self.viewer: Viewer | None = None
        self.note = ""
        self.answers = 0

    @property
    def environment(self) -> dict[str, str]:
        """One thread, and nothing that is remembered outside the folder."""
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        return {**threads, "INFOTRAJ_CACHE": str(self.folder.work / "cache"), "PYTHONUNBUFFERED": "1"}

    @property
    def page(self) -> Path:
        """The report of the last diagnosis."""
        return self.work / "report.html"

    def shown(self) -> dict[str, Any]:
        """For the page."""
        return {
            "folder": str(self.folder.top),
            "listed": self.folder.listed(),
            "files": self.folder.remembered(),
            "job": self.job.shown() if self.job is not None else None,
            "answer": self.answer,
            "note": self.note,
            "viewer": self.viewer.address if self.viewer is not None and self.viewer.running else None,
        }

    def receive(self, name: object, mapping: object = None, model: object = None) -> None:
        """Looks at one file of the folder: a log is imported, everything is checked.

        mapping: one that was offered for it, or a mapping file of the folder; None: the one that is recognised. model:
        one of the folder, of the vehicle that flew; None: any vehicle.
        """
        path = self.folder.chosen(name, "flight", "log", "model", "mapping")
        offered = self.folder.remembered().get(str(path), {}).get("mappings", ())
        by = None if mapping is None else str(mapping) if mapping in offered else self.folder.chosen(mapping, "mapping")
        stamp = self.folder.stamp(path)

        def done(job: Job) -> None:
            if job.state != "cancelled":
                said = _answer_of(job)
                self.folder.remember(path, stamp, said)
                self._made(path, said)

        words = ["-m", "infotraj.app.receiving", _word(path), *(["--mapping", _word(Path(by))] if by else [])]
        words += self._of(model)
        self._start(Job("check", words, self.folder.top, done))

    def _of(self, model: object) -> list[str]:
        """Words that say which vehicle flew."""
        return ["--model", _word(self.folder.chosen(model, "model"))] if model else []

    def fix(self, name: object, model: object = None) -> None:
        """Mends a log as its findings say, in a new flight beside it, and checks that one."""
        path = self.folder.chosen(name, "flight", "log")
        stamp, before = self.folder.stamp(path), self.folder.remembered().get(str(path), {})
        if not before.get("fix"):
            raise UsageError(problem(f"{path}: nothing to fix", "a finding that a setting mends", "Check it first."))
        words = ["-m", "infotraj.app.receiving", _word(path), "--fix"]
        words += ["--mapping", _word(Path(before["mapping"]))] if before["mapping"] else []
        words += self._of(model)

        def done(job: Job) -> None:
            if job.state == "cancelled":
                return
            said = _answer_of(job)
            tried = {"fix": [], "fixed": said["name"]}
            tried |= {} if said["name"] else {"report": f"{said['report']}\n{before['report']}"}
            self.folder.remember(path, stamp, {**before, **tried})
            self._made(path, said)

        self._start(Job("fix", words, self.folder.top, done))

    def _made(self, path: Path, said: Mapping[str, Any]) -> None:
        """Remembers what was said of a file of another name than the one that was looked at."""
        if said["name"] not in (None, str(path)):
            made = Path(said["name"])
            self.folder.remember(made, self.folder.stamp(made), {**said, "fix": []})

    def diagnose(self, model: object, flights: Sequence[object], healthy: Sequence[object]) -> None:
        """Asks which effect the model lacks on these flights, or what changed since healthy ones."""
        if not flights or len(flights) + len(healthy) > _MOST_FLIGHTS:
            raise UsageError(problem(f"{len(flights)} flights", f"1 to {_MOST_FLIGHTS}", "Tick some."))
        chosen = self.folder.chosen(model, "model")
        asked = [self.folder.chosen(f, "flight") for f in flights]
        against = [self.folder.chosen(f, "flight") for f in healthy]
        inside = self.work.relative_to(self.folder.top)
        words = ["-m", "infotraj.cli", "report", _word(chosen), *map(_word, asked), "-o", str(inside / "report.html")]
        words += ["--json", str(inside / "report.json")]
        words += ["--reference", *map(_word, against)] if against else ["--save-model", str(inside / "new.yaml")]
        for old in self.work.iterdir():
            old.unlink()
        self.answer, self.asked = None, {"model": chosen, "flights": asked, "reference": bool(against)}

        def done(job: Job) -> None:
            if job.state == "done":
                content = json.loads((self.work / "report.json").read_text())
                self.answers += 1
                self.answer = {
                    "number": self.answers,
                    "summary": content["answer"]["verdict"]["summary"],
                    "boxes": [box["effects"] for box in content["fall"]["boxes"]],
                    "reference": bool(against),
                }

        self._start(Job("diagnosis", words, self.folder.top, done))

    def save(self, name: object, effects: Sequence[object]) -> None:
        """Writes the model with these effects, labels of the answer, to a new file of the folder."""
        if self.answer is None or self.asked is None or self.answer["reference"]:
            raise UsageError(problem("nothing to save", "a diagnosis without healthy flights", "Diagnose first."))
        if not name:
            raise UsageError(problem("a model without a name", "one such as improved.yaml", "Give it one."))
        target = self.folder.free(safe_name(f"{name}{'' if Path(str(name)).suffix else MODELS[0]}", MODELS))
        every = [label for box in self.answer["boxes"] for label in box]
        labels = [label for label in every if label in effects]
        if not labels or len(labels) != len(effects):
            raise UsageError(problem(f"{len(effects)} effects", "some of those that were named", "Tick one."))
        if labels == every and (self.work / "new.yaml").is_file():
            part = self.work / "taken.yaml"
            shutil.copyfile(self.work / "new.yaml", part)
            self.note = f"{self.folder.take(part, target.name).name} is written"
            return
        # Another set than the diagnosis gave: its numbers are fitted anew, as `infotraj add` does.
        words = [
            "-m",
            "infotraj.cli",
            "add",
            _word(self.asked["model"]),
            *(label.replace(" ", ":") for label in labels),
        ]
        words += ["--fit", *map(_word, self.asked["flights"]), "-o", target.name]

        def done(job: Job) -> None:
            self.note = f"{target.name} is written" if job.state == "done" else ""

        self._start(Job("saving", words, self.folder.top, done))

    def design(self, box: object, seconds: object) -> None:
        """Writes the reference of the flight that tells most next to a new file, and shows it on the report.

        box: such as 2x2x1, m, around the middle of the flights; seconds: how long it lasts.
        """
        if self.answer is None or self.asked is None or self.answer["reference"]:
            raise UsageError(problem("nothing to design for", "a diagnosis without healthy flights", "Diagnose first."))
        if not _PLAIN.fullmatch(str(box)):
            raise UsageError(problem("no room", "three sizes in m such as 2x2x1", "Correct it."))
        if not _is_time(str(seconds)):
            raise UsageError(problem("no flight time", "a positive time in s, such as 20", "Correct it."))
        inside, made = self.work.relative_to(self.folder.top), self.work / "design.json"
        words = ["-m", "infotraj.cli", "design", _word(self.asked["model"]), "-o", str(inside / "next.csv")]
        words += ["--flown", *map(_word, self.asked["flights"]), "--json", str(inside / "design.json")]
        words += ["--box", str(box), "--within", str(seconds)]
        again = ["-m", "infotraj.cli", "report", "--from-json", str(inside / "report.json")]
        again += ["--design", str(inside / "design.json"), "-o", str(inside / "report.html")]

        def drawn(job: Job) -> None:
            if job.state == "done" and self.answer is not None:
                self.answers += 1
                self.answer["number"] = self.answers
                self.note = (
                    f"{json.loads(made.read_text())['reference']} is written; the report shows it under Next steps"
                )

        def done(job: Job) -> None:
            if job.state == "done":
                taken = self.folder.take(self.work / "next.csv", "next.csv").name
                made.write_text(json.dumps(json.loads(made.read_text()) | {"reference": taken}))
                self._start(Job("drawing", again, self.folder.top, drawn))

        self._start(Job("design", words, self.folder.top, done))

    def record(self) -> None:
        """Records the worst flight, with the new model beside the one as given where something was named.

        It is served to rerun's viewer on this machine.
        """
        if self.asked is None:
            raise UsageError(problem("nothing to record", "a diagnosis", "Diagnose first."))
        inside, given = self.work.relative_to(self.folder.top), _word(self.asked["model"])
        words = ["-m", "infotraj.cli", "compare"]
        if self.answer is not None and self.answer["boxes"] and (self.work / "new.yaml").is_file():
            words += [str(inside / "new.yaml"), "--against", given]
        else:
            words += [given]
        words += [*map(_word, self.asked["flights"]), "--recording", str(inside / "worst.rrd")]

        def done(job: Job) -> None:
            if job.state == "done":
                self._close_viewer()
                self.viewer = Viewer(self.work / "worst.rrd")

        self._start(Job("recording", words, self.folder.top, done))

    def cancel(self) -> None:
        """Stops what runs."""
        if self.job is not None:
            self.job.cancel()

    def close(self) -> None:
        """Ends everything of this window."""
        if self.job is not None:
            self.job.kill()
        self._close_viewer()

    def _start(self, job: Job) -> None:
        if self.job is not None and self.job.state == "running":
            raise UsageError(problem(f"the {self.job.kind} is still running", "one at a time", "Wait, or cancel it."))
        self.job = job.start(self.environment)

    def _close_viewer(self) -> None:
        if self.viewer is not None:
            self.viewer.close()
            self.viewer = None


def _word(path: Path) -> str:
    """A path of the folder as a word that no command takes for an option."""
    return f"./{path}" if str(path).startswith("-") else str(path)


def _is_time(text: str) -> bool:
    """A positive number, and no option."""
    try:
        return 0.0 < float(text) < math.inf
    except ValueError:
        return False


def _answer_of(job: Job) -> dict[str, Any]:
    try:
        answer = json.loads(job.printed[-1])
        return _UNKNOWN | {key: answer[key] for key in ("name", "outcome", "report")} | answer
    except (IndexError, ValueError, KeyError, TypeError):
        last = job.said[-1] if job.said else "it ended without a word"
        return _UNKNOWN | {"name": None, "outcome": "rejected", "report": f"cannot be read: {last}"}
