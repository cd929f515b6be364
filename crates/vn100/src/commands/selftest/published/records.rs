//! The public records with published tables that are known, and how their files are written.

use imu_noise::Deviation;

/// A public record, and what others published of it.
pub(super) struct PublishedRecord {
    pub(super) title: &'static str,
    pub(super) owner: &'static str,
    pub(super) licence: &'static str,
    /// Where it can be had.
    pub(super) origin: &'static str,
    /// The file of the record, in each of the forms in which it may be there.
    pub(super) files: &'static [PublishedFile],
    pub(super) rate_hz: f64,
    /// What its columns are, in the words of the command line.
    pub(super) columns: &'static str,
    pub(super) tables: &'static [PublishedTable],
}

#[derive(PartialEq)]
pub(super) struct PublishedFile {
    pub(super) name: &'static str,
    pub(super) bytes: u64,
    pub(super) sha256: &'static str,
}

pub(super) struct PublishedTable {
    pub(super) title: &'static str,
    pub(super) file: PublishedFile,
    pub(super) deviation: Deviation,
    /// The largest relative difference of a deviation that counts as agreement.
    pub(super) tolerance: f64,
    /// The rows of the content; `None` if one cannot be read.
    pub(super) rows: fn(&str) -> Option<Vec<PublishedRow>>,
}

/// A published deviation, in the unit of the channel.
pub(super) struct PublishedRow {
    pub(super) channel: String,
    /// The averaging factor.
    pub(super) m: u64,
    pub(super) deviation: f64,
}

const ALLANTOOLS: &str = "the source of allantools: https://github.com/aewallin/allantools, folder tests";

/// Half of the last of five digits, of which the smallest is 1.0000.
const FIVE_DIGITS: f64 = 5e-5;

