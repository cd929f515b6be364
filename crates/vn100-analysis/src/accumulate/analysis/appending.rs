//! Analyses of pieces: appended to each other, and as bytes.

use imu_timebase::CounterSummary;
use state_bytes::{BadEncoding, ByteReader, Encoded};

use super::Analysis;
use crate::{
    accumulate::{data_record::DataRecord, foreign, piece::NotAppended},
    snapshot::MissingFrom,
};

impl Analysis {
    /// Appends the piece of the record that follows this one. Neighbours may be appended in any
    /// order: the snapshot is the same, bit by bit, as that of one analysis of all samples. Rows of
    /// either piece that are pending are decided first, so that no batch may follow.
    ///
    /// Across pieces it is not known whether later ones repeat the first as a loop does; of the
    /// recent samples those of the later piece are kept. The counts of the link are added.
    ///
    /// # Errors
    /// [`NotAppended`] where the pieces do not belong together, and where the place of a sample
    /// depends on the arrival times of all earlier ones. Then nothing is appended.
    pub fn append(&mut self, mut next: Self) -> Result<(), NotAppended> {
        self.finish();
        next.finish();
        self.append_finished(&next)
    }

    /// Appends a piece where both records are finished.
    pub(crate) fn append_finished(&mut self, next: &Self) -> Result<(), NotAppended> {
        if self.is_timed() || next.is_timed() {
            return Err(NotAppended::ByArrival);
        }
        let counter = self.joined_counter(next)?;
        self.record.append(&next.record)?;
        if let Some(counter) = counter.filter(|counter| counter.step.is_some_and(|step| step > 0.0)) {
            self.record.gaps.use_evidence(if counter.is_device_time {
                MissingFrom::DeviceTime
            } else {
                MissingFrom::Counter
            });
        }
        (self.counter_before, self.pending) = (counter, None);
        self.link.append(&next.link);
        Ok(())
    }

    /// The counter of the rows over both pieces.
    fn joined_counter(&self, next: &Self) -> Result<Option<CounterSummary>, NotAppended> {
        match (self.counter(), next.counter()) {
            (Some(counter), Some(next_counter)) => {
                let (end, start) = (self.record.span.so_far(), next.record.span.start);
                let other_place = NotAppended::OtherPlace { end, next: start };
                let missing = start.index.checked_sub(end.index).ok_or(other_place)?;
                Ok(Some(counter.append(&next_counter, missing + 1)?))
            }
            (None, Some(_)) if self.record.span.has_rows() => Err(NotAppended::CounterInOne),
            (Some(_), None) if next.record.span.has_rows() => Err(NotAppended::CounterInOne),
            (ours, theirs) => Ok(ours.or(theirs)),
        }
    }

    /// Whether rows had arrival times, or the link was lost.
    fn is_timed(&self) -> bool {
        self.last_row_ns.is_some() || self.outages.times > 0
    }
}

/// Only of a record that is [finished](Analysis::finish): no row can be added to an analysis that
/// was read from bytes.
impl Encoded for Analysis {
    fn encode(&self, out: &mut Vec<u8>) {
        self.record.encode(out);
        self.counter().encode(out);
        self.arrivals().encode(out);
        foreign::encode_counts(&self.link, out);
        self.outages.encode(out);
        self.marks.encode(out);
        self.port_shared_with.encode(out);
        self.is_interrupted.encode(out);
        self.last_row_ns.encode(out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        Ok(Self {
            record: DataRecord::decode(input)?,
            pending: None,
            counter_before: Encoded::decode(input)?,
            arrivals_before: Encoded::decode(input)?,
            link: foreign::decode_counts(input)?,
            outages: Encoded::decode(input)?,
            marks: Encoded::decode(input)?,
            port_shared_with: Encoded::decode(input)?,
            is_interrupted: Encoded::decode(input)?,
            finishing: None,
            last_row_ns: Encoded::decode(input)?,
        })
    }
}
