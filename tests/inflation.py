"""Drives with an emulated IMU, and an error-state filter that is given the noise of the sensor in several ways.

    python tests/inflation.py --svg docs/inflation.svg      # the numbers and the figure of docs/reading.md

The package `vn100` (crates/vn100-python) measures a record at rest of the sensor. Each drive of ten minutes has other noise of the
same kind. The filter has attitude, velocity, position and both biases, in a flat frame that does not rotate. GNSS gives position
and velocity every second, except in three gaps of a minute; the last one ends the drive. The same drives follow with errors of the
scale factor, vibration and jitter of the sample times, of which the filter knows nothing.

NEES is the squared error of attitude, velocity and position over the covariance that the filter states. Its mean is 9 if the
covariance is right; if the filter is too sure, the mean of the drives lies above the limit of chi-square. `--exact` tests the filter
itself: the sensor has white noise and a walk alone, and the filter is given exactly these.
"""

import argparse
import math

import numpy as np
import vn100

RATE, STEPS = 50, 5  # samples per second; samples to a step of the covariance
GAPS_S = [(180, 240), (360, 420), (540, 600)]
GNSS_M, GNSS_M_S = 1.0, 0.1
GRAVITY = np.array([0.0, 0.0, -9.80665])
DEGREE, HOUR, MG = math.pi / 180, 3600.0, 9.80665e-3
# typical figures of a VN-100: N and B of its data sheet, and a walk below the flicker
SENSOR = {
    "gyro": {"N": 0.21 * DEGREE / 60, "B": 6 * DEGREE / HOUR, "K": 6 * DEGREE / HOUR / 60},
    "accel": {"N": 0.14 * MG, "B": 0.04 * MG, "K": 0.03 * MG / 60},
}
# standard deviations at the start: attitude (heading last), velocity, position, biases
START = np.array([0.5 * DEGREE] * 2 + [2 * DEGREE] + [0.1] * 3 + [1.0] * 3 + [0.05 * DEGREE] * 3 + [5 * MG] * 3)
# what the filter does not know: standard deviations of scale factor and jitter, amplitudes of vibration at 10 to 20 Hz
SCALE, JITTER_S, VIBRATION = 0.003, 0.002, (0.3 * DEGREE, 0.3)

COLOURS = ("#e0503c", "#c78a00", "#3b8eea", "#1f9e77", "#a06cd5")


def cross(of):
    """The matrices with which a cross product is taken."""
    x, y, z = np.moveaxis(of, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*of.shape, 3)


def rotation(by):
    """The rotations by these vectors."""
    angle = np.linalg.norm(by, axis=-1)[..., None, None] + 1e-12
    axis = cross(by) / angle
    return np.eye(3) + np.sin(angle) * axis + (1 - np.cos(angle)) * axis @ axis


def vector(of):
    """The vectors of small rotations."""
    sine = np.stack([of[..., a, b] - of[..., b, a] for a, b in ((2, 1), (0, 2), (1, 0))], -1) / 2
    length = np.linalg.norm(sine, axis=-1, keepdims=True) + 1e-12
    return sine * np.arcsin(np.minimum(length, 1)) / length


def true_drives(drives, seconds, random):
    """Attitude, velocity and position at every sample, and the rate and force that an ideal sensor shows between two of them."""
    time = np.arange(seconds * RATE + 1)[:, None] / RATE

    def wave(period_s):
        return np.sin(2 * np.pi * (time / period_s + random.uniform(size=drives)))

    heading = 1.2 * wave(47) + 0.8 * wave(110) + 2 * np.pi * time / 300
    level = np.zeros_like(heading)
    lean = rotation(np.stack([0.03 * wave(7), 0.02 * wave(5), level], -1))
    attitude = rotation(np.stack([level, level, heading], -1)) @ lean
    velocity = (12 + 6 * wave(75))[..., None] * np.stack([np.cos(heading), np.sin(heading), level], -1)
    back = np.swapaxes(attitude[:-1], -1, -2)
    rate = vector(back @ attitude[1:]) * RATE
    force = (back @ (np.diff(velocity, axis=0) * RATE - GRAVITY)[..., None])[..., 0]
    moves = (velocity[:-1] + velocity[1:]) / 2 / RATE
    return (attitude, velocity, np.concatenate([np.zeros((1, drives, 3)), np.cumsum(moves, 0)])), (rate, force)


