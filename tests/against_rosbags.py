"""Compares `vn100 replay` of bags that Python's rosbags writes with allantools on the same numbers: ROS 1 uncompressed, bz2 and lz4;
rosbag2 in SQLite and MCAP, each compression; messages out of order; rates and accelerations on two topics.

    python3 -m venv .venv && .venv/bin/pip install allantools==2024.6 rosbags==0.11.9
    cargo build --release
    .venv/bin/python tests/against_rosbags.py bags 1000

`bags` is a folder that is written to, 1000 the number of messages; the bags among the tests of vn100-capture have 60. Not part of the
tests, which need no Python. Prints the processor time of each, beside that of rosbags reading it; fails where a deviation differs by
more than the resolution of a count.
"""

import json
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import allantools
import numpy
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

FIRST_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000
IMU = "sensor_msgs/msg/Imu"
ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
NAMES = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]


def message(store, row, index, part="both"):
    types = store.types
    at_ns = FIRST_NS + index * STEP_NS
    stamp = types["builtin_interfaces/msg/Time"](sec=at_ns // 10**9, nanosec=at_ns % 10**9)
    sequence = {"seq": index} if store is ROS1 else {}
    header = types["std_msgs/msg/Header"](**sequence, stamp=stamp, frame_id="x" * (index % 5))
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    rates = row[:3] if part != "accelerations" else [0.0] * 3
    accelerations = row[3:] if part != "rates" else [0.0] * 3
    absent, unknown = numpy.array([-1.0] + [0.0] * 8), numpy.zeros(9)
    return types[IMU](
        header=header,
        orientation=quaternion(0.0, 0.0, 0.0, 1.0),
        orientation_covariance=absent,
        angular_velocity=vector(*rates),
        angular_velocity_covariance=unknown,
        linear_acceleration=vector(*accelerations),
        linear_acceleration_covariance=unknown,
    )


def write_ros1(path, rows, compression):
    path.unlink(missing_ok=True)
    writer = Ros1Writer(path)
    if compression:
        writer.set_compression(Ros1Writer.CompressionFormat[compression])
    with writer:
        connection = writer.add_connection("/imu/data", IMU, typestore=ROS1)
        for index, row in enumerate(rows):
            data = ROS1.serialize_ros1(message(ROS1, row, index), IMU)
            writer.write(connection, FIRST_NS + index * STEP_NS + 3_000_000, data)


def write_ros2(path, rows, storage, compression=None, topics=(("/imu/data", "both", 1),), out_of_order=False):
    shutil.rmtree(path, ignore_errors=True)
    writer = Ros2Writer(path, version=9, storage_plugin=storage)
    if compression:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    order = list(range(len(rows)))
    if out_of_order:
        for index in range(5, len(rows) - 1, 7):
            order[index], order[index + 1] = order[index + 1], order[index]
    with writer:
        connections = [(writer.add_connection(name, IMU, typestore=ROS2), *rest) for name, *rest in topics]
        for index in order:
            for connection, part, step in connections:
                if index % step == 0:
                    data = ROS2.serialize_cdr(message(ROS2, rows[index], index, part), IMU)
                    writer.write(connection, FIRST_NS + index * STEP_NS + 3_000_000, data)


def processor_time(children=True):
    times = os.times()
    return times.children_user + times.children_system if children else times.user + times.system


def check(path, program, values):
    before = processor_time()
    command = [program, "replay", "--json", "--estimator", "full", str(path)]
    documents = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
    ours_s = processor_time() - before
    before = processor_time(children=False)
    with AnyReader([path], default_typestore=ROS2) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
    theirs_s = processor_time(children=False) - before
    worst = 0.0
    for document in documents if isinstance(documents, list) else [documents]:
        step = round(100.0 / document["timing"]["rate_hz"])
        series = values[::step]
        assert document["timing"]["samples"] == len(series), (path, document["timing"])
        for channel in document["channels"]:
            if channel["name"] not in NAMES:
                continue
            ours = {point["m"]: point["deviation"] for point in channel["allan"]["points"]}
            taus = [m * step / 100.0 for m in ours]
            column = series[:, NAMES.index(channel["name"])]
            found = allantools.oadev(column, rate=100.0 / step, data_type="freq", taus=taus)
            for tau, deviation in zip(found[0], found[1]):
                worst = max(worst, abs(ours[round(tau * 100.0 / step)] / deviation - 1.0))
    print(f"{path.name}: largest relative difference {worst:.2e}; {ours_s:.2f} s, rosbags {theirs_s:.2f} s")
    return worst


def main(folder, count, program):
    folder, count = Path(folder), int(count)
    folder.mkdir(exist_ok=True)
    random.seed(1)
    spread, mean = [0.002] * 3 + [0.02] * 3, [0.0] * 5 + [-9.8]
    rows = [[random.gauss(*channel) for channel in zip(mean, spread)] for _ in range(count)]
    sqlite, mcap = StoragePlugin.SQLITE3, StoragePlugin.MCAP
    for compression in [None, "BZ2", "LZ4"]:
        write_ros1(folder / f"{compression or 'plain'}.bag", rows, compression)
    write_ros2(folder / "db3", rows, sqlite)
    write_ros2(folder / "db3-messages", rows, sqlite, CompressionMode.MESSAGE)
    write_ros2(folder / "db3-files", rows, sqlite, CompressionMode.FILE)
    write_ros2(folder / "mcap", rows, mcap)
    write_ros2(folder / "mcap-chunks", rows, mcap, CompressionMode.STORAGE)
    write_ros2(folder / "mcap-out-of-order", rows, mcap, out_of_order=True)
    write_ros2(folder / "db3-two", rows, sqlite, topics=(("/gyro", "rates", 1), ("/accel", "accelerations", 2)))
    names = [path for path in sorted(folder.iterdir()) if path.suffix == ".bag" or path.is_dir()]
    worst = max(check(path, program, numpy.array(rows)) for path in names)
    return 0 if worst < 1e-5 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else "target/release/vn100"))
