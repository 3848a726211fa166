"""What all stages share: the checked configuration, fingerprints of the library, the names of runs and flights."""

import sys
from pathlib import Path

from infotraj.datasets import location
from infotraj.errors import InfotrajError
from infotraj.experiment.common.config import load
from infotraj.experiment.common.named_files import plant_path, with_its_files
from infotraj.fingerprint import fingerprint


configfile: "config/config.yaml"


# Everything runs in the environment that pip installs from constraints.txt; this names the base that it was tried on.
container: "docker://python:3.11-bookworm"


def checked(read, *arguments):
    """What `read` makes of a file or a configuration, or one line that says what is wrong with it."""
    try:
        return read(*arguments)
    except InfotrajError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_status)


CONFIG = checked(load, config, "configuration")
checked(with_its_files, CONFIG, "configuration")


def code(stage):
    """Fingerprint of the library code that a stage runs: an edit there reruns the stage."""
    return fingerprint(f"infotraj.experiment.{stage}")


def settings(*names):
    """The part of the configuration that a stage reads, as plain values: a change there reruns the stage."""
    plain = CONFIG.model_dump(mode="json")
    return {name: plain[name] for name in names}


def data_fingerprint(name):
    """Which files of a public data set are used, so that others rerun what reads them; None where it is absent."""
    folder = location.find_dataset(name, CONFIG.data_dir)
    return folder and sorted((path.name, path.stat().st_size) for path in folder.glob("*.parquet"))
