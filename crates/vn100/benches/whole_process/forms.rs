//! One record in every form that a capture has, made once and kept with the build.

use std::{
    fmt::Write as _,
    fs::{self, File},
    io::{BufWriter, Write},
    path::PathBuf,
    process::Command,
};

use flate2::{Compression, write::GzEncoder};

/// Of a line of the emulated sensor to the next.
const PERIOD_NS: u64 = 25_000_000;

/// Writes the bags of a table of numbers, if this Python has the package rosbags.
const BAGS: &str = "
import pathlib, sys
sys.path.insert(0, sys.argv[1])
from against_rosbags import *
folder = pathlib.Path(sys.argv[2])
rows = numpy.loadtxt(folder / 'floats.csv', delimiter=',', skiprows=1)[:, 1:]
write_ros1(folder / 'plain.bag', rows, None)
write_ros1(folder / 'lz4.bag', rows, 'LZ4')
write_ros2(folder / 'db3', rows, StoragePlugin.SQLITE3)
write_ros2(folder / 'mcap', rows, StoragePlugin.MCAP)
write_ros2(folder / 'mcap-zstd', rows, StoragePlugin.MCAP, CompressionMode.STORAGE)
write_ros2(folder / 'db3-messages', rows, StoragePlugin.SQLITE3, CompressionMode.MESSAGE)
";

/// A folder with a record of the emulated sensor at 40 Hz in every form.
pub(crate) struct Record {
    folder: PathBuf,
    /// Samples, which are the lines of the text and the rows of the tables.
    pub(crate) samples: u64,
}

impl Record {
    /// The record of this many minutes, written if it is not there.
    pub(crate) fn of(program: &str, minutes: u64) -> Self {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{minutes}-minutes"));
        let record = Self { folder, samples: minutes * 60 * 40 };
        if !record.folder.exists() {
            let unfinished = Self { folder: record.folder.with_extension("unfinished"), ..record };
            let _ = fs::remove_dir_all(&unfinished.folder);
            fs::create_dir_all(&unfinished.folder).unwrap();
            unfinished.write(program, minutes);
            fs::rename(unfinished.folder, &record.folder).unwrap();
        }
        record
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.folder.join(name).to_str().unwrap().to_owned()
    }

    fn create(&self, name: &str) -> BufWriter<File> {
        BufWriter::new(File::create(self.path(name)).unwrap())
    }

    fn write(&self, program: &str, minutes: u64) {
        let duration = format!("{minutes}min");
        let captures: [(&str, &[&str]); 4] = [
            ("text.vnymr", &[]),
            ("text.vnimu", &["--message", "VNIMU"]),
            ("packets.bin", &["--message", "BINARY"]),
            ("recording.mcap", &[]),
        ];
        for (name, message) in captures {
            let path = self.path(name);
            let arguments = ["sim", "--like", "lab3", "--duration", &duration, "--seed", "1", "-o", &path];
            assert!(Command::new(program).args(arguments).args(message).status().unwrap().success(), "{name}");
        }
        fs::create_dir(self.path("archive")).unwrap();
        for seed in 1..=minutes / 10 {
            let (seed, path) = (seed.to_string(), self.path(&format!("archive/{seed:03}.vnymr")));
            let arguments = ["sim", "--like", "lab3", "--duration", "10min", "--seed", &seed, "-o", &path];
            assert!(Command::new(program).args(arguments).status().unwrap().success());
        }
        let text = fs::read_to_string(self.path("text.vnymr")).unwrap();
        self.write_tables(&text);
        self.write_damage(text.into_bytes());
        let tests = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests");
        let bags = Command::new("python3").args(["-c", BAGS, tests]).arg(&self.folder).output();
        if !bags.is_ok_and(|output| output.status.success()) {
            println!("no bags: python3 lacks rosbags and allantools");
        }
    }

    /// The text with times beside it, compressed and as tables; each with and without lost lines.
    fn write_tables(&self, text: &str) {
        let mut gzip = GzEncoder::new(self.create("text.gz"), Compression::default());
        gzip.write_all(text.as_bytes()).unwrap();
        gzip.finish().unwrap().flush().unwrap();
        for (suffix, lost_of) in [("", u64::MAX), ("-lost-100", 100), ("-lost-20", 20)] {
            let name = |stem: &str, extension: &str| format!("{stem}{suffix}{extension}");
            let (mut raw, mut times) = (self.create(&name("raw", ".bin")), self.create(&name("raw", ".bin.timing")));
            let (mut fields, mut floats) = (self.create(&name("fields", ".csv")), self.create(&name("floats", ".csv")));
            fields.write_all(b"t,yaw,pitch,roll,mag_x,mag_y,mag_z,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n").unwrap();
            floats.write_all(b"time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z\n").unwrap();
            let (mut offset, mut row, mut chance) = (0, String::new(), Chance(1));
            for (index, line) in (0..).zip(text.split_inclusive('\n')) {
                if chance.next() % lost_of == 0 {
                    continue;
                }
                let at_ns: u64 = index * PERIOD_NS;
                writeln!(times, "{at_ns},{offset}").unwrap();
                raw.write_all(line.as_bytes()).unwrap();
                offset += line.len();
                let values = line.strip_prefix("$VNYMR,").unwrap().split('*').next().unwrap();
                row.clear();
                write!(row, "{}.{:09}", at_ns / 1_000_000_000, at_ns % 1_000_000_000).unwrap();
                writeln!(fields, "{row},{values}").unwrap();
                let numbers: Vec<f64> = values.split(',').map(|value| value.parse().unwrap()).collect();
                for value in numbers[9..].iter().chain(&numbers[6..9]) {
                    // the digits of a value that a filter or a change of units made
                    write!(row, ",{}", value + chance.next() as f64 * 1e-18).unwrap();
                }
                writeln!(floats, "{row}").unwrap();
            }
            for mut file in [raw, times, fields, floats] {
                file.flush().unwrap();
            }
        }
    }

    /// The text with a digit changed in a line of so many, and bytes that are no capture.
    fn write_damage(&self, mut bytes: Vec<u8>) {
        for damaged_of in [1000, 100, 20] {
            let (mut damaged, mut chance) = (bytes.clone(), Chance(2));
            for at in (0..bytes.len()).filter(|&at| bytes[at] == b'$') {
                if chance.next() % damaged_of == 0 {
                    damaged[at + "$VNYMR,+0".len()] ^= 1;
                }
            }
            fs::write(self.path(&format!("damaged-{damaged_of}.vnymr")), damaged).unwrap();
        }
        let mut chance = Chance(1);
        bytes.iter_mut().for_each(|byte| *byte = chance.next() as u8);
        fs::write(self.path("random"), &bytes).unwrap();
        bytes.fill(b'7');
        bytes[0] = b'$';
        fs::write(self.path("endless"), &bytes).unwrap();
    }
}

/// Knuth's linear congruential generator (MMIX), its upper bits.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 24
    }
}
