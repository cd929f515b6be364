//! The sidecar of a raw capture: when each read returned, as rows `t_ns,offset` beside the bytes in `NAME.timing`.

use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use crate::capture::OpenError;

/// One read of the port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ReadStamp {
    /// When it returned, in nanoseconds from the recorder's origin.
    pub(crate) at_ns: i64,
    /// Where its first byte stands in the capture.
    pub(crate) offset: u64,
}

/// The stamps beside a capture; `None` where there are none.
pub(crate) fn beside(capture: &Path) -> Result<Option<Vec<ReadStamp>>, OpenError> {
    let mut path = capture.as_os_str().to_owned();
    path.push(".timing");
    let path = PathBuf::from(path);
    match fs::read_to_string(&path) {
        Ok(text) => parse(&text).map(Some).map_err(|line| OpenError::Timing { path, line }),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(source) => Err(OpenError::Io { path, source }),
    }
}

/// The rows of a sidecar, or the number of the first line that is none. Offsets must not go back.
fn parse(text: &str) -> Result<Vec<ReadStamp>, usize> {
    let mut stamps: Vec<ReadStamp> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let stamp = line.split_once(',').and_then(|(at_ns, offset)| {
            Some(ReadStamp { at_ns: at_ns.trim().parse().ok()?, offset: offset.trim().parse().ok()? })
        });
        match stamp {
            Some(stamp) if stamps.last().is_none_or(|last| last.offset <= stamp.offset) => stamps.push(stamp),
            _ => return Err(index + 1),
        }
    }
    Ok(stamps)
}

/// The reads of a stream in order: how many bytes each brought, and its stamp. What lies before the first or behind the last stamp
/// has none of its own.
pub(crate) fn reads(stamps: Vec<ReadStamp>) -> impl Iterator<Item = (u64, Option<i64>)> {
    let first = stamps.first().map_or(0, |stamp| stamp.offset);
    let ends: Vec<_> = stamps.iter().skip(1).map(|stamp| stamp.offset).collect();
    let reads = stamps.into_iter().zip(ends.into_iter().map(Some).chain([None]));
    let stamped = reads.map(|(stamp, end)| (end.map_or(u64::MAX, |end| end - stamp.offset), Some(stamp.at_ns)));
    [(first, None)].into_iter().chain(stamped).filter(|(bytes, _)| *bytes > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_reads() {
        let stamps = parse("# t_ns,offset\n1171022,0\n1381745,20\r\n\n1500000,20\n1600000,64\n").unwrap();
        let reads: Vec<_> = reads(stamps).collect();
        assert_eq!(
            reads,
            [(20, Some(1_171_022)), (44, Some(1_500_000)), (u64::MAX, Some(1_600_000))],
            "a read that brought nothing leaves no trace"
        );
    }

    #[test]
    fn bytes_before_the_first_stamp_have_none() {
        let stamps = parse("5,7\n").unwrap();
        assert_eq!(reads(stamps).collect::<Vec<_>>(), [(7, None), (u64::MAX, Some(5))]);
        assert_eq!(reads(Vec::new()).count(), 0);
    }

    #[test]
    fn the_first_line_that_is_no_row_is_named() {
        for (text, line) in [("1,0\n2;5\n", 2), ("x,0\n", 1), ("1,0\n2,9\n3,8\n", 3), ("1,-4\n", 1)] {
            assert_eq!(parse(text), Err(line), "{text}");
        }
    }
}
