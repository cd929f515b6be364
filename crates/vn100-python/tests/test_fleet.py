"""The Dask example on two worker processes beside the command line, bit for bit."""

import gzip
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[1] / "examples" / "fleet_dask.py"


def test_two_workers_write_the_bytes_of_the_command_line(log, tmp_path):
    pytest.importorskip("dask.distributed")
    program = os.environ.get("VN100_PROGRAM")
    captures = tmp_path / "captures"
    (captures / "deep").mkdir(parents=True)
    for number in range(6):
        lines = log.read_bytes().splitlines(keepends=True)[100 * number :]
        (captures / ("deep" if number % 2 else ".") / f"{number}.vnymr").write_bytes(b"".join(lines))
    (captures / "packed.vnymr.gz").write_bytes(gzip.compress(log.read_bytes()))
    (captures / ".hidden.vnymr").write_bytes(log.read_bytes())
    (captures / "broken.vnymr").write_bytes(b"nothing of a sensor")
    if program is not None:
        parts = [program, "record", "-", "-o", "night.mcap", "--rotate", "200kB"]
        subprocess.run(parts, cwd=captures, input=log.read_bytes(), check=True, capture_output=True)
        assert len(list(captures.glob("night.*.mcap"))) > 1
    shutil.copy(log, captures / "notes.md")
    dask = [sys.executable, str(EXAMPLE), "captures", "-o", "dask.json", "--workers", "2"]
    subprocess.run(dask, cwd=tmp_path, check=True, timeout=300)
    written = (tmp_path / "dask.json").read_bytes()
    assert written.count(b'"error": null') == 7 + (program is not None) and b"is not a capture" in written
    if program is None:
        pytest.skip("VN100_PROGRAM names no program to compare with")
    subprocess.run([program, "archive", "captures", "-o", "cli.json", "-q"], cwd=tmp_path, check=False)
    assert written == (tmp_path / "cli.json").read_bytes()
