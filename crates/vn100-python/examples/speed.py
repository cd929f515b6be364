"""How long arrays take: CPU seconds, and how often allantools takes as long.

    python speed.py

Medians of five runs; those of allantools come in between, so that both meet the same machine.
"""

import statistics
import time

import allantools
import numpy as np
import vn100

RUNS = 5


def seconds(*works):
    """The results of the works, and the CPU and elapsed times of each."""
    times = [[] for _ in works]
    for _ in range(RUNS):
        results = []
        for work, found in zip(works, times, strict=True):
            cpu, elapsed = time.process_time(), time.perf_counter()
            results.append(work())
            found.append((time.process_time() - cpu, time.perf_counter() - elapsed))
    return results, times


def median(times, which):
    return statistics.median(time[which] for time in times)


def main():
    random = np.random.default_rng(1)
    rows = 1e-3 * random.standard_normal((5 * 3600 * 40, 12)) + 9.81

    def analyzed():
        analyzer = vn100.Analyzer([f"gyro_{place}" for place in range(12)], rate=40)
        analyzer.push(rows)
        return analyzer

    (analyzer,), (times,) = seconds(analyzed)
    print(f"Analyzer, 5 h at 40 Hz, 12 columns: {median(times, 0):.3f} s CPU, {median(times, 1):.3f} s")
    _, (times,) = seconds(analyzer.to_dict)
    print(f"its document: {median(times, 0):.3f} s CPU, {median(times, 1):.3f} s")
    counts = np.round(1000 * random.standard_normal(10_000_000))
    for name, data, data_type in [
        ("floats", counts * 1.234e-6, "freq"),
        ("whole numbers", counts, "freq"),
        ("whole phases", np.cumsum(counts), "phase"),
    ]:
        (ours, theirs), (our_times, their_times) = seconds(
            lambda: vn100.oadev(data, rate=40, data_type=data_type),
            lambda: allantools.oadev(data, rate=40, data_type=data_type),
        )
        ratio = statistics.median(their / our for (our, _), (their, _) in zip(our_times, their_times, strict=True))
        print(
            f"oadev of 10 million {name}, octaves: {median(our_times, 0):.3f} s CPU, {median(our_times, 1):.3f} s; allantools "
            f"{median(their_times, 0):.3f} s CPU, {median(their_times, 1):.3f} s: {ratio:.1f} times the CPU; "
            f"differ by {np.max(np.abs(ours[1] / theirs[1] - 1)):.1e} at most"
        )


if __name__ == "__main__":
    main()
