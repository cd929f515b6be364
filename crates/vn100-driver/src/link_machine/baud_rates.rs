//! The baud rates of the sensor.

/// The baud rates of a VN-100 in bit/s, all of [`BaudRate::ALL`](vn100_protocol::BaudRate::ALL), in
/// the order in which the scan tries them: the factory default, the faster ones, the slower ones.
pub const BAUD_RATES: [u32; 9] = [115_200, 921_600, 460_800, 230_400, 57_600, 38_400, 19_200, 9600, 128_000];
