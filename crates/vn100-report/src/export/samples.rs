//! Samples as CSV: a header with the channels and their units, and a row for each sample.

use std::io::{self, Write};

use vn100_analysis::protocol::{Channel, stream::Batch};

/// Writes samples as rows of CSV.
///
/// The first column is the arrival time in nanoseconds, where the source has it: since 1970 where
/// the times of the source are dates. Next is the device time, where samples carry it. Values are
/// in the units of documents, with the decimals that the sensor sends; a value that a row lacks is
/// empty.
#[derive(Debug)]
pub struct SampleTable<W> {
    out: W,
    columns: Option<TimeColumns>,
    /// Rows without a stamp of their own came with the row before.
    arrival_ns: Option<i64>,
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
        Self { out, columns: None, arrival_ns: None }
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
            let mut cells = Vec::with_capacity(counts.len() + 2);
            cells.extend(columns.arrival.then(|| self.arrival_ns.map_or_else(String::new, |ns| ns.to_string())));
            let device_ns = || batch.device_ns.get(row).map_or_else(String::new, u64::to_string);
            cells.extend(columns.device.then(device_ns));
            for (place, (channel, count)) in layout.channels.iter().zip(counts).enumerate() {
                cells.push(if batch.is_absent(row, place) { String::new() } else { value(channel, *count) });
            }
            writeln!(self.out, "{}", cells.join(","))?;
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

/// A value in the unit of its channel: as the sensor printed it, or else exactly.
fn value(channel: &Channel, count: i32) -> String {
    if channel.scale == 1.0 {
        let count = i64::from(count) + channel.zero_counts;
        let digits = usize::from(channel.decimals);
        let sign = if count < 0 { "-" } else { "" };
        let text = format!("{:0>width$}", count.unsigned_abs(), width = digits + 1);
        let (whole, part) = text.split_at(text.len() - digits);
        return if digits == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}.{part}") };
    }
    channel.value(count).to_string()
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
