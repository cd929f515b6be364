"""The examples of the README run as they stand."""

import os
import re
import shutil
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"


def test_the_examples_run(log, tmp_path, monkeypatch, capsys):
    shutil.copy(log, tmp_path / "run.vnymr")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(), re.S)
    assert len(blocks) >= 3 and os.getcwd() == str(tmp_path)
    for block in blocks:
        exec(compile(block, str(README), "exec"), names)
    assert "estimated" in capsys.readouterr().out
