"""The fingerprint changes with the code that a stage can run, and with nothing else."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from infotraj.errors import InputError
from infotraj.fingerprint import PACKAGE, fingerprint, sources

FILES = {
    "__init__.py": "",
    "low.py": '"""Low."""\n\nimport math\n\n\ndef area(r):\n    """Area."""\n    return math.pi * r * r\n',
    "alone.py": "VALUE = 1\n",
    "room/__init__.py": '"""A room."""\n',
    "room/direct.py": "from pkg.low import area\n\nONE = area(1.0)\n",
    "room/late.py": "def run():\n    from pkg import low\n\n    return low.area(2.0)\n",
    "room/relative.py": "from ..low import area\nfrom . import direct\n\nTWO = direct.ONE + area(1)\n",
    "top.py": "import pkg.room.late\nimport numpy as np\n\nX = np.zeros(pkg.room.late.run)\n",
}
MODULES = ["pkg.low", "pkg.alone", "pkg.room.direct", "pkg.room.late", "pkg.room.relative", "pkg.top"]


@pytest.fixture
def package(tmp_path: Path) -> Path:
    root = tmp_path / "pkg"
    for name, text in FILES.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root


def prints(package: Path) -> dict[str, str]:
    return {name: fingerprint(name, package=package) for name in MODULES}


def changed(before: dict[str, str], after: dict[str, str]) -> set[str]:
    return {name for name in before if before[name] != after[name]}


@pytest.mark.parametrize(
    ("file", "touched"),
    [
        ("low.py", {"pkg.low", "pkg.room.direct", "pkg.room.late", "pkg.room.relative", "pkg.top"}),
        ("alone.py", {"pkg.alone"}),
        ("room/direct.py", {"pkg.room.direct", "pkg.room.relative"}),
        ("room/late.py", {"pkg.room.late", "pkg.top"}),
        ("room/__init__.py", {"pkg.room.direct", "pkg.room.late", "pkg.room.relative", "pkg.top"}),
        ("top.py", {"pkg.top"}),
    ],
)
def test_an_edit_changes_exactly_the_fingerprints_of_what_imports_it(package, file, touched):
    before = prints(package)
    path = package / file
    path.write_text(path.read_text() + "\nADDED = 3\n")
    assert changed(before, prints(package)) == touched


def test_comments_docstrings_and_layout_do_not_count(package):
    before = prints(package)
    (package / "low.py").write_text(
        '"""Another text."""\n\nimport math  # why\n\n'
        'def area(r):\n    """Longer.\n\n    Much."""\n\n    return (\n        math.pi * r * r)\n'
    )
    assert prints(package) == before


def test_a_changed_number_or_default_counts(package):
    before = fingerprint("pkg.low", package=package)
    path = package / "low.py"
    path.write_text(path.read_text().replace("def area(r)", "def area(r=1.0)"))
    assert fingerprint("pkg.low", package=package) != before


def test_a_string_that_is_not_a_docstring_counts(package):
    path = package / "alone.py"
    path.write_text('VALUE = "a"\n')
    before = fingerprint("pkg.alone", package=package)
    path.write_text('VALUE = "b"\n')
    assert fingerprint("pkg.alone", package=package) != before


def test_circular_imports_end(package):
    (package / "low.py").write_text("from pkg import top\n")
    assert set(sources("pkg.low", package=package)) >= {"pkg.low", "pkg.top", "pkg.room.late"}


def test_the_place_of_the_code_does_not_count(package, tmp_path):
    elsewhere = tmp_path / "elsewhere" / "pkg"
    elsewhere.parent.mkdir()
    before = prints(package)
    package.rename(elsewhere)
    assert prints(elsewhere) == before


def test_what_python_really_imports_is_covered():
    names = ["infotraj.vehicle", "infotraj.flight", "infotraj.trajectories.reference"]
    code = (
        "import importlib, sys\n"
        "for name in sys.argv[1:]:\n"
        "    importlib.import_module(name)\n"
        "print(*sorted(m for m in sys.modules if m.split('.')[0] == 'infotraj'))"
    )
    out = subprocess.run([sys.executable, "-c", code, *names], capture_output=True, text=True, check=True).stdout
    loaded = set(out.split())
    assert loaded <= set().union(*(sources(name) for name in names))
    assert all(path.is_relative_to(PACKAGE) for name in names for path in sources(name).values())


def test_an_unknown_module_and_broken_code_are_named(package):
    with pytest.raises(InputError, match=r"no module pkg\.nowhere; expected"):
        fingerprint("pkg.nowhere", package=package)
    (package / "low.py").write_text("def area(:\n")
    with pytest.raises(InputError, match=r"low\.py, line 1"):
        fingerprint("pkg.top", package=package)
