//! One record in every form that a capture has, made once and kept with the build.

use std::{
    fmt::Write as _,
    fs::{self, File},
    io::{BufWriter, Write},
    path::Path,
    process::Command,
};

use flate2::{Compression, write::GzEncoder};

/// Lines of the record: five hours at 40 Hz.
pub(crate) const LINES: u64 = 720_000;

/// Of a line of the emulated sensor to the next.
const PERIOD_NS: u64 = 25_000_000;

/// The files of the record.
pub(crate) struct Record {
    /// Sentences, a line each.
    pub(crate) text: String,
    /// The same bytes, with the time of each line beside them.
    pub(crate) raw: String,
    /// As `record` keeps it, each line a read of its own.
    pub(crate) recording: String,
    /// A stamp and the fields of a sentence in each row.
    pub(crate) csv: String,
    /// The text, compressed.
    pub(crate) gzip: String,
    /// The text with a digit of every thousandth line changed.
    pub(crate) damaged: String,
    /// As many bytes of any kind.
    pub(crate) random: String,
    /// As many bytes that begin a line.
    pub(crate) endless: String,
}

/// The record, with what of it is not there yet.
pub(crate) fn record(program: &str) -> Record {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let path = |extension: &str| folder.join(format!("five-hours.{extension}")).to_str().unwrap().to_owned();
    let record = Record {
        text: path("vnymr"),
        raw: path("bin"),
        recording: path("mcap"),
        csv: path("csv"),
        gzip: path("vnymr.gz"),
        damaged: path("damaged"),
        random: path("random"),
        endless: path("endless"),
    };
    for output in [&record.text, &record.recording].into_iter().filter(|output| !Path::new(output).exists()) {
        let arguments = ["sim", "--like", "lab3", "--duration", "5h", "--seed", "1", "-o", output];
        assert!(Command::new(program).args(arguments).status().unwrap().success());
    }
    let others = [&record.raw, &record.csv, &record.gzip, &record.damaged, &record.random, &record.endless];
    let lacks = others.into_iter().any(|output| !Path::new(output).exists());
    if lacks {
        write_other_forms(&record);
    }
    record
}

fn write_other_forms(record: &Record) {
    let text = fs::read_to_string(&record.text).unwrap();
    fs::write(&record.raw, &text).unwrap();
    let create = |path: &str| BufWriter::new(File::create(path).unwrap());
    let (mut times, mut csv) = (create(&format!("{}.timing", record.raw)), create(&record.csv));
    csv.write_all(b"t,yaw,pitch,roll,mag_x,mag_y,mag_z,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n").unwrap();
    let (mut at_ns, mut offset, mut row) = (0, 0, String::new());
    for line in text.split_inclusive('\n') {
        writeln!(times, "{at_ns},{offset}").unwrap();
        let fields = line.strip_prefix("$VNYMR,").unwrap().split('*').next().unwrap();
        row.clear();
        writeln!(row, "{}.{:09},{fields}", at_ns / 1_000_000_000, at_ns % 1_000_000_000).unwrap();
        csv.write_all(row.as_bytes()).unwrap();
        at_ns += PERIOD_NS;
        offset += line.len();
    }
    let mut gzip = GzEncoder::new(create(&record.gzip), Compression::default());
    gzip.write_all(text.as_bytes()).unwrap();
    gzip.finish().unwrap().flush().unwrap();
    times.flush().unwrap();
    csv.flush().unwrap();
    let mut bytes = text.into_bytes();
    let length = bytes.len();
    let mut starts = (0..length).filter(|&at| bytes[at] == b'$').step_by(1000).collect::<Vec<_>>();
    starts.iter_mut().for_each(|start| *start += "$VNYMR,+0".len());
    starts.into_iter().for_each(|digit| bytes[digit] ^= 1);
    fs::write(&record.damaged, &bytes).unwrap();
    let mut state = 1_u64;
    bytes.iter_mut().for_each(|byte| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *byte = (state >> 56) as u8;
    });
    fs::write(&record.random, &bytes).unwrap();
    bytes.fill(b'7');
    bytes[0] = b'$';
    fs::write(&record.endless, &bytes).unwrap();
}
