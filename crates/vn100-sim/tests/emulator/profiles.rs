//! The profiles as captures: pinned first lines, and the published record that they represent.

use std::num::NonZeroU32;

use vn100_sim::{Generator, Message, Profile, capture::write_next, noise::ChannelStream};

/// The captures of all users change with these lines: do not update them without an important reason.
#[test]
fn first_lines_are_pinned() {
    for (profile, rate_hz, lines) in [
        (
            Profile::lab3(),
            40,
            [
                "$VNYMR,+052.267,+000.265,-000.004,+00.2263,+00.1184,+00.0624,+00.049,-00.009,-09.722,-00.001453,-00.000175,+00.000531*6D",
                "$VNYMR,+052.357,+000.263,+000.001,+00.2259,+00.1217,+00.0579,+00.054,+00.028,-09.696,-00.000847,+00.000027,+00.000438*66",
                "$VNYMR,+052.282,+000.277,+000.010,+00.2251,+00.1245,+00.0595,+00.027,+00.002,-09.730,-00.000045,-00.001119,+00.000270*6D",
            ],
        ),
        (
            Profile::datasheet(),
            200,
            [
                "$VNYMR,-000.010,-000.009,-000.007,+00.2105,-00.0037,+00.4329,-00.019,+00.013,-09.825,+00.000132,-00.000808,+00.001001*65",
                "$VNYMR,+000.002,-000.011,+000.001,+00.2099,-00.0012,+00.4302,+00.007,+00.001,-09.816,-00.000220,-00.000089,+00.000295*60",
                "$VNYMR,-000.008,+000.005,+000.015,+00.2086,+00.0009,+00.4312,-00.024,-00.017,-09.816,+00.000847,+00.000594,+00.000176*63",
            ],
        ),
    ] {
        let mut capture = Vec::new();
        let mut generator = Generator::new(&profile, rate_hz, 1).unwrap();
        let message = Message::named("VNYMR").unwrap();
        (0..3).for_each(|_| write_next(&mut capture, message, &mut generator));
        let expected = lines.map(|line| format!("{line}\r\n")).concat();
        assert_eq!(String::from_utf8(capture).unwrap(), expected, "{}", profile.name);
    }
}

#[test]
fn ten_minutes_of_lab3_have_the_published_means_and_deviations() {
    // mean and standard deviation, as printed with the record
    let published = [
        (52.339768, 0.051601),
        (0.272679, 0.006165),
        (0.000704, 0.004488),
        (0.225998, 0.001378),
        (0.123310, 0.002924),
        (0.057567, 0.003743),
        (0.048526, 0.011822),
        (0.000759, 0.011932),
        (-9.717405, 0.020968),
        (0.000051, 0.000638),
        (-0.000152, 0.000766),
        (-0.000009, 0.000638),
    ];
    let n = 24_000;
    let mut generator = Generator::new(&Profile::lab3(), 40, 1).unwrap();
    let rows: Vec<_> = (0..n).map(|_| generator.next_row().map(f64::from)).collect();
    for (channel, (mean, deviation)) in published.into_iter().enumerate() {
        let values = rows.iter().map(|row| row[channel]);
        let found_mean = values.clone().sum::<f64>() / n as f64;
        let found_variance = values.map(|value| (value - found_mean).powi(2)).sum::<f64>() / n as f64;
        let noise = &Profile::lab3().channels[channel].noise;
        // a walk's mean over T has the deviation K·sqrt(T/3); the flicker in its initial state has 2.6 B
        let slow = noise.random_walk * 200.0_f64.sqrt() + 2.6 * noise.bias_instability;
        let tolerance = 4.5 * (deviation / (n as f64).sqrt() + slow);
        assert!((found_mean - mean).abs() < tolerance, "channel {channel}: mean {found_mean}");
        // 2 % for the profile, 4.5 sigma for the sample
        let relative = found_variance.sqrt() / deviation - 1.0;
        assert!(relative.abs() < 0.02 + 4.5 / (2.0 * n as f64).sqrt(), "channel {channel}: {relative}");
    }
}

/// Minimum over octaves of the fully overlapping Allan deviation, divided by 0.664.
fn bias_reading(values: &[f64]) -> f64 {
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    let mut minimum = f64::INFINITY;
    let mut m = 1;
    while 2 * m <= values.len() {
        let windows = values.len() - 2 * m + 1;
        let squares = (0..windows).map(|i| (sums[i + 2 * m] - 2.0 * sums[i + m] + sums[i]).powi(2));
        let avar = squares.sum::<f64>() / (windows as f64 * 2.0 * (m * m) as f64);
        minimum = minimum.min(avar.sqrt());
        m *= 2;
    }
    minimum / 0.664
}

/// The published 0.830 deg/h of gyro y and 0.0356 mg of accelerometer y result from this truth,
/// although it has no flicker, or a third of these values.
#[test]
fn five_hours_of_lab3_give_the_published_bias_readings() {
    for (channel, published) in [(10, 0.830 / 206_264.806), (7, 0.0356 / 101.971621)] {
        let truth = &Profile::lab3().channels[channel];
        let rate_hz = NonZeroU32::new(40).unwrap();
        let reading = |seed| {
            let mut stream = ChannelStream::new(&truth.noise, truth.window, rate_hz, seed, channel as u32);
            let record: Vec<f64> = (0..5 * 3600 * 40).map(|_| stream.next_sample()).collect();
            bias_reading(&record)
        };
        let mut readings: Vec<f64> = (1..=9).map(reading).collect();
        readings.sort_by(f64::total_cmp);
        // single readings of the gyro vary by a third, the median of nine by an eighth
        let relative = readings[4] / published - 1.0;
        assert!(relative.abs() < 0.25, "channel {channel}: {relative}");
    }
}

/// Rounding is a part of the measured N, and half of the variance behind a filter that correlates two samples is gone.
#[test]
fn a_twin_has_the_variance_of_filtered_and_rounded_noise() {
    let (density, step) = (0.05, 0.3);
    for (samples, rounded) in [("null", step), ("2", 0.0), ("4", 0.0)] {
        let noise = format!("{{\"white\": {{\"value\": {density}}}, \"correlation_samples\": {samples}}}");
        let statistics = format!("{{\"mean\": 1.05, \"resolution\": {rounded}}}");
        let channel = format!("{{\"name\": \"mag_y\", \"statistics\": {statistics}, \"noise\": {noise}}}");
        let document = format!("{{\"timing\": {{\"rate_hz\": 40}}, \"channels\": [{channel}]}}");
        let twin = Profile::like(&document).unwrap();
        let rate_hz = NonZeroU32::new(40).unwrap();
        let mut stream = ChannelStream::new(&twin.channels[4].noise, twin.channels[4].window, rate_hz, 1, 4);
        let n = 100_000;
        let variance = (0..n).map(|_| (stream.next_sample() - 1.05).powi(2)).sum::<f64>() / n as f64;
        let relative = variance / (density * density * 40.0) * samples.parse().unwrap_or(1.0) - 1.0;
        assert!(relative.abs() < 0.03, "{samples}: {relative}");
    }
}
