"""The Dask example on two worker processes beside the command line, line for line."""

import gzip
import importlib.util
import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
import vn100

EXAMPLE = Path(__file__).parents[1] / "examples" / "fleet_dask.py"


def test_two_workers_one_of_them_killed_write_the_rows_of_the_command_line(log, tmp_path, monkeypatch):
    distributed = pytest.importorskip("dask.distributed")
    program = os.environ.get("VN100_PROGRAM")
    monkeypatch.chdir(tmp_path)
    captures = tmp_path / "captures"
    (captures / "deep").mkdir(parents=True)
    for number in range(12):
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
    specification = importlib.util.spec_from_file_location("fleet_dask", EXAMPLE)
    example = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(example)
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLE.parent))
    rows = []
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        workers = list(client.run(os.getpid).values())
        assert len(set(workers)) == 2
        for row in example.fleet(vn100.captures("captures"), client):
            if not rows:
                os.kill(workers[0], signal.SIGKILL)
            rows.append(row)
    assert sum('"error":null' in row for row in rows) == 12 * (13 + (program is not None))
    assert any("is not a capture" in row for row in rows)
    if program is None:
        pytest.skip("VN100_PROGRAM names no program to compare with")
    subprocess.run([program, "archive", "captures", "-o", "rows.jsonl", "-q"], check=False)
    assert "".join(rows) == (tmp_path / "rows.jsonl").read_text()
