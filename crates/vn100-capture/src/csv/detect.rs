//! Finds the line that names the columns of a CSV file, and how the file is to be read then.

use super::{
    BYTE_ORDER_MARK, CsvError, column_map::ColumnMap, fields::is_comment_or_blank, header_candidate::HeaderCandidate,
    plan::Plan,
};

/// Comments above the first row that are looked at for the names of the columns: the nearest to it.
const COMMENTS_ABOVE: usize = 100;

/// Decides how to read the CSV file that begins with `head`; `None` when it is none, or none that
/// holds anything of a VN-100.
///
/// Whole lines for 1000 rows are wanted in `head` ([`HEAD_BYTES`](super::HEAD_BYTES) of it); with
/// fewer the decimals are judged by those.
///
/// Without `map` the columns are known by their names, and the numbers are in the sensor's units.
///
/// # Errors
/// [`CsvError`] when this is a CSV file but lacks the columns, or the stamps.
pub(crate) fn detect(head: &[u8], map: Option<&ColumnMap>) -> Result<Option<Plan>, CsvError> {
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let line_end = if head.contains(&b'\r') && !head.contains(&b'\n') { b'\r' } else { b'\n' };
    let lines: Vec<&[u8]> =
        head.split(|&byte| byte == line_end).map(|line| line.strip_suffix(b"\r").unwrap_or(line)).collect();
    // a zero byte in the names of the columns is no damage: binary data, or UTF-16
    let first = lines.iter().position(|line| !is_comment_or_blank(line)).filter(|&first| !lines[first].contains(&0));
    let Some(first) = first else {
        return Ok(None);
    };
    let mut problem = None;
    // scripts that save arrays put a # before the names of the columns
    for index in first.saturating_sub(COMMENTS_ABOVE)..first {
        let Some(names) = lines[index].trim_ascii_start().strip_prefix(b"#") else {
            continue;
        };
        let candidate = HeaderCandidate::new(names, &lines, line_end, index);
        if !candidate.fits(lines[first]) {
            continue;
        }
        match candidate.plan(map) {
            Ok(Some(plan)) => return Ok(Some(plan)),
            Err(error) if error.is_about_stamps() => problem = Some(error),
            // a comment in words
            Ok(None) | Err(_) => {}
        }
    }
    let plan = HeaderCandidate::new(lines[first], &lines, line_end, first).plan(map)?;
    match problem {
        Some(problem) if plan.is_none() => Err(problem),
        _ => Ok(plan),
    }
}
