//! Logs of terminal programs: a stamp before each sentence, as in
//! `[2024-02-06 18:14:11.000] $VNYMR,...` and `18:14:11.000 -> $VNYMR,...`.

use memchr::memmem;

use super::{
    ColumnUse, CsvError, CsvPlan, Kind, Said,
    date::DateForm,
    dialect::Dialect,
    number::Number,
    stamp::{StampForm, StampScan},
};

/// Sentences with a stamp that are examined for its form.
const EXAMINED: usize = 200;

/// With fewer lines, any text may stand before a sentence.
const FEWEST: usize = 3;

/// The stamp and the sentence of a line; `None` without a sentence.
pub(super) fn stamp_and_sentence(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let (stamp, sentence) = line.split_at(memmem::find(line, b"$VN")?);
    let is_edge = |byte: &u8| !byte.is_ascii_alphanumeric();
    let begin = stamp.iter().position(|byte| !is_edge(byte)).unwrap_or(stamp.len());
    let end = stamp.iter().rposition(|byte| !is_edge(byte)).map_or(begin, |last| last + 1);
    Some((&stamp[begin..end], sentence.trim_ascii_end()))
}

/// The plan of such a log; `None` if the lines have no stamps of one form. The user may have named
/// the form of column 1.
pub(super) fn stamped_sentences(lines: &[&[u8]], line_end: u8, said: Said<'_>) -> Result<Option<CsvPlan>, CsvError> {
    let stamps = lines.iter().filter_map(|line| stamp_and_sentence(line)).map(|(stamp, _)| stamp);
    let stamps: Vec<&[u8]> = stamps.take(EXAMINED).collect();
    if stamps.len() < FEWEST || said.map.is_some_and(|map| map.sentence.is_some()) {
        return Ok(None);
    }
    let named = said.map.and_then(|map| map.stamp.first()).map(|&(_, form)| form);
    let fits = |form: &StampForm| stamps.iter().all(|stamp| form.nanoseconds(stamp).is_some());
    let dates = DateForm::ALL.map(StampForm::Date).into_iter().filter(fits);
    let form = match (named, &dates.collect::<Vec<_>>()[..]) {
        (Some(form), _) => Some(form).filter(fits),
        (None, [StampForm::Date(DateForm::DayFirst), StampForm::Date(DateForm::MonthFirst)]) => {
            return Err(CsvError::DateOrder { column: "1".into(), argument: "1".into() });
        }
        (None, [form, ..]) => Some(*form),
        (None, []) => of_numbers(&stamps),
    };
    let Some(form) = form else { return Ok(None) };
    Ok(Some(CsvPlan {
        kind: Kind::Sentences,
        names: Vec::new(),
        ignored_columns: Vec::new(),
        left_out: Vec::new(),
        line_end,
        dialect: Dialect::stamped_sentences(),
        columns: vec![ColumnUse::Stamp(form), ColumnUse::Sentence],
        quantizers: Vec::new(),
        last_field: None,
        times: Some(format!("1:{}", form.name())),
        date: if let StampForm::Date(form) = form { Some(form) } else { None },
        lines_above: 0,
    }))
}

/// The form of numbers that ascend, if their unit is certain.
fn of_numbers(stamps: &[&[u8]]) -> Option<StampForm> {
    let numbers: Vec<Number> = stamps.iter().map(|stamp| Number::parse(stamp)).collect::<Option<_>>()?;
    let mut scan = StampScan::default();
    numbers.iter().for_each(|number| scan.add(number));
    let ascends = numbers.windows(2).all(|pair| pair[1].value() >= pair[0].value());
    let form = StampForm::Unit(scan.unit().ok()?);
    (ascends && numbers.iter().any(|number| number.decimals() > 0)).then_some(form)
}
