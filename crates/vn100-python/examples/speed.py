"""How long arrays take: CPU seconds, and how often allantools takes as long.

    python speed.py
"""

import time

import allantools
import numpy as np
import vn100


def seconds(work):
    """CPU and elapsed time, the best of three."""
    found = []
    for _ in range(3):
        cpu, elapsed = time.process_time(), time.perf_counter()
        result = work()
        found.append((time.process_time() - cpu, time.perf_counter() - elapsed))
    return result, min(cpu for cpu, _ in found), min(elapsed for _, elapsed in found)


def main():
    random = np.random.default_rng(1)
    rows = 1e-3 * random.standard_normal((5 * 3600 * 40, 12)) + 9.81

    def analyzed():
        analyzer = vn100.Analyzer([f"gyro_{place}" for place in range(12)], rate=40)
        analyzer.push(rows)
        return analyzer

    analyzer, cpu, elapsed = seconds(analyzed)
    print(f"Analyzer, 5 h at 40 Hz, 12 columns: {cpu:.3f} s CPU, {elapsed:.3f} s")
    _, cpu, elapsed = seconds(analyzer.to_dict)
    print(f"its document: {cpu:.3f} s CPU, {elapsed:.3f} s")
    counts = np.round(1000 * random.standard_normal(10_000_000))
    for name, data, data_type in [
        ("floats", counts * 1.234e-6, "freq"),
        ("whole numbers", counts, "freq"),
        ("whole phases", np.cumsum(counts), "phase"),
    ]:
        ours, cpu, elapsed = seconds(lambda: vn100.oadev(data, rate=40, data_type=data_type))
        theirs, their_cpu, their_elapsed = seconds(lambda: allantools.oadev(data, rate=40, data_type=data_type))
        difference = np.max(np.abs(ours[1] / theirs[1] - 1))
        print(
            f"oadev of 10 million {name}, octaves: {cpu:.3f} s CPU, {elapsed:.3f} s; allantools {their_cpu:.3f} s CPU, "
            f"{their_elapsed:.3f} s: {their_elapsed / elapsed:.1f} times; differ by {difference:.1e} at most"
        )


if __name__ == "__main__":
    main()
