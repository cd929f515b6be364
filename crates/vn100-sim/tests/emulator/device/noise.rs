//! The noise of the device: window, decimation, refresh rates, and the filter that removes the gyro
//! bias.

use std::time::Duration;

use vn100_protocol::{Decoder, Item, Options, Packet};
use vn100_sim::{DeviceConfig, Profile, noise::NoiseTruth};

use super::bench::{BOOT_MS, Bench};

/// Channels 0 to 11 of `$VNYMR`, in their units.
fn rows(output: &[u8]) -> Vec<[f64; 12]> {
    let mut rows = Vec::new();
    Decoder::new(Options::default()).push(output, |item| {
        if let Item::Sample(sample) = item {
            rows.push(sample.values().collect::<Vec<_>>().try_into().unwrap());
        }
    });
    rows
}

fn standard_deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn column(rows: &[[f64; 12]], index: usize) -> Vec<f64> {
    rows.iter().map(|row| row[index]).collect()
}

/// Only white noise, with the densities of the data sheet.
fn white() -> DeviceConfig {
    let mut profile = Profile::datasheet();
    for channel in &mut profile.channels {
        channel.noise.bias_instability = 0.0;
    }
    DeviceConfig { profile, ..DeviceConfig::default() }
}

const GYRO_DENSITY: f64 = 6.1087e-5;
const ACCEL_DENSITY: f64 = 1.37293e-3;
const MAG_DENSITY: f64 = 1.4e-4;

/// The deviation of the mean of `window` values, divided by that without the sensor's low pass,
/// from the impulse response.
fn deviation_behind_low_pass(is_accelerometer: bool, window: usize) -> f64 {
    let (a1, a2) = if is_accelerometer { (0.25, 0.0) } else { (0.499, -0.251) };
    let mut response = vec![0.0; 100];
    for at in 2..response.len() {
        let input = if (2..2 + window).contains(&at) { (1.0 - a1 - a2) / window as f64 } else { 0.0 };
        response[at] = input + a1 * response[at - 1] + a2 * response[at - 2];
    }
    (response.iter().map(|value| value * value).sum::<f64>() * window as f64).sqrt()
}

#[test]
fn sigma_follows_the_window_of_register_85() {
    // 6000 samples: one standard deviation of the estimate is 0.9 %, more if neighbours are correlated
    for (window, rate_hz, seconds) in
        [(4, 50, 120), (0, 50, 120), (1, 50, 120), (8, 50, 120), (16, 50, 120), (20, 40, 150)]
    {
        let mut bench = Bench::quiet_with(white());
        bench.set(&format!("85,0,{window},{window},4,0,0,3,3,3,0"));
        bench.set(&format!("07,{rate_hz}"));
        bench.send("$VNASY,1*4E\r\n");
        let rows = rows(&bench.wait(Duration::from_secs(seconds)));
        assert!(rows.len() as u64 + 2 > u64::from(rate_hz as u32) * seconds);
        let averaged_hz = 800.0 / f64::from(window.max(1));
        for channel in 6..12 {
            let density = if channel < 9 { ACCEL_DENSITY } else { GYRO_DENSITY };
            let passed = deviation_behind_low_pass(channel < 9, window.max(1) as usize);
            let ratio = standard_deviation(&column(&rows, channel)) / (density * averaged_hz.sqrt() * passed);
            assert!((ratio - 1.0).abs() < 0.05, "window {window}, channel {channel}: {ratio}");
        }
        for channel in 3..6 {
            let ratio = standard_deviation(&column(&rows, channel)) / (MAG_DENSITY * 250_f64.sqrt());
            assert!((ratio - 1.0).abs() < 0.05, "channel {channel}: {ratio}");
        }
    }
}

