//! The form in bytes of types of the protocol: layouts, and the counts of a stream.

use state_bytes::{BadEncoding, ByteReader, Encoded, check};
use vn100_protocol::stream::{MessageName, RejectedRow, RejectedRowCounts, StreamCounts};
use vn100_protocol::{Channel, DeviceError, Layout, MeasuredPackets, PacketHeader, Quantity, RejectedCounts, Tally};

const QUANTITIES: [Quantity; 8] = [
    Quantity::Angle,
    Quantity::Quaternion,
    Quantity::MagneticField,
    Quantity::Acceleration,
    Quantity::AngularRate,
    Quantity::Temperature,
    Quantity::Pressure,
    Quantity::Value,
];

pub(crate) fn encode_layout(layout: &Layout, out: &mut Vec<u8>) {
    layout.message.to_string().encode(out);
    layout.compensated.encode(out);
    layout.channels.len().encode(out);
    for channel in layout.channels.iter() {
        channel.name.to_string().encode(out);
        QUANTITIES.iter().position(|quantity| *quantity == channel.quantity).unwrap_or_default().encode(out);
        channel.unit.to_string().encode(out);
        channel.decimals.encode(out);
        channel.scale.encode(out);
        channel.limit_counts.encode(out);
        channel.refresh_hz.encode(out);
        channel.increment_step.encode(out);
    }
}

pub(crate) fn decode_layout(input: &mut ByteReader<'_>) -> Result<Layout, BadEncoding> {
    let (message, compensated) = (String::decode(input)?, Encoded::decode(input)?);
    let length = usize::decode(input)?;
    let mut channels = Vec::new();
    for _ in 0..length {
        let channel = Channel {
            name: String::decode(input)?.into(),
            quantity: *QUANTITIES.get(usize::decode(input)?).ok_or(BadEncoding::Contradictory)?,
            unit: String::decode(input)?.into(),
            decimals: Encoded::decode(input)?,
            scale: Encoded::decode(input)?,
            limit_counts: Encoded::decode(input)?,
            refresh_hz: Encoded::decode(input)?,
            increment_step: Encoded::decode(input)?,
        };
        check(channel.decimals <= 22 && channel.scale > 0.0)?;
        channels.push(channel);
    }
    check(!channels.is_empty())?;
    Ok(Layout { message: message.into(), compensated, channels: channels.into() })
}

/// The plain numbers of the counts, in the order of their bytes.
fn numbers(counts: &mut StreamCounts) -> [&mut u64; 27] {
    let StreamCounts {
        tally,
        foreign_samples,
        baud_scan_bytes,
        overrun_bytes,
        echoes,
        outputs_resumed,
        connects,
        unsolicited_errors: _,
        other_message: _,
        other_packet: _,
        rejected_rows: _,
    } = counts;
    let Tally {
        valid_sentence_bytes,
        rejected_sentence_bytes,
        packet_bytes,
        skipped_bytes,
        buffered_bytes,
        samples,
        replies,
        other,
        unchecked_sentences,
        packets,
        measured_packets: MeasuredPackets { samples: measured, rejected: rejected_packets, repeated },
        split_packets,
        damaged_packets,
        rejected: RejectedCounts { checksum, unchecked, grammar, range, truncated, too_long },
    } = tally;
    #[rustfmt::skip]
    let numbers = [
        valid_sentence_bytes, rejected_sentence_bytes, packet_bytes, skipped_bytes, buffered_bytes,
        samples, replies, other, unchecked_sentences, packets, split_packets,
        measured, rejected_packets, repeated, damaged_packets,
        checksum, unchecked, grammar, range, truncated, too_long,
        foreign_samples, baud_scan_bytes, overrun_bytes, echoes, outputs_resumed, connects,
    ];
    numbers
}

pub(crate) fn encode_counts(counts: &StreamCounts, out: &mut Vec<u8>) {
    numbers(&mut { *counts }).iter().for_each(|number| number.encode(out));
    let errors: Vec<(u8, u64)> = counts.unsolicited_errors.iter().map(|(error, times)| (error.code(), times)).collect();
    errors.encode(out);
    counts.other_message.map(|name| name.to_string()).encode(out);
    counts.other_packet.map(|header| header.parts()).encode(out);
    let rows = |rows: RejectedRowCounts| {
        RejectedRow::ALL.map(|reason| rows.iter().find(|(other, _)| *other == reason).map_or(0, |(_, count)| count))
    };
    counts.rejected_rows.map(rows).encode(out);
}

pub(crate) fn decode_counts(input: &mut ByteReader<'_>) -> Result<StreamCounts, BadEncoding> {
    let mut counts = StreamCounts::default();
    for number in numbers(&mut counts) {
        *number = Encoded::decode(input)?;
    }
    check(counts.foreign_samples <= counts.tally.samples && counts.echoes <= counts.tally.replies)?;
    let errors = Vec::<(u8, u64)>::decode(input)?;
    check(errors.is_sorted_by(|one, other| one.0 != other.0) && errors.len() <= 14)?;
    errors.into_iter().for_each(|(code, times)| counts.unsolicited_errors.add(DeviceError::from_code(code), times));
    counts.other_message = Option::<String>::decode(input)?.map(|name| MessageName::new(name.as_bytes()));
    counts.other_packet =
        Option::<(u8, Vec<u16>)>::decode(input)?.map(|(groups, words)| PacketHeader::new(groups, &words));
    counts.rejected_rows = Option::<[u64; RejectedRow::ALL.len()]>::decode(input)?.map(|rows| {
        let mut counts = RejectedRowCounts::default();
        RejectedRow::ALL.into_iter().zip(rows).for_each(|(reason, times)| counts.add(reason, times));
        counts
    });
    Ok(counts)
}
