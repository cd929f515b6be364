//! How files that an export or an archive wrote are recognised: no captures, although they end like
//! some.

use super::{archive, tables};

/// Whether a file with these first bytes is an export: a table, or the rows of an archive. A kilobyte
/// of it is enough.
pub fn is_export(beginning: &[u8]) -> bool {
    let mut lines = beginning.split(|byte| *byte == b'\n');
    let Some(Ok(header)) = lines.next().map(str::from_utf8) else { return false };
    if header == tables::METADATA {
        return lines.next().is_some_and(|row| row.starts_with(tables::METADATA_ROW.as_bytes()));
    }
    tables::is_header(header) || archive::is_first_line(header)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exports_are_known_by_their_beginning() {
        let header = "channel,unit,frequency_hz,psd_one_sided";
        assert!(is_export(format!("{header}\nrow").as_bytes()) && !is_export(format!("{header},more\nrow").as_bytes()));
        assert!(is_export(b"name,value\ncapture,a.bin\n") && !is_export(b"name,value\n1,2\n"));
        for captured in [&b""[..], b"$VNYMR,1,2,3", b"time,gyro_x\n1,2\n"] {
            assert!(!is_export(captured));
        }
    }
}
