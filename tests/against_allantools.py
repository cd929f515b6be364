"""Compares `vn100 replay` with allantools, on any capture of whole $VNYMR lines: every octave of every channel, and with all overlaps
the averaging factors 1, 2, 4, 10, 20, 40 ... too.

    python3 -m venv .venv && .venv/bin/pip install allantools==2024.6
    cargo build --release
    .venv/bin/python tests/against_allantools.py replay-logs/clean-minute.vnymr

Not part of the tests, which need no Python. Prints the largest relative difference; fails beyond 1e-9.
"""

import json
import subprocess
import sys

import allantools
import numpy

RATE_HZ = 40.0
PEERS = {
    ("full", "allan", "octave"): allantools.oadev,
    ("full", "allan", "decade"): allantools.oadev,
    ("full", "hadamard", "octave"): allantools.ohdev,
    ("full", "hadamard", "decade"): allantools.ohdev,
    ("plain", "allan", None): allantools.adev,
    ("plain", "hadamard", None): allantools.hdev,
}


def rows(path):
    """The values of all lines whose checksum is right, angles unwrapped."""
    values = []
    for line in open(path, "rb"):
        body, star, digits = line.strip()[1:].partition(b"*")
        checksum = 0
        for byte in body:
            checksum ^= byte
        if line.startswith(b"$VNYMR,") and star and checksum == int(digits, 16):
            values.append([float(field) for field in body.split(b",")[1:]])
    values = numpy.array(values)
    for angle in range(3):
        turns = numpy.round(numpy.diff(values[:, angle]) / 360.0)
        values[1:, angle] -= 360.0 * numpy.cumsum(turns)
    return values


def main(path, program):
    values = rows(path)
    worst = 0.0
    for (estimator, deviation, times), peer in PEERS.items():
        options = ["--rate", str(RATE_HZ), "--estimator", estimator, "--deviation", deviation]
        options += ["--taus", times] if times else []
        command = [program, "replay", "--json", path, *options]
        document = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
        compared = 0
        for channel, series in zip(document["channels"], values.T):
            ours = {point["m"]: point for point in channel["allan"]["points"]}
            taus = [point["tau_s"] for point in ours.values()]
            # allantools leaves out octaves with a single term
            for tau, theirs, _, terms in zip(*peer(series, rate=RATE_HZ, data_type="freq", taus=taus)):
                point = ours[round(tau * RATE_HZ)]
                assert point["terms"] == terms, (channel["name"], point, terms)
                worst = max(worst, abs(point["deviation"] - theirs) / theirs)
                compared += 1
        print(f"{estimator:6} {deviation:9} {times or 'octave':7} {compared} points")
    print(f"largest relative difference {worst:.1e}")
    return 0 if worst <= 1e-9 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "target/release/vn100"))
