//! Captures packed by other programs: Python's `bz2`, `lzma` and `zipfile` wrote these, of forty rows.

use std::{fs, io::Write};

use vn100_capture::{Capture, CaptureOptions, OpenError};
use vn100_protocol::stream::{Batch, ReadOptions};

use super::formats::{open, read};

const BZIP2: &[u8] =
    b"\x42\x5a\x68\x39\x31\x41\x59\x26\x53\x59\x43\x41\xfa\xb5\x00\x01\xa5\x5b\x80\x70\x10\x00\x05\x7f\xe0\x00\x00\
    \xaa\x84\x94\x60\x30\x01\x1a\x85\x86\x91\x3d\x42\x7f\xea\x9e\xa9\x31\x06\x27\xa4\x29\xa3\x40\x1a\x00\x00\x49\
    \xaa\x8d\xaa\x27\xa7\xe5\x28\x7a\x80\x0e\xc0\x43\xf7\xc8\x08\x6d\x8a\xaa\xaa\xaa\xaa\xaa\xaa\xa2\xaa\xd2\x94\
    \xcb\x0b\x3d\x32\xf3\xae\xdb\xd8\x00\x00\x00\x00\x00\x00\x00\x77\x70\x94\x06\xe0\x41\x92\x43\xba\xaa\xaa\xaa\
    \x8a\x97\x77\xe9\xea\x04\x19\x20\x50\x10\xdf\x9e\xfc\xf3\xcd\xdd\xf1\x02\x1d\x04\x85\x01\x0e\xaa\xaf\xae\xc8\
    \xb1\x45\x2a\xaa\xb5\x48\xa6\xd9\x99\x9e\x33\x2e\xfc\x5a\x29\x9a\xd6\x6a\x91\x62\x8a\x55\x55\x50\x71\xba\xaa\
    \xaa\xaa\xaa\xd5\x6d\x4b\x99\x9d\xf3\x33\x8b\x0b\xda\xef\x41\xad\x6b\x52\xab\x56\xdb\x6d\xda\xc9\xd5\xb9\x4a\
    \x21\x4c\xcc\xea\x92\x85\x8a\x5d\x7e\xc3\x8e\x55\x7a\xbf\x7c\x5d\x7b\xe2\xee\x48\xa7\x0a\x12\x08\x68\x3f\x56\
    \xa0";
const XZ: &[u8] =
    b"\xfd\x37\x7a\x58\x5a\x00\x00\x04\xe6\xd6\xb4\x46\x02\x00\x21\x01\x16\x00\x00\x00\x74\x2f\xe5\xa3\xe0\x03\x30\
    \x00\x97\x5d\x00\x3a\x0b\x08\xe7\xd3\xfb\x09\x6c\x74\xae\xbb\x0e\x74\x32\x08\x1e\xc0\x62\x8b\xf4\x98\x52\x2c\
    \xce\x72\x4f\x67\x9e\x3f\x02\x8a\x82\x63\x7d\xa4\x5d\xc5\xad\x43\x06\xe0\xd9\xe3\x79\xe2\x4f\xad\xe3\x5c\xd6\
    \x19\x29\xc4\x03\x11\xce\x8a\xd2\x0d\x35\x7b\x9a\xf0\x1b\xbe\xf9\xc0\xcc\xad\x32\x64\x5a\x18\x81\xf5\x45\x90\
    \xc1\x66\xfd\xb3\x73\x07\xca\xe2\x17\x9f\xcc\xe7\x53\x02\x62\x40\x7a\x1f\xc6\x61\x33\x45\xf8\x75\xae\x08\x29\
    \x9b\xb4\x24\xaf\x8c\xa5\x03\x20\xb7\x6c\x65\x75\x29\x4e\x4e\x30\xd1\x3b\x05\xe8\x71\x9c\x1d\xea\x31\x08\x36\
    \x5d\x23\x7a\x36\x3a\x4b\xdc\x8a\xde\xc5\xff\x8d\x4a\xa1\x71\xf2\x1d\x17\x36\x1d\x00\x00\xd8\x21\xee\x99\x6e\
    \x34\x4a\x7e\x00\x01\xb3\x01\xb1\x06\x00\x00\xfb\xc9\x28\xc3\xb1\xc4\x67\xfb\x02\x00\x00\x00\x00\x04\x59\x5a";