def own_errors(sensor, shape, seed, random):
    """Noise and turn-on biases of rate and force."""
    names = [f"{name} {place}" for name in sensor for place in range(3 * shape[1])]
    noise = vn100.simulate({name: sensor[name.split()[0]] for name in names}, seconds=shape[0] / RATE, rate=RATE, seed=seed)
    noise = np.stack([noise[name] for name in names], -1).reshape(shape[0], 2, *shape[1:])
    return noise.swapaxes(0, 1) + START[9:].reshape(2, 1, 1, 3) * random.standard_normal((2, 1, *shape[1:]))


def disturbed(ideal, random):
    """What a sensor without noise shows of ideal samples, with what the filter does not know."""
    count, drives, _ = ideal[0].shape
    late_s = JITTER_S * random.standard_normal((count, drives, 1))
    time = np.arange(count)[:, None, None] / RATE + late_s
    for series, vibration in zip(ideal, VIBRATION):
        hertz, phase = random.uniform(10, 20, (drives, 3)), random.uniform(0, 2 * np.pi, (drives, 3))
        scale = 1 + SCALE * random.standard_normal((drives, 3))
        sampled = series + late_s * np.gradient(series, 1 / RATE, axis=0)
        yield scale * (sampled + vibration * np.sin(2 * np.pi * hertz * time + phase))


def propagate(covariance, turn, force, given, dt):
    """The covariance after a step with this mean attitude and force in the frame of the map."""
    tilt = -cross(force)
    phi = np.tile(np.eye(15), (*covariance.shape[:2], 1, 1))
    phi[..., 0:3, 9:12] = -turn * dt
    phi[..., 3:6, 0:3], phi[..., 3:6, 12:15] = tilt * dt, -turn * dt
    phi[..., 3:6, 9:12] = -tilt @ turn * dt**2 / 2
    phi[..., 6:9, 0:3], phi[..., 6:9, 12:15] = tilt * dt**2 / 2, -turn * dt**2 / 2
    phi[..., 6:9, 3:6], phi[..., 6:9, 9:12] = np.eye(3) * dt, -tilt @ turn * dt**3 / 6
    covariance = phi @ covariance @ np.swapaxes(phi, -1, -2)
    gyro, gyro_walk, accel, accel_walk = given.T
    added = np.stack([gyro, accel, 0 * gyro, gyro_walk, accel_walk], -1) ** 2 * dt
    covariance[..., range(15), range(15)] += np.repeat(added, 3, -1)[:, None]
    return covariance


