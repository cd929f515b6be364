"""Captures of the project."""

import errno
import gzip
import html
import io
import json
import math
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest
import vn100


def test_a_capture_is_measured(log):
    result = vn100.replay(log, rate=40).only
    assert result.samples > 1000 and result.rate == 40.0
    curve = result["gyro_x"].curve
    assert curve.m[0] == 1 and curve.tau[0] == 0.025 and len(curve.tau) == len(curve.edf)
    assert result["gyro_x"].noise.white.status == "estimated"
    assert result.to_dict()["schema"] == "vn100.analysis/2"
    assert "<table>" in result._repr_html_() and str(result.samples) in repr(result)


def test_a_document_is_that_of_the_command_line(log, program):
    printed = subprocess.run([program, "replay", str(log), "--json"], capture_output=True, check=True)
    documents = [vn100.replay(log).only.to_dict(), json.loads(printed.stdout)]
    worded = [[warning.pop("text") for warning in document["warnings"]] for document in documents]
    assert documents[0] == documents[1]
    # what to do is said in the terms of each
    assert any("`rate=HZ`" in text for text in worded[0]) and any("`--rate HZ`" in text for text in worded[1])
    assert not any("--" in text or "vn100 " in text for text in worded[0])


def test_the_version_is_that_of_the_command_line(program):
    printed = subprocess.run([program, "--version"], capture_output=True, check=True, text=True)
    # behind the version stands the commit, where there is one
    assert printed.stdout.split()[:2] == ["vn100", vn100.__version__]


def test_rows_are_the_samples(log):
    rows = vn100.rows(log)
    assert rows.channels[-1] == "gyro_z" and rows.units[-1] == "rad/s"
    blocks = list(rows)
    times, values = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    result = vn100.replay(log, rate=40).only
    assert values.shape == (result.samples, len(rows.channels)) and times.shape == (result.samples,)
    np.testing.assert_allclose(values.mean(axis=0)[-1], result["gyro_z"].mean, rtol=1e-9)


def test_threads_may_share_the_rows(log, tmp_path):
    long = tmp_path / "long.vnymr"
    long.write_bytes(log.read_bytes() * 60)
    rows, counted, failed = vn100.rows(long), [], []

    def count():
        try:
            counted.append(sum(len(times) for times, _ in rows))
        except RuntimeError as error:
            failed.append(error)

    threads = [threading.Thread(target=count) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed and sum(counted) == vn100.replay(long, rate=40).only.samples
    assert isinstance(rows, vn100.Rows) and repr(rows) == "<vn100.Rows of long.vnymr: 12 channels>"


def test_rows_of_an_archive_are_the_numbers_of_the_result(log, tmp_path):
    rows = [json.loads(line) for line in vn100.archive_rows(log, rate=40)]
    result = vn100.replay(log, rate=40).only
    assert [row["channel"] for row in rows] == list(result) and {row["rows"] for row in rows} == {len(rows)}
    gyro = next(row for row in rows if row["channel"] == "gyro_x")
    white = result["gyro_x"].noise.white
    assert (gyro["white_status"], gyro["white"], gyro["white_upper"]) == (white.status, white.value, white.upper)
    broken = tmp_path / "broken.vnymr"
    broken.write_bytes(b"nothing of a sensor")
    (row,) = [json.loads(line) for line in vn100.archive_rows(broken)]
    assert row["channel"] is None and "is not a capture" in row["error"]


MEASURES = [vn100.replay, vn100.rows]


@pytest.mark.parametrize("measure", MEASURES)
def test_parts_are_taken_in_their_order(measure, parts):
    def bits(found):
        if isinstance(found, vn100.Results):
            return json.dumps(found.only.to_dict())
        return [values.tolist() for _, values in found]

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        whole = bits(measure(*parts))
        assert bits(measure(parts[2], parts[0], parts[3], parts[1])) == whole
    with pytest.warns(UserWarning, match=r"night.0001.mcap: parts 2, 3 are missing: the link counts as lost"):
        assert bits(measure(parts[3], parts[0])) != whole
    with pytest.warns(UserWarning, match="night.0002.mcap: the record begins with part 2"):
        measure(*parts[1:])


@pytest.mark.parametrize("measure", MEASURES)
def test_what_is_not_of_one_recording_is_not_joined(measure, parts, log, tmp_path):
    for files in [(log, log), (parts[0], log), (parts[0], parts[0])]:
        with pytest.raises(ValueError, match=f"{files[0].name}.*{files[1].name} are not parts of one recording"):
            measure(*files)
    for files in [(log, tmp_path / "none.vnymr"), (tmp_path / "none.mcap", parts[0])]:
        with pytest.raises(FileNotFoundError, match="cannot read .*none"):
            measure(*files)


def test_errors_are_exceptions_with_the_words_of_the_command_line(log, tmp_path):
    none, empty, unchecked = (tmp_path / name for name in ("none.mcap", "empty.vnymr", "unchecked.vnymr"))
    empty.write_bytes(b"nothing of a sensor")
    unchecked.write_bytes(re.sub(rb"\*..", b"", log.read_bytes()))
    for measure in MEASURES:
        with pytest.raises(FileNotFoundError, match="cannot read") as failure:
            measure(none)
        assert (failure.value.errno, failure.value.filename) == (errno.ENOENT, str(none))
        with pytest.raises(vn100.CaptureError, match="is not a capture"):
            measure(empty)
        with pytest.raises(vn100.CaptureError, match="no valid sample"):
            measure(unchecked)
    with pytest.raises(vn100.CaptureError, match="lines rejected: no checksum"):
        vn100.replay(unchecked)
    assert vn100.replay(unchecked, accept_unchecked=True, rate=40).only.samples > 1000


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="root may read every file")
def test_a_file_without_permission_is_a_permission_error(log, tmp_path):
    locked = tmp_path / "locked.vnymr"
    locked.write_bytes(log.read_bytes())
    locked.chmod(0)
    for measure in MEASURES:
        with pytest.raises(PermissionError):
            measure(locked)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"rates": 40}, TypeError, "rates: there is no such option"),
        ({"rate": "40"}, TypeError, "rate: must be real number"),
        ({"rate": 0}, ValueError, "rate: 0 Hz"),
        ({"rate": True}, TypeError, "rate: True is no number"),
        ({"estimator": "all"}, ValueError, 'estimator: "all" is none of'),
        ({"window": 0}, ValueError, "window: 0 is not between 1 and 800"),
        ({"window": 801}, ValueError, "window: 801 is not"),
        ({"window": -1}, ValueError, "window: -1 is not"),
        ({"window": "8"}, TypeError, "window: 'str'"),
        ({"duration": 0}, ValueError, "duration: 0 s contains no sample"),
        ({"duration": -1}, ValueError, "duration: -1.0 s is not a duration"),
        ({"coast": 60}, TypeError, "coast: "),
        ({"coast": [60, 0]}, ValueError, "coast: 0 s contains no sample"),
        ({"coast": [(60, "1")]}, TypeError, "coast: "),
        ({"skip": 60, "duration": 60}, ValueError, "duration: 60 s end within the 60 s that skip excludes"),
        ({"compensated": "perhaps"}, ValueError, 'compensated: "perhaps" is none of yes, no'),
        ({"compensated": 3}, TypeError, "compensated: 'int'"),
        ({"topic": 3}, TypeError, "topic: 'int'"),
    ],
)
def test_options_that_cannot_be_given_are_said(log, options, error, words):
    with pytest.raises(error, match=words):
        vn100.replay(log, **options)
    with pytest.raises(TypeError, match="rows has no option|topic: 'int'"):
        vn100.rows(log, **options)


