"""The files that the program writes for filters, read by the parsers that these use."""

import math
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

RATE = 200.0
# of the data sheet of the ADIS16470: 0.34 deg/sqrt(h), 0.037 m/s/sqrt(h), 8 deg/h, 13 ug over a minute
N_GYRO, N_ACCEL = math.radians(0.34) / 60, 0.037 / 60
K_GYRO, K_ACCEL = math.radians(8) / 3600 / math.sqrt(60), 13e-6 * 9.80665 / math.sqrt(60)


@pytest.fixture
def written(program: str, tmp_path: Path) -> Any:
    """Writes the file of a program, and gives its path."""

    def write(name: str) -> Path:
        path = tmp_path / name
        stream = ["--rate", str(RATE), "--window", "all", "--scale-factor", "300"]
        command = [program, "export", "--datasheet", "adis16470", "--to", name, *stream, "-o", str(path)]
        subprocess.run(command, check=True, capture_output=True)
        return path

    return write


def close(found: Any, expected: float) -> None:
    """A number, not the text of one, of five digits."""
    assert isinstance(found, float)
    assert found == pytest.approx(expected, rel=1e-4)


def yaml_of(path: Path) -> Any:
    """What PyYAML reads, which refuses the first line of OpenCV's files."""
    yaml = pytest.importorskip("yaml")
    text = path.read_text()
    return yaml.safe_load(text.removeprefix("%YAML:1.0\n"))


FOUR = ("accelerometer_noise_density", "accelerometer_random_walk", "gyroscope_noise_density", "gyroscope_random_walk")


def test_pyyaml_reads_numbers(written: Any) -> None:
    four = (N_ACCEL, K_ACCEL, N_GYRO, K_GYRO)
    kalibr = yaml_of(written("kalibr"))
    assert kalibr.keys() == {*FOUR, "rostopic", "update_rate"}
    for key, expected in zip(FOUR, four):
        close(kalibr[key], expected)
    assert kalibr["rostopic"] == "/imu/data" and kalibr["update_rate"] == RATE
    lio_sam = yaml_of(written("lio-sam"))["lio_sam"]
    for key, expected in zip(("imuAccNoise", "imuAccBiasN", "imuGyrNoise", "imuGyrBiasN"), four):
        close(lio_sam[key], expected)
    fast_lio = yaml_of(written("fast-lio"))["mapping"]
    for key, expected in zip(("acc_cov", "b_acc_cov", "gyr_cov", "b_gyr_cov"), four):
        close(fast_lio[key], expected**2 * RATE)
    gins = yaml_of(written("kf-gins"))["imunoise"]
    sigma = math.sqrt(gins["corrtime"] * 3600 / 2)
    degrees, milligal = math.degrees(1) * 3600, 1e5
    of_gins = {"arw": 0.34, "vrw": 0.037, "gbstd": K_GYRO * sigma * degrees, "abstd": K_ACCEL * sigma * milligal}
    for key, expected in (of_gins | {"gsstd": 300.0, "asstd": 300.0}).items():
        assert len(gins[key]) == 3
        close(gins[key][2], expected)
    ros = yaml_of(written("ros"))
    assert all(len(ros[key]) == 9 for key in ros) and ros["orientation_covariance"][0] == -1.0
    close(ros["angular_velocity_covariance"][4], N_GYRO**2 * RATE)
    close(ros["linear_acceleration_covariance"][8], N_ACCEL**2 * RATE)


def test_opencv_reads_numbers(written: Any) -> None:
    cv2 = pytest.importorskip("cv2")
    storage = cv2.FileStorage(str(written("openvins")), cv2.FILE_STORAGE_READ)
    node = storage.getNode("imu0")
    for key, expected in zip(FOUR, (N_ACCEL, K_ACCEL, N_GYRO, K_GYRO)):
        close(node.getNode(key).real(), expected)
    assert node.getNode("model").string() == "kalibr"
    for key in ("Tw", "Ta", "R_IMUtoGYRO", "R_IMUtoACC", "Tg"):
        assert [node.getNode(key).at(row).size() for row in range(3)] == [3, 3, 3]
    vins = cv2.FileStorage(str(written("vins")), cv2.FILE_STORAGE_READ)
    white, walk = math.sqrt(2 * RATE), math.sqrt(RATE)
    typed = {"acc_n": N_ACCEL * white, "gyr_n": N_GYRO * white, "acc_w": K_ACCEL * walk, "gyr_w": K_GYRO * walk}
    for key, expected in typed.items():
        close(vins.getNode(key).real(), expected)


def test_gtsam_propagates_what_was_typed(written: Any) -> None:
    gtsam = pytest.importorskip("gtsam")
    scope: dict[str, Any] = {}
    exec(compile(written("gtsam").read_text(), "gtsam", "exec"), scope)
    params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.81)
    scope["set_imu_noise"](params)
    preintegrated = gtsam.PreintegratedCombinedMeasurements(params, gtsam.imuBias.ConstantBias())
    seconds = 20
    for _ in range(seconds * int(RATE)):
        preintegrated.integrateMeasurement([0, 0, 9.81], [0, 0, 0], 1 / RATE)
    covariance = preintegrated.preintMeasCov()
    # the combined factor carries the bias into the angle
    angle = N_GYRO**2 * seconds + K_GYRO**2 * seconds**3 / 3
    assert covariance[0, 0] == pytest.approx(angle, rel=1e-3)
    assert covariance[9, 9] == pytest.approx(K_ACCEL**2 * seconds, rel=1e-3)
    assert covariance[12, 12] == pytest.approx(K_GYRO**2 * seconds, rel=1e-3)


def test_the_sdf_is_well_formed(written: Any) -> None:
    sensor = ElementTree.parse(written("gazebo")).getroot()
    assert sensor.tag == "sensor" and float(sensor.findtext("update_rate") or "") == RATE
    for name, white, walk in (("angular_velocity", N_GYRO, K_GYRO), ("linear_acceleration", N_ACCEL, K_ACCEL)):
        for axis in "xyz":
            noise = sensor.find(f"imu/{name}/{axis}/noise")
            assert noise is not None and noise.get("type") == "gaussian"
            number = {child.tag: float(child.text or "") for child in noise}
            close(number["stddev"], white * math.sqrt(RATE))
            close(number["dynamic_bias_stddev"], walk)
            assert number["dynamic_bias_correlation_time"] > 0
