"""Compares `vn100 replay` with Stable32: an oven oscillator's frequency, 19 982 values, at every averaging time of its tables.

    python3 -m venv .venv && .venv/bin/pip download --no-deps --no-binary allantools allantools==2024.6
    tar xzf allantools-2024.6.tar.gz
    cargo build --release
    .venv/bin/python tests/against_stable32.py allantools-2024.6/tests/ocxo

Series and tables are those that allantools is tested with. Not part of the tests of this project. Fails where a deviation differs by
more than half of Stable32's last printed digit. The tables of all averaging times are of the frequency less its mean over 10 MHz.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

TABLES = [
    ("stable32_oadev_alltau.txt", "full", "allan"),
    ("stable32_ohdev_alltau.txt", "full", "hadamard"),
]


def points(program, capture, deviation, taus):
    options = ["--columns", "value=y:1", "--rate", "1", "--estimator", "full", "--deviation", deviation]
    command = [program, "replay", "--json", capture, *options, "--taus", ",".join(str(tau) for tau in taus)]
    document = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
    (channel,) = document["channels"]
    return {point["m"]: point for point in channel["allan"]["points"]}


def main(folder, program):
    folder = pathlib.Path(folder)
    lines = (folder / "ocxo_frequency.txt").read_text().splitlines()
    # as Stable32 was given it: 10 MHz off, of which the fractional frequency is 1e-7 times as large
    hertz = [line.split(".")[1] for line in lines if line and not line.startswith("#")]
    failed = False
    with tempfile.TemporaryDirectory() as scratch:
        capture = pathlib.Path(scratch) / "ocxo.csv"
        capture.write_text("n,y\n" + "".join(f"{n},0.{digits[:9]}\n" for n, digits in enumerate(hertz)))
        for name, estimator, deviation in TABLES:
            rows = [line.split() for line in (folder / name).read_text().splitlines() if line and line[0] != "#"]
            table = {int(row[0]): (int(row[2]), float(row[5])) for row in rows}
            ours = points(program, str(capture), deviation, table)
            worst, same_alpha = 0.0, 0
            for m, (terms, sigma) in table.items():
                point = ours[m]
                assert point["terms"] == terms, (name, m, point, terms)
                worst = max(worst, abs(point["deviation"] * 1e-7 - sigma) / sigma)
            failed |= worst > 5.1e-5
            print(f"{name}: {len(table)} averaging times, largest relative difference {worst:.1e}")
    sys.exit(failed)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "target/release/vn100")