const ZIP: &[u8] =
    b"\x50\x4b\x03\x04\x14\x00\x00\x00\x08\x00\x00\x00\x21\x50\xa1\x31\xf6\x31\xb9\x00\x00\x00\x31\x03\x00\x00\x0b\
    \x00\x00\x00\x72\x75\x6e\x2f\x69\x6d\x75\x2e\x63\x73\x76\x45\xcf\xcd\x0a\xc2\x30\x10\x45\xe1\xbd\xcf\x12\x4a\
    \x32\x93\xc9\xcf\xd3\x14\x29\xe2\x46\x10\xc4\x45\x7d\x7b\xa9\xd8\x73\x37\x21\x5c\x86\x0f\xce\x3b\xdd\x3f\xaf\
    \xe7\xba\xa7\xeb\xb6\xdd\x1e\xeb\x7e\xc9\x4b\xce\x39\xfd\xde\xe3\x33\x97\x51\x8e\xcd\xe2\xdc\x0a\x5b\x70\x67\
    \x6c\x9d\x3b\x3f\xb7\x22\xaf\xb2\xc9\x0b\x36\x79\x8d\x4d\x5e\x3f\x37\x93\x37\xd8\xe4\x4d\x36\xbc\x42\x87\xe1\
    \x15\x3a\x1c\xaf\xd0\xe1\x78\x85\x0e\x97\x47\x87\xcb\xa3\xa3\xca\xa3\xa3\xca\xa3\xa3\xca\xa3\xa3\xca\xa3\x23\
    \xf0\x8c\x8e\xc0\x33\x3a\x02\xcf\xe8\x08\x3c\xa3\xa3\xc9\xa3\xa3\xc9\xa3\xa3\xc9\xa3\xa3\xc9\xa3\xa3\xcb\xa3\
    \xa3\xcb\xa3\xa3\xe3\x39\x1d\x1d\xcf\xe9\x18\x78\x4e\xc7\xc0\x73\x3a\x86\x3c\x3a\x86\x3c\x3a\xa6\x3c\x3a\xa6\
    \x3c\x3a\xa6\x3c\x3a\xa6\xbc\x7f\xc7\x17\x50\x4b\x01\x02\x14\x03\x14\x00\x00\x00\x08\x00\x00\x00\x21\x50\xa1\
    \x31\xf6\x31\xb9\x00\x00\x00\x31\x03\x00\x00\x0b\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x80\x01\x00\x00\
    \x00\x00\x72\x75\x6e\x2f\x69\x6d\x75\x2e\x63\x73\x76\x50\x4b\x05\x06\x00\x00\x00\x00\x01\x00\x01\x00\x39\x00\
    \x00\x00\xe2\x00\x00\x00\x00\x00";

fn row_count(capture: Capture) -> (usize, bool) {
    let (batches, end) = read(capture, ReadOptions::default());
    (batches.iter().map(Batch::row_count).sum(), end.error.is_none())
}

/// The rows of a file with these bytes.
fn of_file(bytes: &[u8]) -> Result<(usize, bool), OpenError> {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    Capture::open(file.path(), &CaptureOptions::default()).map(row_count)
}

#[test]
fn compressed_files_of_other_programs_are_read_from_a_file_and_from_a_stream() {
    for packed in [BZIP2, XZ] {
        assert_eq!(row_count(open(packed).unwrap()), (40, true));
        assert_eq!(of_file(packed).unwrap(), (40, true));
        assert_eq!(row_count(open([packed, packed].concat()).unwrap()).0, 80, "one behind the other");
        assert!(!row_count(open(&packed[..packed.len() - 9]).unwrap()).1, "cut");
    }
    assert_eq!(of_file(ZIP).unwrap(), (40, true));
    let refused = open(ZIP).err().unwrap().to_string();
    assert!(refused.contains("a ZIP archive on standard input"), "{refused}");
}

