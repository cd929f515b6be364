"""Captures of the project."""

import gzip
import html
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import vn100


def test_a_capture_is_measured(log):
    result = vn100.replay(log, rate=40)
    assert result.samples > 1000 and result.rate == 40.0
    curve = result.channels["gyro_x"].curve
    assert curve.m[0] == 1 and curve.tau[0] == 0.025 and len(curve.tau) == len(curve.edf)
    assert result.channels["gyro_x"].noise.white.status == "estimated"
    assert result.to_dict()["schema"] == "vn100.analysis/1"
    assert "<table>" in result._repr_html_() and str(result.samples) in repr(result)


def test_a_document_is_that_of_the_command_line(log):
    program = os.environ.get("VN100_PROGRAM")
    if program is None:
        pytest.skip("VN100_PROGRAM names no program to compare with")
    printed = subprocess.run([program, "replay", str(log), "--rate", "40", "--json"], capture_output=True, check=True)
    assert vn100.replay(log, rate=40).to_dict() == json.loads(printed.stdout)


def test_the_version_is_that_of_the_command_line():
    program = os.environ.get("VN100_PROGRAM")
    if program is None:
        pytest.skip("VN100_PROGRAM names no program to compare with")
    printed = subprocess.run([program, "--version"], capture_output=True, check=True, text=True)
    # behind the version stands the commit, where there is one
    assert printed.stdout.split()[:2] == ["vn100", vn100.__version__]


def test_rows_are_the_samples(log):
    rows = vn100.rows(log)
    assert rows.channels[-1] == "gyro_z" and rows.units[-1] == "rad/s"
    blocks = list(rows)
    times, values = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    result = vn100.replay(log, rate=40)
    assert values.shape == (result.samples, len(rows.channels)) and times.shape == (result.samples,)
    np.testing.assert_allclose(values.mean(axis=0)[-1], result.channels["gyro_z"].mean, rtol=1e-9)


def test_states_of_files(log, tmp_path):
    state = vn100.State.of_file(log, name="a", rate=40)
    assert state.recordings == [("a", None)] and pickle.loads(pickle.dumps(state)) == state
    (document,) = state.documents()
    found, whole = json.loads(document), vn100.replay(log, rate=40).to_dict()
    assert found["channels"] == whole["channels"]
    broken = vn100.State.of_error("b", "b: no such file")
    both = vn100.State.merged(state, None, broken)
    assert both == vn100.State.merged(broken, state)
    archive = json.loads(both.archive())
    assert [row["error"] for row in archive["recordings"]] == [None, "b: no such file"]
    assert both.to_dict() == archive
    damaged = bytearray(state.to_bytes())
    damaged[77] ^= 1
    with pytest.raises(ValueError, match="damaged"):
        vn100.State.from_bytes(bytes(damaged))


def test_errors_are_exceptions_with_the_words_of_the_command_line(tmp_path):
    with pytest.raises(FileNotFoundError, match="cannot read"):
        vn100.replay(tmp_path / "none.mcap")
    empty = tmp_path / "empty.vnymr"
    empty.write_bytes(b"nothing of a sensor")
    with pytest.raises(vn100.CaptureError, match="is not a capture"):
        vn100.replay(empty)
    with pytest.raises(TypeError, match='there is no option "rates"'):
        vn100.replay(empty, rates=40)
    with pytest.raises(ValueError, match='estimator "all"'):
        vn100.replay(empty, estimator="all")


def test_other_threads_run_meanwhile(log, tmp_path):
    long = tmp_path / "long.vnymr"
    long.write_bytes(log.read_bytes() * 60)
    counted, done = 0, threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1

    thread = threading.Thread(target=count)
    thread.start()
    vn100.replay(long, rate=40)
    done.set()
    thread.join()
    assert counted > 1000


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_ends_a_replay(log, tmp_path):
    fifo = tmp_path / "endless.vnymr"
    os.mkfifo(fifo)
    script = f"import vn100\ntry:\n vn100.replay({str(fifo)!r}, rate=40)\nexcept KeyboardInterrupt:\n print('interrupted')"
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    with open(fifo, "wb") as writer:
        writer.write(log.read_bytes()[:20_000])
        writer.flush()
        # the interpreter has imported what it needs once it reads
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        time.sleep(0.3)
    assert process.communicate(timeout=30)[0].strip() == b"interrupted"


def test_a_plot_is_drawn_where_there_is_matplotlib(log):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    axes = vn100.replay(log, rate=40).plot("gyro_x", "gyro_y")
    assert len(axes.lines) == 2 and axes.get_ylabel() == "Allan deviation in rad/s"
    all_of_them = vn100.replay(log, rate=40).plot()
    labels = [text.get_text() for text in all_of_them.get_legend().get_texts()]
    assert "accel_x (m/s^2)" in labels and all_of_them.get_ylabel() == "Allan deviation in the unit of each channel"


def test_without_matplotlib_a_plot_says_what_to_install(log, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match=r"pip install vn100\[plot\]"):
        vn100.replay(log, rate=40).plot("gyro_x")


def test_captures_are_those_of_a_folder(tmp_path):
    for name in ["b/two.VNYMR", "b/one.csv.gz", "a.bin", "notes.md", ".hidden/x.bin"]:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    found = vn100.captures(tmp_path)
    assert found == [[str(tmp_path / name)] for name in ["a.bin", "b/one.csv.gz", "b/two.VNYMR"]]
    assert vn100.captures(tmp_path / "notes.md", tmp_path / "a.bin") == [found[0], [str(tmp_path / "notes.md")]]
    assert vn100.captures() == []


def test_a_result_shows_itself_with_its_error(log, tmp_path):
    packed = tmp_path / "cut.vnymr.gz"
    packed.write_bytes(gzip.compress(log.read_bytes())[:-20_000])
    result = vn100.replay(packed, rate=40)
    shown = result._repr_html_()
    assert result.error is not None and html.escape(result.error) in shown and "<td>gyro_x</td>" in shown
    assert "not measurable" in shown and "–" in shown
