//! Samples as CSV: a header with the channels and their units, and a row for each sample.

use std::{
    io::{self, Write},
    iter,
};

use vn100_analysis::protocol::{Channel, stream::Batch};

/// Writes samples as rows of CSV.
///
/// The first column is the arrival time in nanoseconds, where the source has it: since 1970 where the
/// times are dates. Next is the device time, where samples carry it. Values are in the units of
/// documents, with the decimals that the sensor sends; a value that a row lacks is empty.
#[derive(Debug)]
pub struct SampleTable<W> {
    out: W,
    columns: Option<TimeColumns>,
    /// Rows without a stamp of their own came with the row before.
    arrival_ns: Option<i64>,
    line: Vec<u8>,
}

/// Which times there are, by the first batch with samples.
#[derive(Debug, Clone, Copy)]
struct TimeColumns {
    arrival: bool,
    device: bool,
}

impl<W: Write> SampleTable<W> {
    /// A table without rows; the header is written with the first row.
    pub const fn new(out: W) -> Self {
        Self { out, columns: None, arrival_ns: None, line: Vec::new() }
    }

    /// Writes the samples of the next batch.
    ///
    /// # Errors
    /// The error of the writer.
    pub fn push(&mut self, batch: &Batch) -> io::Result<()> {
        let Some(layout) = batch.layout.as_ref().filter(|_| batch.row_count() > 0) else { return Ok(()) };
        let columns = match self.columns {
            Some(columns) => columns,
            None => self.begin(&layout.channels, batch)?,
        };
        let mut arrivals = batch.arrivals.iter().peekable();
        for (row, counts) in batch.rows().enumerate() {
            if let Some(arrival) = arrivals.next_if(|arrival| arrival.from_row == row) {
                self.arrival_ns = Some(arrival.at_ns);
            }
            let line = &mut self.line;
            line.clear();
            if columns.arrival {
                self.arrival_ns.into_iter().for_each(|ns| push_integer(line, ns));
                line.push(b',');
            }
            if columns.device {
                batch.device_ns.get(row).into_iter().for_each(|ns| push_integer(line, *ns));
                line.push(b',');
            }
            for (place, (channel, count)) in layout.channels.iter().zip(counts).enumerate() {
                if !batch.is_absent(row, place) {
                    push_value(line, channel, *count)?;
                }
                line.push(b',');
            }
            line.pop();
            line.push(b'\n');
            self.out.write_all(line)?;
        }
        Ok(())
    }

    fn begin(&mut self, channels: &[Channel], batch: &Batch) -> io::Result<TimeColumns> {
        let columns = TimeColumns { arrival: !batch.arrivals.is_empty(), device: !batch.device_ns.is_empty() };
        self.columns = Some(columns);
        let mut names = Vec::new();
        names.extend(columns.arrival.then(|| "time [ns]".to_owned()));
        names.extend(columns.device.then(|| "device time [ns]".to_owned()));
        names.extend(channels.iter().map(|Channel { name, unit, .. }| match &**unit {
            "1" | "" => name.to_string(),
            unit => format!("{name} [{unit}]"),
        }));
        writeln!(self.out, "{}", names.join(","))?;
        Ok(columns)
    }

    /// Flushes the writer, so that the system has all that was written.
    ///
    /// # Errors
    /// The error of the writer.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

fn push_integer(line: &mut Vec<u8>, integer: impl itoa::Integer) {
    line.extend_from_slice(itoa::Buffer::new().format(integer).as_bytes());
}

/// A value in the unit of its channel: as the sensor printed it, or else exactly.
fn push_value(line: &mut Vec<u8>, channel: &Channel, count: i32) -> io::Result<()> {
    if channel.scale != 1.0 {
        return write!(line, "{}", channel.value(count));
    }
    let count = i64::from(count) + channel.zero_counts;
    if count < 0 {
        line.push(b'-');
    }
    let mut digits = itoa::Buffer::new();
    let digits = digits.format(count.unsigned_abs()).as_bytes();
    let decimals = usize::from(channel.decimals);
    // a digit before the point, however small the value is
    let zeros = (decimals + 1).saturating_sub(digits.len());
    let whole = digits.len() + zeros - decimals;
    let padded = iter::repeat_n(b'0', zeros).chain(digits.iter().copied());
    line.extend(padded.clone().take(whole));
    if decimals > 0 {
        line.push(b'.');
        line.extend(padded.skip(whole));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_analysis::protocol::{VNIMU, stream::Arrival};

    use super::*;

    fn text(batches: &[Batch]) -> String {
        let mut table = SampleTable::new(Vec::new());
        batches.iter().for_each(|batch| table.push(batch).unwrap());
        String::from_utf8(table.out).unwrap()
    }

    fn batch(rows: usize) -> Batch {
        let layout = Arc::new(VNIMU.clone());
        let counts = (0..layout.channels.len() * rows).map(|place| if place % 2 == 0 { -5 } else { 12_345 }).collect();
        Batch { layout: Some(layout), counts, ..Batch::default() }
    }

    #[test]
    fn values_are_as_the_sensor_sends_them_and_times_of_the_reads() {
        let mut timed = batch(3);
        timed.arrivals = vec![Arrival { from_row: 0, at_ns: 7 }, Arrival { from_row: 2, at_ns: 9 }];
        timed.device_ns = vec![25, 50, 75];
        let text = text(&[Batch::default(), timed]);
        let mut lines = text.lines();
        let header = lines.next().unwrap();
        assert!(header.starts_with("time [ns],device time [ns],mag_x [gauss],"), "{header}");
        assert!(header.ends_with("gyro_z [rad/s],temperature [degC],pressure [kPa]"), "{header}");
        let starts = ["7,25,-0.0005,1.2345,", "7,50,1.2345,-0.0005,", "9,75,-0.0005,1.2345,"];
        for (line, start) in lines.zip(starts) {
            assert!(line.starts_with(start) && line.split(',').count() == 13, "{line}");
        }
    }

    #[test]
    fn without_times_there_is_no_column_of_them_and_without_samples_nothing() {
        assert_eq!(text(&[]), "");
        assert_eq!(text(&[batch(0)]), "");
        let one = text(&[batch(1)]);
        assert!(one.starts_with("mag_x [gauss],") && one.lines().count() == 2, "{one}");
    }
}
