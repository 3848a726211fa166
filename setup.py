"""Puts the example flights and the vehicle files into a wheel; everything else stands in pyproject.toml."""

import ast
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

TOP = Path(__file__).resolve().parent


def shipped_folders() -> dict[str, str]:
    """FOLDERS of infotraj.examples.location, read without importing what is not installed yet."""
    tree = ast.parse((TOP / "src/infotraj/examples/location.py").read_text(encoding="utf-8"))
    for node in tree.body:
        match node:
            case ast.Assign(targets=[ast.Name(id="FOLDERS")], value=value):
                return ast.literal_eval(value)
    raise ValueError("infotraj/examples/location.py: FOLDERS is not assigned there")


class BuildWithExamples(build_py):
    """Also copies what is shipped; an editable installation finds it in the checkout."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        for name, folder in shipped_folders().items():
            to = Path(self.build_lib) / "infotraj" / "examples" / name
            shutil.copytree(TOP / folder, to, dirs_exist_ok=True)


setup(cmdclass={"build_py": BuildWithExamples})
