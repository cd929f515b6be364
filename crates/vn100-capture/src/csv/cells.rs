//! The fields of one row of numbers, each read for the use of its column.

use memchr::memchr;
use vn100_protocol::stream::RejectedRow;

use super::{ColumnUse, CsvPlan, fields::FieldCutter, number::Number, row_counts::Absence, stamp};

/// The numbers of a row.
pub(super) struct Cells {
    /// In the order of the layout; `None` for a channel that is missing in the row.
    pub(super) numbers: Vec<Option<Number>>,
    /// The missing channels.
    pub(super) absent: Vec<(usize, Absence)>,
    /// The sum of the parts of its stamp.
    stamp_ns: Option<i64>,
    /// The sensor's time.
    pub(super) device_ns: Option<u64>,
    /// Whether the row has a number in a column of another stream.
    pub(super) holds_others: bool,
}

impl Cells {
    pub(super) fn new(channels: usize) -> Self {
        Self { numbers: vec![None; channels], absent: Vec::new(), stamp_ns: None, device_ns: None, holds_others: false }
    }

    /// Reads a row and returns its stamp; a row with another number of fields is rejected.
    #[inline]
    pub(super) fn read(
        &mut self,
        line: &[u8],
        plan: &CsvPlan,
        fields: &mut FieldCutter,
    ) -> Result<Option<i64>, RejectedRow> {
        self.absent.clear();
        (self.stamp_ns, self.holds_others) = (None, false);
        // without quotes the fields are read in place
        let is_quoted = memchr(b'"', line).is_some();
        if is_quoted { self.read_quoted(line, plan, fields) } else { self.read_plain(line, plan) }?;
        Ok(self.stamp_ns)
    }

    #[inline]
    fn read_plain(&mut self, line: &[u8], plan: &CsvPlan) -> Result<(), RejectedRow> {
        let separator = plan.dialect.separator;
        let (mut at, mut place, mut outcome) = (0, 0, Ok(()));
        loop {
            let Some(&column) = plan.columns.get(place) else { return Err(RejectedRow::Fields) };
            let quick = match column {
                ColumnUse::Channel(slot) => Number::parse_prefix(&line[at..])
                    .filter(|(_, length)| line.get(at + length).is_none_or(|byte| *byte == separator))
                    .map(|(number, length)| {
                        self.numbers[slot] = Some(number);
                        at + length
                    }),
                _ => None,
            };
            let end = quick.unwrap_or_else(|| {
                let end = memchr(separator, &line[at..]).map_or(line.len(), |length| at + length);
                outcome = outcome.and(self.cell(column, line[at..end].trim_ascii()));
                end
            });
            place += 1;
            if end == line.len() {
                break;
            }
            at = end + 1;
        }
        if place == plan.columns.len() { outcome } else { Err(RejectedRow::Fields) }
    }

    fn read_quoted(&mut self, line: &[u8], plan: &CsvPlan, fields: &mut FieldCutter) -> Result<(), RejectedRow> {
        let fields = fields.cut(line);
        if fields.len() != plan.columns.len() {
            return Err(RejectedRow::Fields);
        }
        fields.iter().zip(&plan.columns).try_for_each(|(field, &column)| self.cell(column, field))
    }

    /// Reads a field without spaces or quotes around it.
    fn cell(&mut self, column: ColumnUse, field: &[u8]) -> Result<(), RejectedRow> {
        match column {
            ColumnUse::Channel(slot) => {
                self.numbers[slot] = Number::parse(field);
                if self.numbers[slot].is_none() {
                    self.absent.push((slot, absence(field).ok_or(RejectedRow::Number)?));
                }
            }
            ColumnUse::Stamp(form) => self.stamp_ns = Some(added(self.stamp_ns, form.nanoseconds(field))?),
            ColumnUse::DeviceTime => self.device_ns = Some(stamp::device_ns(field).ok_or(RejectedRow::Stamp)?),
            ColumnUse::OtherStream => self.holds_others |= Number::parse(field).is_some(),
            ColumnUse::Ignored | ColumnUse::Sentence => {}
        }
        Ok(())
    }
}

/// The sum of the parts of a stamp so far and the next part.
#[inline]
pub(super) fn added(sum: Option<i64>, part_ns: Option<i64>) -> Result<i64, RejectedRow> {
    part_ns.and_then(|part_ns| sum.unwrap_or_default().checked_add(part_ns)).ok_or(RejectedRow::Stamp)
}

/// The reason why `field` has no number; `None` for a damaged one.
#[cold]
fn absence(field: &[u8]) -> Option<Absence> {
    let word = field.strip_prefix(b"-").or(field.strip_prefix(b"+")).unwrap_or(field);
    let says_none = |text: &[u8]| NO_NUMBERS.iter().any(|none| text.eq_ignore_ascii_case(none.as_bytes()));
    match field {
        b"" => Some(Absence::Empty),
        _ if says_none(field) || says_none(word) => Some(Absence::NotANumber),
        _ => None,
    }
}

/// Texts that scripts write in place of a missing number, in lower case.
const NO_NUMBERS: [&str; 18] = [
    "nan", "inf", "infinity", "null", "none", "na", "n/a", "-", "--", // spreadsheets, pandas, C of Windows
    "#n/a", "#num!", "#value!", "#div/0!", "<na>", "nan(ind)", "1.#ind", "1.#qnan", "1.#inf",
];