#[test]
fn a_window_can_be_left_out_of_the_compensated_output() {
    let mut bench = Bench::quiet_with(white());
    // uncompensated only
    bench.set("85,0,4,4,4,0,0,1,1,1,0");
    bench.send("$VNASY,1*4E\r\n");
    let rows = rows(&bench.wait(Duration::from_secs(100)));
    let passed = deviation_behind_low_pass(false, 1);
    let ratio = standard_deviation(&column(&rows, 11)) / (GYRO_DENSITY * 800_f64.sqrt() * passed);
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
}

/// All floats of each packet after its masks.
fn floats(output: &[u8], header: usize) -> Vec<Vec<f32>> {
    let mut packets = Vec::new();
    Decoder::new(Options::default()).push(output, |item| {
        if let Item::Packet(Packet { raw, .. }) = item {
            let payload = &raw[header..raw.len() - 2];
            packets.push(payload.chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect());
        }
    });
    packets
}

#[test]
fn at_800_hz_gyro_is_new_in_every_packet_and_correlated_and_mag_comes_at_250() {
    let mut bench = Bench::quiet_with(white());
    bench.set("06,0");
    bench.set("05,921600");
    // uncompensated field, acceleration and rate
    bench.set("75,1,1,04,000E");
    bench.send("$VNASY,1*4E\r\n");
    let packets = floats(&bench.wait(Duration::from_secs(20)), 4);
    assert!(packets.len() > 15_990);
    let changes = |index: usize| packets.windows(2).filter(|pair| pair[0][index] != pair[1][index]).count();
    assert_eq!(changes(6), packets.len() - 1);
    let mag_hz = changes(0) as f64 / 20.0;
    assert!((mag_hz - 250.0).abs() < 1.0, "{mag_hz}");
    let rate: Vec<f64> = packets.iter().map(|packet| f64::from(packet[6])).collect();
    let mean = rate.iter().sum::<f64>() / rate.len() as f64;
    let covariance =
        |lag: usize| rate.iter().zip(&rate[lag..]).map(|(one, other)| (one - mean) * (other - mean)).sum::<f64>();
    // as in one second of a real sensor, within its own uncertainty
    for (lag, expected) in [(1, 0.83), (2, 0.49), (3, 0.17), (4, -0.02), (5, -0.05)] {
        let correlation = covariance(lag) / covariance(0);
        assert!((correlation - expected).abs() < 0.05, "lag {lag}: {correlation}");
    }
}

/// No noise; the gyro about x drifts.
fn drifting(ramp: f64) -> DeviceConfig {
    let mut profile = Profile::datasheet();
    for channel in &mut profile.channels {
        channel.noise = NoiseTruth::default();
    }
    profile.channels[9].noise.ramp = ramp;
    DeviceConfig { profile, ..DeviceConfig::default() }
}

#[test]
fn the_compensated_gyro_follows_a_drift_only_for_its_time_constant() {
    const RAMP: f64 = 1e-3;
    const TIME_CONSTANT_S: f64 = 30.0;
    let mut bench = Bench::switched_on(drifting(RAMP));
    bench.wait_ms(BOOT_MS);
    let rows = rows(&bench.wait(Duration::from_secs(200)));
    for (index, row) in rows.iter().enumerate() {
        let time_s = index as f64 / 40.0;
        let expected = RAMP * TIME_CONSTANT_S * (1.0 - (-time_s / TIME_CONSTANT_S).exp());
        assert!((row[9] - expected).abs() < 3e-6, "{time_s}: {}, expected {expected}", row[9]);
        assert_eq!(row[10], 0.0);
    }
}

#[test]
fn the_uncompensated_gyro_keeps_its_bias_and_its_drift() {
    let mut bench = Bench::quiet_with(drifting(1e-3));
    let gyro = |bench: &mut Bench| -> Vec<f64> {
        let reply = bench.ask("VNRRG,54");
        reply.split(',').skip(8).take(3).map(|field| field.parse().unwrap()).collect()
    };
    let first = gyro(&mut bench);
    bench.wait(Duration::from_millis(99_700));
    let later = gyro(&mut bench);
    assert!((later[0] - first[0] - 0.1).abs() < 1e-5, "{first:?} {later:?}");
    assert_eq!(later[1..], first[1..]);
    assert!(first[1..].iter().all(|bias| bias.abs() > 1e-4 && bias.abs() < 0.1));
}

