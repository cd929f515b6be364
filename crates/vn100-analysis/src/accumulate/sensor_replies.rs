//! What the sensor reported of its registers within the stream.

use std::collections::BTreeMap;

use vn100_protocol::{Register, stream::RegisterReply};

use super::imu_register::ImuRegister;
use crate::{
    snapshot::{PolledChannel, RateChange},
    warning::{Warning, WarningKind},
};

/// The last value of each register, the measurements of register 54, and whether two sensors
/// replied.
#[derive(Debug, Clone)]
pub(crate) struct SensorReplies {
    registers: BTreeMap<u8, String>,
    /// The registers, and how many samples there were, when the link was lost last.
    before_break: Option<(BTreeMap<u8, String>, u64)>,
    /// The first two serial numbers that differ, in their order, and the samples before the second.
    two_serials: Option<(String, String, u64)>,
    imu: ImuRegister,
}

impl SensorReplies {
    pub(crate) fn new() -> Self {
        Self { registers: BTreeMap::new(), before_break: None, two_serials: None, imu: ImuRegister::new() }
    }

    /// Takes a reply after so many samples. The registers of samples that are left out, perhaps of
    /// another sensor, are not kept.
    pub(crate) fn push(&mut self, reply: &RegisterReply, samples: u64, is_left_out: bool) {
        self.imu.push(reply);
        if let Some(before) = self.registers.get(&reply.register)
            && reply.register == Register::SERIAL_NUMBER.0
            && *before != reply.fields
        {
            self.two_serials.get_or_insert_with(|| (before.clone(), reply.fields.clone(), samples));
        }
        if !is_left_out {
            self.registers.insert(reply.register, reply.fields.clone());
        }
    }

    /// The link is lost after so many samples: perhaps another sensor replies next.
    pub(crate) fn mark_break(&mut self, samples: u64) {
        self.before_break = Some((self.registers.clone(), samples));
    }

    /// The samples that follow are left out: so are the replies since a break behind as many samples.
    pub(crate) fn leave_out(&mut self, samples: u64) {
        if let Some((registers, _)) = self.before_break.as_ref().filter(|(_, before)| *before == samples) {
            self.registers.clone_from(registers);
        }
    }

    /// The output rate in hertz by register 7; `None` for 0, which is no rate.
    pub(crate) fn rate_hz(&self) -> Option<f64> {
        const ASYNC_RATE: u8 = 7;
        let fields = self.registers.get(&ASYNC_RATE)?;
        let rate_hz: u32 = fields.split(',').next()?.parse().ok()?;
        (rate_hz > 0).then_some(rate_hz.into())
    }

    pub(crate) const fn registers(&self) -> &BTreeMap<u8, String> {
        &self.registers
    }

    pub(crate) fn polled(&self) -> Vec<PolledChannel> {
        self.imu.snapshot()
    }

    /// The warning that two sensors replied; `change` is the one after which samples are left out.
    pub(crate) fn two_sensors(&self, change: Option<RateChange>) -> Option<Warning> {
        let (before, then, samples) = self.two_serials.as_ref()?;
        let text = if change.is_some_and(|change| change.after_samples == *samples) {
            format!(
                "the sensor with the serial number {before} answered at first and {then} behind it, whose samples are left out: the result \
                 is that of the first"
            )
        } else {
            format!(
                "the sensor with the serial number {before} answered at first and {then} behind it: the result mixes two sensors. Measure \
                 each of them alone"
            )
        };
        Some(Warning { kind: WarningKind::AnotherSensor, channels: Vec::new(), text })
    }
}
