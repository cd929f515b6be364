"""The examples of the README run as they stand."""

import os
import re
import shutil
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"
BLOCKS = re.findall(r"```python\n(.*?)```", README.read_text(), re.S)


def test_the_examples_run(log, tmp_path, monkeypatch, capsys):
    shutil.copy(log, tmp_path / "run.vnymr")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    assert len(BLOCKS) >= 3 and os.getcwd() == str(tmp_path)
    for block in BLOCKS:
        exec(compile(block, str(README), "exec"), names)
    assert "estimated" in capsys.readouterr().out


def test_the_types_are_those_of_the_examples(tmp_path):
    api = pytest.importorskip("mypy.api")
    wrong = ['vn100.replay("a", rates=40)', 'vn100.archive_rows("a", estimator="all")', 'vn100.rows("a", rate=40)']
    script = tmp_path / "script.py"
    script.write_text("".join(BLOCKS) + "\n".join(wrong))
    printed = api.run(["--strict", "--cache-dir", str(tmp_path / "cache"), str(script)])[0]
    lines = len(script.read_text().splitlines())
    found = {int(line) for line in re.findall(r"script.py:(\d+): error", printed)}
    assert found == {lines - 2, lines - 1, lines}, printed
