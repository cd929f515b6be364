//! What a record warns of.

use imu_noise::{Status, Term};
use vn100_analysis::{
    Analysis, Assessment, Event, Finding, Happening, LongTauValidity, Peak, Rejected, Remedy, Settings, WarningKind,
};
use vn100_protocol::stream::{Batch, StreamCounts};
use vn100_protocol::{Channel, DeviceError, Layout, MeasuredPackets, Quantity, VNYMR};

use super::simulated::{Simulated, findings, named, still};

#[test]
fn a_sensor_at_rest_reads_gravity_and_the_field_of_the_earth() {
    let warnings = |level| Simulated { level, samples: 2000, ..Simulated::default() }.record().1.warnings;
    let off: fn(&Channel) -> (f64, f64) = |channel| match (channel.quantity, still(channel)) {
        (Quantity::Acceleration | Quantity::MagneticField, (mean, std)) => (0.4 * mean, std),
        (_, level) => level,
    };
    for (level, axes) in [(still as fn(&Channel) -> (f64, f64), 0), (off, 3)] {
        let warnings = warnings(level);
        assert_eq!(named(&warnings, WarningKind::MagnitudeOff).len(), 2 * axes);
        let found = findings(&warnings, WarningKind::MagnitudeOff);
        let is_said = |finding: &Finding| matches!(finding, Finding::Gravity(m_s2) if (m_s2 - 3.923).abs() < 1e-3);
        assert_eq!(found.iter().any(is_said), axes > 0, "{found:?}");
        assert_eq!(named(&warnings, WarningKind::NotStationary).len(), 0);
    }
    let coarse: fn(&Channel) -> (f64, f64) = |channel| match channel.quantity {
        Quantity::AngularRate => (0.0, 0.3),
        _ => still(channel),
    };
    assert_eq!(named(&warnings(coarse), WarningKind::QuantisationFloor), ["gyro_x", "gyro_y", "gyro_z"]);
}

/// Such as the frequency of a clock in hertz: the counts of 32 bits have no room for its noise.
#[test]
fn a_series_of_no_sensor_that_is_rounded_says_so() {
    let warnings = |noise_counts: i32| {
        let mut layout = Layout { channels: VNYMR.channels[11..].to_vec().into(), ..VNYMR.clone() };
        layout.channels.to_mut()[0].quantity = Quantity::Value;
        let counts =
            (0..2000_i32).map(|i| 1_000_000 + i.wrapping_mul(i).wrapping_mul(7919) % (noise_counts + 1)).collect();
        let mut analysis = Analysis::new(Settings { rate_hz: Some(1.0), ..Settings::default() });
        analysis.absorb(&Batch { layout: Some(std::sync::Arc::new(layout)), counts, ..Batch::default() });
        analysis.finish();
        Assessment::new(&analysis.snapshot(), 0.95).warnings
    };
    assert_eq!(named(&warnings(0), WarningKind::QuantisationFloor), ["gyro_z"]);
    assert!(named(&warnings(100), WarningKind::QuantisationFloor).is_empty());
}

#[test]
fn a_sample_far_out_leaves_its_axis_without_a_fit() {
    let added: fn(&Channel, u64) -> f64 =
        |channel, sample| if channel.name == "gyro_y" && sample == 7000 { 3e6 } else { 0.0 };
    let assessment = Simulated { added, ..Simulated::default() }.record().1;
    let noise = [6, 7, 8].map(|place| assessment.channels[place].noise.as_ref().unwrap());
    let known = noise.map(|noise| noise.parameter(Term::White).unwrap().status);
    assert_eq!(known, [Status::Estimated, Status::ModelRejected, Status::Estimated]);
    assert_eq!(noise[1].long_taus, LongTauValidity::Spoiled);
    assert_eq!(named(&assessment.warnings, WarningKind::NotStationary), ["gyro_y"]);
}

