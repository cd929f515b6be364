//! The channels that a table or a message may hold.

use std::{borrow::Cow, sync::LazyLock};

use vn100_protocol::{Channel, MESSAGES, Quantity::Value};

/// The channels of all messages of the sensor and that of any series, in the order in which a
/// layout holds them.
static KNOWN: LazyLock<Vec<&Channel>> = LazyLock::new(|| {
    let mut known: Vec<&Channel> = Vec::new();
    for channel in MESSAGES.iter().flat_map(|layout| &*layout.channels) {
        if known.iter().all(|other| other.name != channel.name) {
            known.push(channel);
        }
    }
    known.push(&VALUE);
    known.sort_by_key(|channel| channel.quantity);
    known
});

/// Numbers of a series; the file determines the decimals and limits.
static VALUE: Channel = Channel {
    name: Cow::Borrowed("value"),
    quantity: Value,
    unit: Cow::Borrowed("1"),
    decimals: 0,
    scale: 1.0,
    zero_counts: 0,
    limit_counts: i32::MAX,
    refresh_hz: None,
    increment_step: None,
};

pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    KNOWN.iter().map(|channel| &*channel.name)
}

/// The channel at place `index` of the order that layouts use.
pub(crate) fn known(index: usize) -> &'static Channel {
    KNOWN[index]
}

/// The place of the channel with exactly this name.
pub(super) fn by_name(name: &str) -> Option<usize> {
    names().position(|known| known == name)
}

/// The quantity of a channel, as written in names of streams: `gyro` of `gyro_x`.
pub(crate) fn quantity_word(channel: &str) -> &str {
    channel.split('_').next().unwrap_or(channel)
}

/// The quantities that are named first.
const FIRST: [&str; 3] = ["gyro", "accel", "mag"];

/// The place of a stream of this name among others.
pub(super) fn rank(name: &str) -> usize {
    FIRST.iter().position(|first| name.starts_with(first)).unwrap_or(FIRST.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_of_any_message_keeps_its_order() {
        for layout in MESSAGES {
            let places = layout.channels.iter().map(|channel| by_name(&channel.name));
            assert!(places.clone().all(|place| place.is_some()) && places.is_sorted(), "{}", layout.message);
        }
    }
}
