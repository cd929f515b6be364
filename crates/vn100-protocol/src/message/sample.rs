//! One sample: the numbers of a measuring sentence as exact counts.
//!
//! [`Sample::parse`] reads any sentence of the table, and finds the error in it. The decoder reads
//! the usual lines by a faster way (`template.rs`), which gives the same values.

use alloc::format;

use super::{
    GrammarError, RangeError,
    decimal::Decimal,
    layout::{Channel, Layout, PrintFormat},
    suffix::Suffix,
};
use crate::{framing::sentence::RejectReason, register::RegisterContents};

pub(super) const MAX_CHANNELS: usize = 13;

/// The numbers of one measuring sentence.
///
/// ```text
/// $VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63 CR LF
///        '- yaw   pitch    roll     '- magnetic field x y z    '- acceleration x y z  '- angular rate x y z
///           deg                        gauss                      m/s²                   rad/s
/// ```
///
/// Axes are those of the body: x forward, y right, z down. A large value makes a sentence longer
/// than its usual length, and a [`Suffix`] may stand before the `*`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The message, with the channels of the counts.
    pub layout: &'static Layout,
    /// The print format of the sentence.
    pub print_format: PrintFormat,
    /// The optional fields after the numbers.
    pub suffix: Suffix,
    /// The counts, with zeros after the last channel.
    pub(super) counts: [i32; MAX_CHANNELS],
}

impl Sample {
    /// Reads the contents of a register that holds the numbers of `layout`, such as register 54 for
    /// `$VNIMU`; `layout` is a row of the table.
    ///
    /// # Errors
    /// As for [`parse`](Self::parse).
    pub fn from_contents(contents: &RegisterContents, layout: &'static Layout) -> Result<Self, RejectReason> {
        read_fields(format!(",{}", contents.fields).as_bytes(), layout)
    }

    /// The exact values in the order of the wire, in units of the last decimal of each channel, for
    /// every print format.
    #[inline]
    pub fn counts(&self) -> &[i32] {
        &self.counts[..self.layout.channels.len()]
    }

    /// The values in the units of their channels.
    pub fn values(&self) -> impl ExactSizeIterator<Item = f64> {
        self.layout.channels.iter().zip(self.counts).map(|(channel, count)| channel.value(count))
    }
}

/// Reads fields, each with a comma before it: the numbers of `layout` and a suffix.
pub(super) fn read_fields(fields: &[u8], layout: &'static Layout) -> Result<Sample, RejectReason> {
    let channels = &*layout.channels;
    let field_count = || GrammarError::FieldCount {
        expected: channels.len(),
        found: fields.iter().filter(|&&byte| byte == b',').count(),
    };
    let mut numbers = [Decimal::default(); MAX_CHANNELS];
    let mut rest = fields;
    for (number, channel) in numbers.iter_mut().zip(channels) {
        let [b',', behind @ ..] = rest else {
            return Err(field_count().into());
        };
        let end = behind.iter().position(|&byte| byte == b',').unwrap_or(behind.len());
        *number = Decimal::parse(&behind[..end]).ok_or(GrammarError::Number { channel: &channel.name })?;
        rest = &behind[end..];
    }
    let suffix = match rest {
        [] | [b',', b'T' | b'S', ..] => Suffix::parse(rest).ok_or(GrammarError::Suffix)?,
        _ => return Err(field_count().into()),
    };
    let print_format = print_format(&numbers, channels)?;
    let mut counts = [0; MAX_CHANNELS];
    for ((count, number), channel) in counts.iter_mut().zip(numbers).zip(channels) {
        *count = scaled(number, channel)?;
    }
    Ok(Sample { layout, print_format, suffix, counts })
}

/// The format that matches the decimals of all numbers, determined by the first channel that the
/// formats print differently.
fn print_format(numbers: &[Decimal], channels: &'static [Channel]) -> Result<PrintFormat, GrammarError> {
    let pairs = || numbers.iter().zip(channels);
    let mut old = pairs().map(|(number, channel)| (number.decimals, PrintFormat::Old.decimals(channel), channel));
    let is_old = PrintFormat::Old.covers(channels)
        && old.find(|(_, old, channel)| *old != channel.decimals).is_some_and(|(printed, old, _)| printed == old);
    let format = if is_old { PrintFormat::Old } else { PrintFormat::Current };
    match pairs().find(|(number, channel)| number.decimals != format.decimals(channel)) {
        Some((number, channel)) => Err(GrammarError::Decimals {
            channel: &channel.name,
            expected: format.decimals(channel),
            found: number.decimals,
        }),
        None => Ok(format),
    }
}

/// The count in the decimals of `channel`, which are not fewer than the printed ones.
fn scaled(number: Decimal, channel: &'static Channel) -> Result<i32, RangeError> {
    let missing = u32::from(channel.decimals - number.decimals);
    let count = i64::from(number.count) * 10_i64.pow(missing);
    i32::try_from(count)
        .ok()
        .filter(|count| count.unsigned_abs() <= channel.limit_counts.unsigned_abs())
        .ok_or(RangeError { channel, count })
}
