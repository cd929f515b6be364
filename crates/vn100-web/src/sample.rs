//! The sample that the page has built in: an hour of the emulated sensor.

use std::sync::Arc;

use vn100_sim::{Generator, Message, Profile, capture::write_next};

/// Name of the file that the sample is.
pub(crate) const NAME: &str = "sample-hour.vnimu";

const RATE_HZ: u32 = 40;
const SAMPLES: u64 = 3600 * RATE_HZ as u64;

/// The sample as a file in memory, of 16 MB; `None` if this library was built without its message.
pub(crate) fn sample() -> Option<Arc<[u8]>> {
    let message = Message::named("VNIMU")?;
    let mut generator = Generator::for_message(&Profile::lab3(), message, RATE_HZ, 1).ok()?;
    let mut bytes = Vec::new();
    (0..SAMPLES).for_each(|_| write_next(&mut bytes, message, &mut generator));
    Some(bytes.into())
}
