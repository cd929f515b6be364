//! What the sensor reported of its registers within the stream; of register 54 the measurements in
//! it.

use std::{collections::BTreeMap, sync::Arc};

use imu_noise::{Histogram, Moments};
use vn100_protocol::{Channel, Layout, Quantity, Register, RegisterContents, Sample, VNIMU};

use crate::{
    rate_change::RateChange,
    snapshot::ChannelSnapshot,
    warning::{Finding, Warning},
};

#[derive(Debug, Clone, Default)]
pub(crate) struct SensorReplies {
    pub(super) registers: BTreeMap<u8, String>,
    /// The registers, and the number of samples, when the link was last lost.
    before_break: Option<(BTreeMap<u8, String>, u64)>,
    /// The first two different serial numbers, and the number of samples before the second.
    two_serials: Option<(String, String, u64)>,
    /// Of each channel of register 54, whose readings are too few for a deviation.
    imu: Vec<(Moments, Histogram)>,
}

impl SensorReplies {
    /// Takes a reply. Replies among excluded samples, which may be of another sensor, are not kept.
    pub(crate) fn push(&mut self, contents: &RegisterContents, samples: u64, is_excluded: bool) {
        let (register, fields) = (contents.register, contents.fields.to_string());
        if register == Register::IMU
            && let Ok(sample) = Sample::from_contents(contents, &VNIMU)
        {
            self.push_measurement(&sample);
        }
        if register == Register::SERIAL_NUMBER {
            self.compare_serial(&fields, samples);
        }
        if !is_excluded {
            self.registers.insert(register.0, fields);
        }
    }

    fn compare_serial(&mut self, serial: &str, samples: u64) {
        if let Some(before) = self.registers.get(&Register::SERIAL_NUMBER.0).filter(|before| *before != serial) {
            self.two_serials.get_or_insert_with(|| (before.clone(), serial.into(), samples));
        }
    }

    fn push_measurement(&mut self, sample: &Sample) {
        self.imu.resize(VNIMU.channels.len(), (Moments::new(), Histogram::new()));
        for ((moments, histogram), &count) in self.imu.iter_mut().zip(sample.counts()) {
            moments.push(&[count]);
            histogram.push(&[count]);
        }
    }

    /// The link was lost after this many samples: the next reply may be that of another sensor.
    pub(crate) fn mark_break(&mut self, samples: u64) {
        self.before_break = Some((self.registers.clone(), samples));
    }

    /// Excludes the replies since the last break after this many samples as well.
    pub(crate) fn exclude(&mut self, samples: u64) {
        if let Some((registers, _)) = self.before_break.as_ref().filter(|(_, before)| *before == samples) {
            self.registers.clone_from(registers);
        }
    }

    /// The output rate in hertz by register 7; `None` where it is not known, or 0.
    pub(crate) fn rate_hz(&self) -> Option<f64> {
        let fields = self.registers.get(&Register::ASYNC_RATE.0)?;
        let rate_hz: u32 = fields.split(',').next()?.parse().ok()?;
        (rate_hz > 0).then_some(rate_hz.into())
    }

    /// `layout` with what register 82 says of increments: whether they lack the bias of the filter.
    pub(crate) fn layout_of(&self, layout: &Arc<Layout>) -> Arc<Layout> {
        let is_integral =
            |channel: &Channel| channel.increment_step.is_some() && channel.quantity == Quantity::AngularRate;
        let fields = self.registers.get(&Register::DELTA_SETTINGS.0);
        let gyro_compensation = fields.and_then(|fields| fields.split(',').nth(1)).map(str::trim);
        match gyro_compensation {
            Some(mode) if layout.compensated.is_none() && layout.channels.iter().any(is_integral) => {
                Arc::new(Layout { compensated: Some(mode != "0"), ..Layout::clone(layout) })
            }
            _ => Arc::clone(layout),
        }
    }

    /// A warning where two sensors replied; samples after the `change` are excluded.
    pub(crate) fn two_sensors(&self, change: Option<RateChange>) -> Option<Warning> {
        let (before, then, samples) = self.two_serials.as_ref()?;
        let is_excluded = change.is_some_and(|change| change.after_samples == *samples);
        let found = Finding::TwoSensors([before.clone(), then.clone()], is_excluded);
        Some(Warning::new(found))
    }