def test_what_is_known_of_the_sensor_is_given(log):
    for compensated in (True, "yes"):
        noise = vn100.replay(log, rate=40, compensated=compensated, window=20).only["gyro_x"].noise
        assert noise.bias_instability.status == "not-measurable"
    drift = vn100.replay(log, rate=40, coast=[5, (10, 2.5)]).only.to_dict()["drift"]
    assert {(found["rest_s"], found["coast_s"]) for found in drift} == {(5, 5), (10, 2.5)}


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
    result = vn100.replay(log, rate=40).only
    (axes,) = result.plot("gyro_x", "gyro_y").axes
    # each with its model
    assert len(axes.lines) == 4 and axes.get_ylabel() == "Allan deviation in rad/s"
    figure = result.plot()
    assert len({axes.get_ylabel() for axes in figure.axes}) == len(figure.axes) == len({c.unit for c in result.values()})
    assert sum(len(axes.get_legend().get_texts()) for axes in figure.axes) == len(result) == 12
    figure.draw_without_rendering()


def test_without_matplotlib_a_plot_says_what_to_install(log, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match="pip install matplotlib"):
        vn100.replay(log, rate=40).only.plot("gyro_x")


def test_objects_show_themselves_in_a_line(log):
    channel = vn100.replay(log, rate=40).only["gyro_x"]
    assert repr(channel) == f"<vn100.Channel gyro_x: {channel.count} samples in rad/s>"
    assert repr(channel.curve) == f"<vn100.Curve: allan deviation at {len(channel.curve.tau)} averaging times>"


def test_a_parameter_has_the_digits_of_its_interval():
    def text(value, lower, upper):
        return str(vn100.Parameter("estimated", value, lower, upper, "u"))

    assert text(1.0109e-4, 1.0083e-4, 1.0135e-4) == "0.00010109 u (0.00010083 to 0.00010135)"
    assert text(1.5, 1.2, 1.9) == "1.50 u (1.20 to 1.90)" and text(1.0, 1.0, 1.0) == "1.00 u (1.00 to 1.00)"
    assert text(100.0, None, 130.0) == "100 u (? to 130)" and text(0.0, -1.0, 1.0) == "0.00 u (-1.00 to 1.00)"


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
    result = vn100.replay(packed, rate=40).only
    shown = result._repr_html_()
    assert result.error is not None and html.escape(result.error) in shown and "<td>gyro_x</td>" in shown
    assert "not measurable" in shown and "–" in shown


