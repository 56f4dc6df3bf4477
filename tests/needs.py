"""Marks of tests that need a program, and what to install where it is missing."""

import shutil

import pytest

from benchmarks import chromium


def _program(name: str, package: str, title: str, found: object = None) -> pytest.MarkDecorator:
    there = found or shutil.which(name)
    return pytest.mark.skipif(
        there is None, reason=f"{title} is not installed: apt-get install {package}"
    )


CHROMIUM = _program("chromium", "chromium", "Chromium", chromium.EXECUTABLE)
LIGGGHTS = _program("liggghts", "liggghts", "LIGGGHTS")
NODE = _program("node", "nodejs", "Node.js")
YADE = _program("yade", "yade", "YADE")