#[test]
fn vibration_steps_and_warm_up_are_named_with_their_place() {
    let added: fn(&Channel, u64) -> f64 = |channel, sample| {
        let at_s = sample as f64 * 0.025;
        match &*channel.name {
            "accel_x" | "accel_y" => 60.0 * (std::f64::consts::TAU * 5.0 * at_s).sin(),
            "gyro_x" => 1500.0 * (-at_s / 60.0).exp(),
            "gyro_z" if at_s >= 300.0 => 3000.0,
            _ => 0.0,
        }
    };
    let assessment = Simulated { added, ..Simulated::default() }.record().1;
    let withheld = |axis: usize| assessment.channels[axis].noise.as_ref().unwrap().level_changes;
    assert_eq!([6, 7, 8].map(withheld), [true, false, true], "gyro_y alone stays where it was");
    let warnings = assessment.warnings;
    assert_eq!(named(&warnings, WarningKind::VibrationLine), ["accel_x", "accel_y"]);
    let [Finding::Peaks(peaks)] = &findings(&warnings, WarningKind::VibrationLine)[..] else { panic!() };
    let [Peak { frequency_hz, axes, aliases_hz, mains_hz: None }] = &peaks[..] else { panic!("{peaks:?}") };
    assert!((frequency_hz - 5.0).abs() < 0.01 && axes.len() == 2, "{peaks:?}");
    assert!([35.0, 45.0, 75.0].iter().zip(aliases_hz).all(|(hz, found)| (hz - found).abs() < 0.05), "{peaks:?}");
    assert_eq!(named(&warnings, WarningKind::WarmUp), ["gyro_x"]);
    let warm_up = warnings.iter().find(|warning| warning.kind == WarningKind::WarmUp).unwrap();
    assert!(matches!(warm_up.remedies[..], [Remedy::Skip(Some(_))]), "{warm_up:?}");
    assert_eq!(named(&warnings, WarningKind::NotStationary), ["gyro_z"]);
    let [Finding::Events(events)] = &findings(&warnings, WarningKind::NotStationary)[..] else { panic!() };
    let is_step = |happening: &Happening| {
        let at_s = happening.span_s.map_or(0.0, |(from_s, _)| from_s);
        matches!(happening.what, Event::Step(amplitude, _) if (amplitude / 3e-3 - 1.0).abs() < 0.05)
            && (at_s - 300.0).abs() < 1.0
    };
    assert!(events.iter().any(is_step), "{events:?}");
    let still = Simulated::default().record().1.warnings;
    for kind in [WarningKind::VibrationLine, WarningKind::WarmUp, WarningKind::NotStationary] {
        assert_eq!(named(&still, kind).len(), 0, "{kind:?}");
    }
}

#[test]
fn a_cycle_that_the_record_holds_one_and_a_half_times_is_no_noise() {
    let added: fn(&Channel, u64) -> f64 = |channel, sample| {
        let cycle = |phase: f64| (std::f64::consts::TAU * sample as f64 * 0.025 / 400.0 + phase).sin();
        match &*channel.name {
            "gyro_x" => 130.0 * cycle(0.4),
            "gyro_y" => 130.0 * cycle(2.2),
            "gyro_z" => 130.0 * cycle(4.1),
            _ => 0.0,
        }
    };
    let (truth, white) = (300.0 * 1e-6 / 40_f64.sqrt(), [6, 7, 8]);
    for seed in 1..4 {
        let assessment = Simulated { added, seed, ..Simulated::default() }.record().1;
        assert_eq!(named(&assessment.warnings, WarningKind::NotStationary), ["gyro_x", "gyro_y", "gyro_z"]);
        for noise in white.map(|axis| assessment.channels[axis].noise.as_ref().unwrap()) {
            let [n, b, k] =
                [Term::White, Term::BiasInstability, Term::RateRandomWalk].map(|term| noise.parameter(term).unwrap());
            assert!(noise.level_changes);
            assert_eq!([n, b, k].map(|term| term.status), [Status::Estimated, Status::Bounded, Status::Bounded]);
            assert!((n.value.unwrap() / truth - 1.0).abs() < 0.02, "{n:?}");
            // bounds of what is there beside the cycle, whose own changes are 100e-6 within minutes
            assert!(b.upper.unwrap() < 25e-6 && k.upper.unwrap() < 15e-6, "{b:?} {k:?}");
        }
    }
}

#[test]
fn a_weak_cycle_of_few_periods_is_no_warning_and_no_walk() {
    let added: fn(&Channel, u64) -> f64 = |channel, sample| match &*channel.name {
        "gyro_x" => 20.0 * (std::f64::consts::TAU * 1.5 * sample as f64 / 24_000.0).cos(),
        _ => 0.0,
    };
    for seed in 1..7 {
        let assessment = Simulated { added, seed, ..Simulated::default() }.record().1;
        let [cycle, still] = [6, 7].map(|axis| assessment.channels[axis].noise.as_ref().unwrap());
        for noise in [cycle, still] {
            for term in [Term::BiasInstability, Term::RateRandomWalk] {
                assert_ne!(noise.parameter(term).unwrap().status, Status::Estimated, "{seed} {term:?}");
            }
        }
        assert!(!still.level_changes, "{seed}");
    }
}