def filtered(truth, shown, given, random):
    """For each set of noise that is given, and each drive: NEES by second, the horizontal error at the end, and the error that the
    filter states."""
    attitude, velocity, position = truth
    count, drives, _ = shown[0].shape
    shape = (len(given), drives)
    off = START * random.standard_normal((drives, 15))
    gnss = np.array([GNSS_M_S] * 3 + [GNSS_M] * 3)
    turn = np.broadcast_to(rotation(-off[:, :3]) @ attitude[0], (*shape, 3, 3))
    speed = np.broadcast_to(velocity[0] - off[:, 3:6], (*shape, 3))
    place = np.broadcast_to(position[0] - off[:, 6:9], (*shape, 3))
    bias = np.zeros((*shape, 6))
    covariance = np.tile(np.diag(START**2), (*shape, 1, 1))
    nees, mean_turn, mean_force = [], 0.0, 0.0
    for sample in range(count):
        now = sample + 1
        force = (turn @ (shown[1][sample] - bias[..., 3:])[..., None])[..., 0]
        mean_turn, mean_force = mean_turn + turn / STEPS, mean_force + force / STEPS
        turn = turn @ rotation((shown[0][sample] - bias[..., :3]) / RATE)
        place = place + (speed + (force + GRAVITY) / RATE / 2) / RATE
        speed = speed + (force + GRAVITY) / RATE
        if now % STEPS == 0:
            covariance = propagate(covariance, mean_turn, mean_force, given, STEPS / RATE)
            mean_turn, mean_force = 0.0, 0.0
        if now % RATE:
            continue
        if not any(start < now / RATE <= end for start, end in GAPS_S):
            seen = np.concatenate([velocity[now], position[now]], -1) + gnss * random.standard_normal((drives, 6))
            gain = covariance[..., 3:9] @ np.linalg.inv(covariance[..., 3:9, 3:9] + np.diag(gnss**2))
            step = (gain @ (seen - np.concatenate([speed, place], -1))[..., None])[..., 0]
            covariance = covariance - gain @ covariance[..., 3:9, :]
            covariance = (covariance + np.swapaxes(covariance, -1, -2)) / 2
            turn, speed = rotation(step[..., :3]) @ turn, speed + step[..., 3:6]
            place, bias = place + step[..., 6:9], bias + step[..., 9:]
        error = [vector(attitude[now] @ np.swapaxes(turn, -1, -2)), velocity[now] - speed, position[now] - place]
        error = np.concatenate(error, -1)[..., None]
        nees.append((np.swapaxes(error, -1, -2) @ np.linalg.solve(covariance[..., :9, :9], error))[..., 0, 0])
    stated = np.sqrt(covariance[..., 6, 6] + covariance[..., 7, 7])
    return np.array(nees), np.linalg.norm(error[..., 6:8, 0], axis=-1), stated


def given_to_filters(sensor, hours, seed):
    """N and K of the gyroscope, N and K of the accelerometer, by name, from a record at rest: each the largest of the axes."""
    axes = {f"{name}_{axis}": sensor[name] for name in sensor for axis in "xyz"}
    record = vn100.simulate(axes, seconds=hours * HOUR, rate=RATE, seed=seed)
    analyzer = vn100.Analyzer(list(record), rate=RATE)
    analyzer.push(record)
    result = analyzer.result()
    channels = result.to_dict()["channels"]

    def largest(of):
        values = np.array([of(channel) for channel in channels], float).reshape(2, 3, 2)
        return np.nan_to_num(values).max(1).ravel()  # a walk that is not estimated is none

    fit = largest(lambda axis: [axis["noise"][term]["value"] for term in ("white", "rate_random_walk")])
    bound = largest(lambda axis: [axis["inflation"][term] for term in ("white", "walk")])
    lines = dict(line.split(": ") for line in result.export("kalibr").splitlines() if line[0] != "#")
    keys = [f"{name}_{term}" for name in ("gyroscope", "accelerometer") for term in ("noise_density", "random_walk")]
    file = np.array([float(lines[key]) for key in keys])
    return {"fit": fit, "file": file, "bound": bound, "file x 10": 10 * file}


def chi_square(drives):
    """The limits within which the mean NEES of this many drives over 9 lies with 95 % (by Wilson and Hilferty)."""
    part = 2 / (81 * drives)
    return [(1 - part + z * math.sqrt(part)) ** 3 for z in (-1.96, 1.96)]


def compared(sensor, sets, drives, seconds, seed):
    """For drives without and with disturbance: mean NEES over 9 by second and set, and the errors of `filtered`."""
    random = np.random.default_rng(seed)
    truth, ideal = true_drives(drives, seconds, random)
    errors = own_errors(sensor, ideal[0].shape, 2 * seed + 1, random)
    for shown in (ideal, disturbed(ideal, np.random.default_rng([seed, 1]))):
        samples = [series + error for series, error in zip(shown, errors)]
        nees, *last = filtered(truth, samples, np.array(list(sets.values())), np.random.default_rng([seed, 2]))
        yield nees.mean(-1) / 9, *(np.sqrt(np.mean(np.square(of), -1)) for of in last)


def down(value):
    """Where a value lies in the figure."""
    return 250 - 70 * math.log10(min(max(value, 0.05), 30) / 0.05)


