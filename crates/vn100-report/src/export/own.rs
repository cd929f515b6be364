//! How files that an export or an archive wrote are recognised: no captures, although they end like
//! some.

use super::{archive, tables};

/// A bag of ROS 2 in the form of MCAP: magic bytes, then the record of the header, with its length.
const MCAP: &[u8] = b"\x89MCAP0\r\n\x01";
const LENGTH: usize = 8;

/// Whether a file with these first bytes is an export: a table, the rows of an archive,
/// or a bag made of a capture. A kilobyte of it is enough.
#[must_use]
pub fn is_export(beginning: &[u8]) -> bool {
    is_own_bag(beginning) || is_own_table(beginning)
}

fn is_own_bag(beginning: &[u8]) -> bool {
    let texts = beginning.strip_prefix(MCAP).and_then(|header| header.get(LENGTH..));
    let Some((profile, rest)) = texts.and_then(text) else { return false };
    profile == b"ros2" && text(rest).is_some_and(|(library, _)| library.starts_with(b"vn100 "))
}

/// A text behind its length, and what follows it.
fn text(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

fn is_own_table(beginning: &[u8]) -> bool {
    let mut lines = beginning.split(|byte| *byte == b'\n');
    let Some(Ok(header)) = lines.next().map(str::from_utf8) else { return false };
    if header == tables::METADATA {
        return lines.next().is_some_and(|row| row.starts_with(tables::METADATA_ROW.as_bytes()));
    }
    tables::HEADERS.contains(&header) || archive::is_first_line(header)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exports_are_known_by_their_beginning() {
        for header in tables::HEADERS.into_iter().filter(|header| *header != tables::METADATA) {
            assert!(is_export(format!("{header}\nrow").as_bytes()), "{header}");
            assert!(!is_export(format!("{header},more\nrow").as_bytes()), "{header}");
        }
        assert!(is_export(b"name,value\ncapture,a.bin\n") && !is_export(b"name,value\n1,2\n"));
        let bag = |profile: &str, library: &str| {
            let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
            [MCAP, &[0; LENGTH], &text(profile), &text(library)].concat()
        };
        let own = bag("ros2", "vn100 0.2.0");
        assert!(is_export(&own) && !is_export(&own[..own.len() - 1]));
        for other in [bag("vn100", "vn100 0.2.0"), bag("ros2", "rosbag2")] {
            assert!(!is_export(&other));
        }
        for captured in [&b""[..], b"$VNYMR,1,2,3", b"time,gyro_x\n1,2\n"] {
            assert!(!is_export(captured));
        }
    }
}