#[test]
fn lines_that_are_no_samples_are_counted_and_named() {
    let mut link = StreamCounts::default();
    link.tally.other = 7;
    link.tally.rejected.checksum = 2;
    link.tally.rejected.unchecked = 3;
    link.tally.unchecked_sentences = 4;
    link.unsolicited_errors.count(DeviceError::OutputBufferOverflow);
    link.unsolicited_errors.count(DeviceError::OutputBufferOverflow);
    link.unsolicited_errors.count(DeviceError::from_code(3));
    let counted = Simulated { samples: 100, link, ..Simulated::default() };
    let warnings = counted.record().0.warnings;
    let rejected = findings(&warnings, WarningKind::RejectedLines);
    let expected = [(Rejected::Sentences, 2), (Rejected::NoChecksum, 3), (Rejected::AcceptedUnchecked, 4)];
    assert_eq!(rejected, expected.map(|(what, count)| Finding::Rejected(what, count, 112)));
    let errors = findings(&warnings, WarningKind::LinkErrors);
    let count_of = |wanted: DeviceError| {
        errors.iter().find_map(|found| match found {
            Finding::DeviceError(error, count) if *error == wanted => Some(*count),
            _ => None,
        })
    };
    assert_eq!((count_of(DeviceError::OutputBufferOverflow), count_of(DeviceError::from_code(3))), (Some(2), Some(1)));
    assert_eq!(findings(&warnings, WarningKind::RateAssumed), []);
    let unknown = Simulated { samples: 100, settings: Settings::default(), ..Simulated::default() }.record().0.warnings;
    assert_eq!(findings(&unknown, WarningKind::RateAssumed), [Finding::RateAssumed(40.0)]);
    for kind in [WarningKind::RejectedLines, WarningKind::LinkErrors] {
        assert_eq!(findings(&unknown, kind), [], "{kind:?}");
    }
}

#[test]
fn packets_of_impossible_numbers_are_not_said_to_lack_them() {
    let mut link = StreamCounts::default();
    (link.tally.packets, link.tally.packet_bytes) = (500, 500 * 44);
    link.tally.measured_packets = MeasuredPackets { rejected: 500, ..MeasuredPackets::default() };
    let mut analysis = Analysis::new(Settings::default());
    analysis.absorb(&Batch { link, ..Batch::default() });
    let warnings = analysis.snapshot().warnings;
    let found = findings(&warnings, WarningKind::NoValidLines);
    assert_eq!(found, [Finding::AllRejected(Rejected::PacketNumbers, 500, 500)]);
}

#[test]
fn packets_that_are_not_measured_are_counted_with_the_way_to_measure_them() {
    let excluded = |link: StreamCounts| {
        let warnings = Simulated { samples: 100, link, ..Simulated::default() }.record().0.warnings;
        findings(&warnings, WarningKind::OtherMessages)
    };
    let mut link = StreamCounts::default();
    link.tally.samples = 100;
    assert_eq!(excluded(link), []);
    link.tally.packets = 199;
    assert_eq!(excluded(link), [Finding::OtherPackets(199, None, "VNIMU".into())]);
    link.tally.measured_packets = MeasuredPackets { samples: 150, rejected: 30, repeated: 19 };
    assert_eq!(excluded(link), [], "all of them have been measured");
    link.tally.split_packets = 3;
    assert_eq!(excluded(link), [Finding::SplitPackets(3)]);
}

#[test]
fn a_rotation_is_reported_where_register_26_holds_one() {
    let rotated = |fields: Option<&'static str>| {
        let registers = fields.map(|fields| (26, fields)).into_iter().collect();
        let warnings = Simulated { samples: 100, registers, ..Simulated::default() }.record().0.warnings;
        findings(&warnings, WarningKind::SensorSettings) == [Finding::Rotated]
    };
    for (fields, expected) in [
        (None, false),
        (Some("1,0,0,0,1,0,0,0,1"), false),
        (Some("1,0,0,0,-1,0,0,0,-1"), true),
        (Some("no matrix"), false),
    ] {
        assert_eq!(rotated(fields), expected, "{fields:?}");
    }
}