def panel(left, title, nees, limits):
    """The mean NEES of each set over time."""
    across, (low, high) = 310 / len(nees), (down(limit) for limit in limits)
    yield f'<text x="{left}" y="40">{title}: mean NEES / 9</text>'
    for start, end in GAPS_S:
        if end <= len(nees):
            yield f'<rect class="g" x="{left + start * across:.0f}" y="48" width="{(end - start) * across:.0f}" height="202"/>'
    yield f'<rect class="b" x="{left}" y="{high:.1f}" width="310" height="{low - high:.1f}"/>'
    for value in (0.1, 0.3, 1, 3, 10, 30):
        yield f'<path stroke="#888" stroke-width=".4" d="M{left} {down(value):.1f}h310"/>'
        yield f'<text x="{left - 5}" y="{down(value) + 4:.1f}" text-anchor="end">{value}</text>'
    for second in range(0, len(nees) + 1, 120):
        yield f'<text x="{left + second * across:.0f}" y="266" text-anchor="middle">{second} s</text>'
    for values, colour in zip(nees.T, COLOURS):
        points = " ".join(f"{left + second * across:.0f},{down(values[second]):.1f}" for second in range(4, len(nees), 5))
        yield f'<polyline stroke="{colour}" points="{points}"/>'


def figure(names, panels, limits):
    """Both panels as SVG, for light and dark pages."""
    style = "text{fill:#24292f}.g{fill:#888;opacity:.25}.b{fill:#888;opacity:.6}polyline{fill:none;stroke-width:1.6}"
    yield '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 290" font-family="sans-serif" font-size="11">'
    yield f"<style>{style}@media(prefers-color-scheme:dark){{text{{fill:#e6edf3}}}}</style>"
    for name, colour, left in zip(names, COLOURS, (40, 95, 160, 235, 400)):
        yield f'<path d="M{left} 13h16" stroke="{colour}" stroke-width="3"/><text x="{left + 20}" y="17">{name}</text>'
    for left, title, nees in zip((40, 390), ("noise of the record", "with scale factor, vibration, jitter"), panels):
        yield from panel(left, title, nees, limits)
    yield '<text x="40" y="284">shaded: gaps of GNSS, and where 95 % of means lie if the covariance is right</text></svg>'


def main():
    parser = argparse.ArgumentParser(description="Compares what an error-state filter can be given of the noise of its sensor.")
    parser.add_argument("--drives", type=int, default=50)
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--hours", type=float, default=6.0, help="of the record at rest")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--exact", action="store_true", help="white noise and walk alone, and a filter that is given these")
    parser.add_argument("--svg", help="where to write the figure")
    asked = parser.parse_args()
    sensor = {name: terms | {"B": 0.0} for name, terms in SENSOR.items()} if asked.exact else SENSOR
    exact = np.array([terms[term] for terms in sensor.values() for term in "NK"])
    sets = {"exact": exact} if asked.exact else given_to_filters(sensor, asked.hours, 2 * asked.seed)
    limits = chi_square(asked.drives)
    for name, given in sets.items():
        print(f"{name:24} N, K of the gyroscope {given[0]:.2e} {given[1]:.2e}, of the accelerometer {given[2]:.2e} {given[3]:.2e}")
    print(f"{asked.drives} drives, seed {asked.seed}; chi-square: {limits[0]:.2f} to {limits[1]:.2f}")
    panels = []
    for title, (nees, error, stated) in zip(("plain", "disturbed"), compared(sensor, sets, asked.drives, asked.seconds, asked.seed)):
        panels.append(nees)
        for at, name in enumerate(sets):
            above = 100 * np.mean(nees[:, at] > limits[1])
            print(f"{title:9} {name:24} NEES/9 {nees[:, at].mean():5.2f}, too sure {above:3.0f} % of the time;"
                  f" error at the end {error[at]:5.1f} m, stated {stated[at]:5.1f} m")
    if asked.svg:
        with open(asked.svg, "w") as file:
            print(*figure(sets, panels, limits), sep="\n", file=file)


if __name__ == "__main__":
    main()