def test_bytes_and_open_files_give_what_their_file_gives(log):
    whole = vn100.replay(log).only.to_dict()

    def results(document):
        return document["channels"], document["timing"]["samples"]

    with log.open("rb") as file:
        opened = vn100.replay(file).only
    sources = [opened, *(vn100.replay(data).only for data in (log.read_bytes(), memoryview(log.read_bytes()), io.BytesIO(log.read_bytes())))]
    assert opened.name == log.name
    for found in sources:
        assert results(found.to_dict()) == results(whole)
    with pytest.raises(TypeError, match="open as text"), log.open() as text:
        vn100.replay(text)
    with pytest.raises(vn100.CaptureError):
        vn100.replay(b"")


def test_results_are_a_sequence_and_a_result_is_its_channels(log):
    results = vn100.replay(log, rate=40)
    assert len(results) == 1 and results[0] is results.only and [*results] == [results.only]
    assert isinstance(results[:1], vn100.Results) and "<table>" in results._repr_html_()
    with pytest.raises(ValueError, match="0 results, not one"):
        _ = results[1:].only
    with pytest.raises(TypeError, match=r"take \.only\['gyro_x'\]"):
        results["gyro_x"]
    result = results.only
    assert "gyro_x" in result and [*result] == [channel.name for channel in result.values()]
    with pytest.raises(KeyError, match="gyro_x may be meant"):
        result["gyro_X"]


def columns(frame):
    return {name: list(frame[name]) for name in frame}


@pytest.mark.parametrize("has_pandas", [True, False])
def test_tables_are_the_numbers_of_the_objects(log, monkeypatch, has_pandas):
    if has_pandas:
        pytest.importorskip("pandas")
    else:
        monkeypatch.setitem(sys.modules, "pandas", None)
    result = vn100.replay(log, rate=40).only
    curve = columns(result.curve("gyro_x"))
    assert curve["tau"] == result["gyro_x"].curve.tau.tolist() and len(curve["fitted"]) == len(curve["deviation"])
    table = columns(result.parameters())
    place = [*zip(table["channel"], table["parameter"])].index(("gyro_x", "white"))
    white = result["gyro_x"].noise.white
    assert [table[name][place] for name in ("status", "value", "upper", "unit")] == [white.status, white.value, white.upper, white.unit]
    unknown = [*zip(table["channel"], table["parameter"])].index(("gyro_x", "bias_instability"))
    assert table["status"][unknown] == "not-measurable" and math.isnan(table["value"][unknown])


def test_a_parameter_has_the_units_of_its_field(log):
    noise = vn100.replay(log, rate=40).only["gyro_x"].noise
    white = noise.white
    assert str(noise).startswith(f"N {white}, B not measurable, ")
    for unit in ("deg/sqrt(h)", "°/√h"):
        converted = white.to(unit)
        assert converted.unit == "deg/sqrt(h)"
        for one, other in ((converted.value, white.value), (converted.lower, white.lower), (converted.upper, white.upper)):
            assert math.isclose(one, math.degrees(other) * 60)
    assert white.to(white.unit) == white and math.isclose(white.to("deg/s/sqrt(Hz)").value, math.degrees(white.value))
    with pytest.raises(ValueError, match="mg is none of the units of this parameter: rad/s/sqrt"):
        white.to("mg")
    with pytest.raises(ValueError, match="no number to convert: not measurable"):
        noise.bias_instability.to("deg/h")


def test_a_result_is_written_for_people_and_programs(log, tmp_path):
    result = vn100.replay(log, rate=40).only
    page = tmp_path / "x.html"
    result.report(page)
    assert page.read_text().startswith("<!DOCTYPE html>") and log.name in page.read_text() and "--rate" not in page.read_text()
    with pytest.raises(FileExistsError):
        result.report(page)
    result.report(page, overwrite=True)
    with pytest.raises(ValueError, match='"kalibre" is none of kalibr, '):
        result.export("kalibre")
    with pytest.raises(ValueError, match="span"):
        result.export("kalibr", span=0.0)
    with pytest.raises(ValueError, match="no file for Kalibr: K of the gyroscope is missing"):
        result.export("kalibr")
    copy = pickle.loads(pickle.dumps(result))
    assert copy.to_dict() == result.to_dict() and copy["gyro_x"].noise == result["gyro_x"].noise
    with pytest.raises(ValueError, match="was pickled"):
        copy.export("kalibr")


def test_warnings_say_what_to_do_in_arguments(log):
    found = {warning.code: warning for warning in vn100.replay(log).only.warnings}
    assumed = next(warning for warning in found.values() if any("rate=HZ" in remedy for remedy in warning.remedies))
    assert assumed.severity in ("problem", "caution") and str(assumed) == assumed.text
    assert found["compensated-stream"].channels == ["gyro_x", "gyro_y", "gyro_z"]