#[test]
fn temperature_rises_to_its_rest_and_pressure_is_that_of_the_air() {
    let mut bench = Bench::quiet();
    let read = |bench: &mut Bench| -> (f64, f64) {
        let reply = bench.ask("VNRRG,54");
        let fields: Vec<&str> = reply.split(['*', ',']).collect();
        (fields[11].parse().unwrap(), fields[12].parse().unwrap())
    };
    let (cold_c, _) = read(&mut bench);
    bench.wait(Duration::from_secs(900));
    let (warm_c, pressure_kpa) = read(&mut bench);
    assert!((21.8..22.3).contains(&cold_c), "{cold_c}");
    // 63 % of 11 degrees
    assert!((28.7..29.2).contains(&warm_c), "{warm_c}");
    assert!((101.2..101.45).contains(&pressure_kpa));
}

#[test]
fn equal_seeds_give_equal_bytes_and_reading_changes_no_noise() {
    let output = |seed: u64, reads: bool| {
        let mut bench = Bench::switched_on(DeviceConfig { seed, ..DeviceConfig::default() });
        let mut output = bench.wait(Duration::from_millis(BOOT_MS + 1000));
        if reads {
            bench.send("$VNRRG,27*76\r\n$VNRRG,54*72\r\n");
        }
        output.extend(bench.wait(Duration::from_secs(5)));
        rows(&output)
    };
    assert_eq!(output(1, false), output(1, false));
    assert_eq!(output(1, false), output(1, true));
    assert_ne!(output(1, false), output(2, false));
}

#[test]
fn a_density_stated_for_the_output_holds_with_factory_defaults() {
    let published = [0.051601, 0.006165, 0.004488, 0.001378, 0.002924, 0.003743, 0.011822, 0.011932, 0.020968];
    let profile = Profile::lab3();
    let mut bench = Bench::switched_on(DeviceConfig { profile, ..DeviceConfig::default() });
    let rows = rows(&bench.wait(Duration::from_secs(200)));
    for (channel, published) in published.into_iter().enumerate() {
        let found = standard_deviation(&column(&rows, channel));
        assert!((found / published - 1.0).abs() < 0.05, "{channel}: {found}, published {published}");
    }
}

#[test]
fn the_bias_follows_the_temperature_as_the_truth_has_it() {
    let mut config = white();
    for channel in &mut config.profile.channels {
        channel.noise = NoiseTruth { mean: channel.noise.mean, ..NoiseTruth::default() };
    }
    config.profile.thermal = "gyro=0.5 accel=20 lag=5 heating=10 warm-up=20".parse().unwrap();
    let mut bench = Bench::quiet_with(config);
    // angular rate x, specific force y, temperature of register 54
    let measured = |bench: &mut Bench| -> [f64; 3] {
        let answer = bench.ask("VNRRG,54");
        let fields: Vec<&str> = answer.split(['*', ',']).collect();
        [8, 6, 11].map(|field| fields[field].parse().unwrap())
    };
    let [rate_rad_s, force_m_s2, begun_c] = measured(&mut bench);
    bench.wait(Duration::from_secs(300));
    let [later_rad_s, later_m_s2, ended_c] = measured(&mut bench);
    let degrees = ended_c - begun_c;
    assert!((8.5..10.5).contains(&degrees), "{degrees}");
    // the temperature is printed to 0.1 °C, and the bias lags it by 5 s
    let lagging = 0.06;
    let of_rate = (later_rad_s - rate_rad_s).to_degrees() / (0.5 * degrees);
    let of_force = (later_m_s2 - force_m_s2) / (0.02 * 9.80665 * degrees);
    assert!((of_rate - 1.0).abs() < lagging && (of_force - 1.0).abs() < lagging, "{of_rate} {of_force}");
}