    /// The channels of register 54; none before its first reply.
    pub(crate) fn imu_channels(&self) -> Vec<(Channel, ChannelSnapshot)> {
        let results = |(moments, histogram): &(Moments, Histogram)| ChannelSnapshot {
            moments: moments.clone(),
            histogram: histogram.clone(),
            octaves: Vec::new(),
            points: Vec::new(),
            signal: None,
            branch_counts: 0,
            stride: 1,
            printed_step_counts: 1.0,
        };
        VNIMU.channels.iter().zip(&self.imu).map(|(channel, sums)| (renamed(channel), results(sums))).collect()
    }
}

/// Gives a channel of register 54 a name that none of the stream has.
fn renamed(channel: &Channel) -> Channel {
    let prefix = match channel.quantity {
        Quantity::Temperature | Quantity::Pressure => "polled",
        _ => "uncompensated",
    };
    Channel { name: format!("{prefix}_{}", channel.name).into(), ..channel.clone() }
}

#[cfg(test)]
mod tests {
    use vn100_protocol::VNDTV;

    use super::*;

    fn push(replies: &mut SensorReplies, register: u8, fields: &str, samples: u64, is_excluded: bool) {
        let fields = vn100_protocol::RegisterFields::new(fields).unwrap();
        replies.push(&RegisterContents { register: Register(register), fields }, samples, is_excluded);
    }

    #[test]
    fn register_7_holds_the_rate() {
        let rate = |fields: &str| {
            let mut replies = SensorReplies::default();
            push(&mut replies, 7, fields, 0, false);
            push(&mut replies, 6, "25", 0, false);
            replies.rate_hz()
        };
        assert_eq!((rate("40"), rate("100,1"), rate("1")), (Some(40.0), Some(100.0), Some(1.0)));
        assert_eq!((rate("0"), rate("?"), rate("")), (None, None, None));
        assert_eq!(SensorReplies::default().rate_hz(), None);
    }

    #[test]
    fn register_82_says_whether_integrals_are_compensated() {
        let compensated = |fields: Option<&str>, layout: &Layout| {
            let mut replies = SensorReplies::default();
            fields.into_iter().for_each(|fields| push(&mut replies, 82, fields, 0, false));
            replies.layout_of(&Arc::new(layout.clone())).compensated
        };
        for (fields, expected) in
            [(None, None), (Some("0,0,0,0,0"), Some(false)), (Some("0,1,0,0,0"), Some(true)), (Some("0"), None)]
        {
            assert_eq!(compensated(fields, &VNDTV), expected, "{fields:?}");
        }
        let said = Layout { compensated: Some(true), ..VNDTV.clone() };
        assert_eq!(compensated(Some("0,0,0,0,0"), &said), Some(true), "the user knows better");
        assert_eq!(compensated(Some("0,1,0,0,0"), &VNIMU), Some(false));
    }

    #[test]
    fn replies_since_a_break_belong_to_the_samples_behind_it() {
        for (samples, expected) in [(9, "40"), (10, "20")] {
            let mut replies = SensorReplies::default();
            replies.exclude(9);
            push(&mut replies, 7, "40", 9, false);
            replies.mark_break(9);
            push(&mut replies, 7, "20", 9, false);
            replies.exclude(samples);
            assert_eq!(replies.registers[&7], expected, "{samples}");
        }
    }

    #[test]
    fn measurements_of_register_54_are_channels_of_their_own() {
        let mut replies = SensorReplies::default();
        assert!(replies.imu_channels().is_empty());
        let first =
            "-02.0841,+00.6045,+02.8911,+00.381,-00.154,-09.657,-00.005683,+00.000262,+00.001475,+21.6,+00099.761";
        push(&mut replies, 27, first, 0, false);
        push(&mut replies, 54, "damaged", 0, false);
        assert!(replies.imu_channels().is_empty());
        push(&mut replies, 54, first, 0, true);
        push(&mut replies, 54, &first.replace("+21.6", "+21.8"), 0, false);
        push(&mut replies, 54, "damaged", 0, false);
        push(&mut replies, 27, first, 0, false);
        let channels = replies.imu_channels();
        assert_eq!(channels.len(), 11);
        assert_eq!(channels[6].0.name, "uncompensated_gyro_x");
        assert_eq!(channels[6].1.moments.mean_counts(), Some(-5683.0));
        assert_eq!(channels[9].0.name, "polled_temperature");
        assert_eq!(channels[9].1.moments.mean_counts(), Some(217.0));
        assert_eq!(channels[9].1.moments.count(), 2);
    }
}