pub(super) const RECORDS: &[PublishedRecord] = &[
    PublishedRecord {
        title: "ADIS16405 at rest, first of six recordings of 1 000 000 samples",
        owner: "SMAC group",
        licence: "CC BY-NC-SA 4.0",
        origin: "the R package imudata, https://github.com/SMAC-Group/imudata, written as a table with the columns \
            gx gy gz in deg/s and ax ay az in g; the tables are adis_av of the R package avar and adis_wv of wv, in one file",
        files: &[
            PublishedFile {
                name: "adis16405_1.csv",
                bytes: 38_462_403,
                sha256: "81b96af7172cd57e9863bd7a926aa26c52d5fb6d986614f6297482d0434c32c4",
            },
            PublishedFile {
                name: "adis16405_1.csv.xz",
                bytes: 4_007_808,
                sha256: "1972c6117d878e0e2aaa227ad63e60a6b9123e9caa6a5342299d8352152d8368",
            },
        ],
        rate_hz: 100.0,
        columns: "gyro_x=gx:deg/s,gyro_y=gy:deg/s,gyro_z=gz:deg/s,accel_x=ax:g,accel_y=ay:g,accel_z=az:g",
        tables: &[
            PublishedTable {
                title: "avar: Allan variance of all windows",
                file: ADIS_TABLE,
                deviation: Deviation::Allan,
                // the package leaves out one of the windows
                tolerance: 5e-6,
                rows: |content| variances(content, 3, 1.0),
            },
            PublishedTable {
                title: "wv: wavelet variance (MODWT, Haar), which is half of the Allan variance",
                file: ADIS_TABLE,
                deviation: Deviation::Allan,
                tolerance: 1e-10,
                rows: |content| variances(content, 4, 2.0),
            },
        ],
    },
    PublishedRecord {
        title: "Frequency of an oven oscillator, 19 982 values",
        owner: "A. Wallin",
        licence: "LGPL-3.0, as test data of allantools",
        origin: ALLANTOOLS,
        files: &[PublishedFile {
            name: "ocxo/ocxo_frequency.txt",
            bytes: 499_712,
            sha256: "2c507ce0fee6a2010116c6cfe78724d8f87b527f55cdbfe901afbdc9b214d3ac",
        }],
        rate_hz: 1.0,
        columns: "value=1:Hz",
        tables: &[
            PublishedTable {
                title: "Stable32: overlapping Allan deviation, all averaging times",
                file: PublishedFile {
                    name: "ocxo/stable32_oadev_alltau.txt",
                    bytes: 21_077,
                    sha256: "c88ffb4a9361115f05f1fe1310fe624555d901c12eb878df49785416ba4cbc1a",
                },
                deviation: Deviation::Allan,
                tolerance: FIVE_DIGITS,
                rows: |content| stable32(content, 1e7),
            },
            PublishedTable {
                title: "Stable32: overlapping Hadamard deviation, all averaging times",
                file: PublishedFile {
                    name: "ocxo/stable32_ohdev_alltau.txt",
                    bytes: 21_081,
                    sha256: "28ffd9e069caf461104e49e16e622a50fb5fe2471f24038e27f9b8754d55f760",
                },
                deviation: Deviation::Hadamard,
                tolerance: FIVE_DIGITS,
                rows: |content| stable32(content, 1e7),
            },
        ],
    },
    PublishedRecord {
        title: "Fractional frequency with flicker noise, simulated, 10 000 values",
        owner: "A. Wallin",
        licence: "LGPL-3.0, as test data of allantools",
        origin: ALLANTOOLS,
        files: &[PublishedFile {
            name: "pink_frequency/pink_frequency.txt",
            bytes: 122_276,
            sha256: "b6b88ba58d3d6508ec8a7fd834e02568ce74a8462daec76a84b3346db6d3802a",
        }],
        rate_hz: 1.0,
        columns: "value=1:1",
        tables: &[
            PublishedTable {
                title: "Stable32: overlapping Allan deviation, all averaging times",
                file: PublishedFile {
                    name: "pink_frequency/oadev.txt",
                    bytes: 15_396,
                    sha256: "9215381d60834577ee1cbe786f5b384f6280019d1a2a82b0a4c5c94119b165e9",
                },
                deviation: Deviation::Allan,
                tolerance: FIVE_DIGITS,
                rows: |content| stable32(content, 1.0),
            },
            PublishedTable {
                title: "Stable32: overlapping Hadamard deviation, all averaging times",
                file: PublishedFile {
                    name: "pink_frequency/ohdev.txt",
                    bytes: 15_312,
                    sha256: "d1838634c5bbf4b1f665ca1819bb606a945b84a24eb1fa332b8d4a60b0d8005f",
                },
                deviation: Deviation::Hadamard,
                tolerance: FIVE_DIGITS,
                rows: |content| stable32(content, 1.0),
            },
        ],
    },
];

const ADIS_TABLE: PublishedFile = PublishedFile {
    name: "adis16405_1_published.csv",
    bytes: 7_003,
    sha256: "9bbf6deac1be4da4447614911f151aff7fb0b2e439936d56c61223457c0c9a1a",
};

/// The rows `channel,m,tau,...` with a variance in this column, in (deg/s)^2 or g^2, of which the
/// Allan variance is `factor` times as large.
fn variances(content: &str, column: usize, factor: f64) -> Option<Vec<PublishedRow>> {
    const STANDARD_GRAVITY_M_S2: f64 = 9.80665;
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let variance: f64 = cells.get(column)?.parse().ok()?;
        let unit = if cells[0].starts_with("gyro") { 1_f64.to_radians() } else { STANDARD_GRAVITY_M_S2 };
        let deviation = (factor * variance).sqrt() * unit;
        Some(PublishedRow { channel: cells[0].to_owned(), m: cells.get(1)?.parse().ok()?, deviation })
    };
    let lines = content.lines().filter(|line| !line.starts_with('#')).skip(1);
    // a package has no value at some averaging times
    lines.filter(|line| line.split(',').nth(column).is_some_and(|cell| !cell.is_empty())).map(row).collect()
}

/// The rows of Stable32: averaging factor, averaging time, number of terms, exponent, and sigma
/// between its bounds; the numbers of the record are `factor` times as large.
fn stable32(content: &str, factor: f64) -> Option<Vec<PublishedRow>> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split_whitespace().collect();
        let deviation = factor * cells.get(5)?.parse::<f64>().ok()?;
        Some(PublishedRow { channel: "value".into(), m: cells.first()?.parse().ok()?, deviation })
    };
    content.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(row).collect()
}
