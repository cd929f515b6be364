//! Polled measurements: register 54, read between the samples.

use imu_noise::{Histogram, Moments};
use vn100_protocol::stream::RegisterReply as Reply;
use vn100_protocol::{Channel, Quantity, Register, RegisterContents, RegisterFields, Sample, VNIMU};

use crate::snapshot::{ChannelSnapshot, RegisterChannel};

/// Too few replies, and too unevenly spaced, for a deviation.
#[derive(Debug, Clone)]
pub(crate) struct ImuRegister {
    channels: Vec<(Moments, Histogram)>,
}

impl Default for ImuRegister {
    fn default() -> Self {
        Self { channels: vec![(Moments::new(), Histogram::new()); VNIMU.channels.len()] }
    }
}

impl ImuRegister {
    pub(crate) fn push(&mut self, reply: &Reply) {
        let Some(sample) = measurement(reply) else {
            return;
        };
        for ((moments, histogram), &count) in self.channels.iter_mut().zip(sample.counts()) {
            moments.push(&[count]);
            histogram.push(&[count]);
        }
    }

    pub(crate) fn snapshot(&self) -> Vec<RegisterChannel> {
        (VNIMU.channels.iter().zip(&self.channels))
            .filter(|(_, (moments, _))| moments.count() > 0)
            .map(|(channel, (moments, histogram))| RegisterChannel {
                channel: renamed(channel),
                results: ChannelSnapshot {
                    moments: moments.clone(),
                    histogram: histogram.clone(),
                    octaves: Vec::new(),
                    noise_types: Vec::new(),
                    slope_counts: None,
                    signal: None,
                    branch_counts: 0,
                    printed_decimals: channel.decimals,
                },
            })
            .collect()
    }
}

fn measurement(reply: &Reply) -> Option<Sample> {
    let register = Register(reply.register);
    let fields = RegisterFields::new(reply.fields.as_str()).ok().filter(|_| register == Register::IMU)?;
    Sample::from_contents(&RegisterContents { register, fields }, &VNIMU).ok()
}

/// A name of its own, because the stream may have a channel of the plain name.
fn renamed(channel: &Channel) -> Channel {
    let prefix = match channel.quantity {
        Quantity::Temperature | Quantity::Pressure => "polled",
        _ => "uncompensated",
    };
    Channel { name: format!("{prefix}_{}", channel.name).into(), ..channel.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_become_channels_of_their_own() {
        let mut imu = ImuRegister::default();
        assert!(imu.snapshot().is_empty());
        let reply = |register, fields: &str| Reply { before_row: 0, register, fields: fields.into() };
        let first =
            "-02.0841,+00.6045,+02.8911,+00.381,-00.154,-09.657,-00.005683,+00.000262,+00.001475,+21.6,+00099.761";
        imu.push(&reply(54, first));
        imu.push(&reply(54, &first.replace("+21.6", "+21.8")));
        imu.push(&reply(54, "damaged"));
        imu.push(&reply(27, first));
        let channels = imu.snapshot();
        assert_eq!(channels.len(), 11);
        assert_eq!(channels[6].channel.name, "uncompensated_gyro_x");
        assert_eq!(channels[6].results.moments.mean_counts(), Some(-5683.0));
        assert_eq!(channels[9].channel.name, "polled_temperature");
        assert_eq!(channels[9].results.moments.mean_counts(), Some(217.0));
        assert_eq!(channels[9].results.moments.count(), 2);
    }
}