/// An archive of these files, not packed.
fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, bytes) in files {
        writer.start_file(*name, stored).unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

#[test]
fn the_only_capture_of_an_archive_is_read_and_several_are_listed() {
    let csv = "t,gyro_x\n".to_owned()
        + &(0..20).map(|row| format!("{:.3},0.5\n", 0.025 * f64::from(row))).collect::<String>();
    let csv = csv.as_bytes();
    let problem = |bytes: &[u8]| match of_file(bytes).err().unwrap() {
        OpenError::Unusable { problem, .. } => problem.to_string(),
        other => panic!("{other}"),
    };
    for files in [
        &[("a", csv)][..],
        &[("imu.CSV", csv), ("photo.png", b"png")],
        &[("run.vnmar", csv), ("photo.png", b"png")],
        &[("a.csv", csv), ("__MACOSX/a.csv", b"")],
    ] {
        assert_eq!(of_file(&archive(files)).unwrap(), (20, true));
    }
    // compressed once more
    assert_eq!(of_file(&archive(&[("a.csv.bz2", BZIP2)])).unwrap(), (40, true));
    // of two tables, the only one of a sensor is read
    let gps = "t,lat,lon\n".to_owned() + &(0..60).map(|row| format!("{row}.0,48.1,11.{row}\n")).collect::<String>();
    assert_eq!(of_file(&archive(&[("gps.csv", gps.as_bytes()), ("imu.csv", csv)])).unwrap(), (20, true));
    let several = problem(&archive(&[("a.csv", csv), ("b.csv", csv)]));
    assert_eq!(several, "a ZIP archive of several files: unpack the one that is meant (a.csv, b.csv)");
    assert!(problem(&archive(&[("a.md", csv), ("b", csv)])).contains("several files"));
    assert_eq!(problem(&archive(&[("__MACOSX/a.csv", b"")])), "a ZIP archive without a file");
    let whole = archive(&[("a.csv", csv)]);
    assert!(problem(&whole[..whole.len() - 30]).contains("archive that is damaged"));
    // a digit changed on the disk
    let mut damaged = whole.clone();
    let at = damaged.iter().position(|&byte| byte == b'5').unwrap();
    damaged[at] = b'6';
    assert_eq!(of_file(&damaged).unwrap(), (20, false));
}

#[test]
fn text_in_utf_16_is_read_in_either_order() {
    let text = "\u{feff}t;gyro_x;T [°C]\r\n".to_owned() + "0.000;0.5;20\r\n0.025;0.25;20\r\n";
    for unit in [u16::to_le_bytes, u16::to_be_bytes] {
        let bytes: Vec<u8> = text.encode_utf16().flat_map(unit).collect();
        assert_eq!(row_count(open(&bytes).unwrap()), (2, true));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.csv");
        fs::write(&path, &bytes).unwrap();
        assert_eq!(row_count(Capture::open(&path, &CaptureOptions::default()).unwrap()), (2, true));
    }
}

#[test]
fn documents_of_other_programs_are_named() {
    let npy = b"\x93NUMPY\x01\0";
    for (files, named) in [
        (&[("x.npy", &npy[..])][..], "NumPy arrays"),
        (&[("x.npy", npy), ("y.npy", npy)], "NumPy arrays"),
        (&[("[Content_Types].xml", b"<Types/>"), ("xl/workbook.xml", b"<x/>")], "Microsoft Office"),
        (&[("mimetype", b"application/vnd.oasis.opendocument.spreadsheet"), ("content.xml", b"<x/>")], "LibreOffice"),
    ] {
        let bytes = archive(files);
        for refused in [of_file(&bytes).err().unwrap(), open(bytes).err().unwrap()] {
            assert!(refused.to_string().contains(named), "{refused}");
        }
    }
    let both =
        archive(&[("x.npy", npy), ("a.csv.bz2", BZIP2), ("a.csv", b"t,gyro_x\n0.000,0.5\n0.025,0.5\n0.050,0.25\n")]);
    assert_eq!(of_file(&both).unwrap(), (3, true));
}
