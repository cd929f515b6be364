//! Every register with settings: its fields, their allowed values, and their factory defaults.

/// The firmware version of an emulated sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Firmware {
    /// 2.1.0.0
    V2_1,
    /// 3.1.0.0
    #[default]
    V3_1,
}

impl Firmware {
    pub(crate) const fn version(self) -> &'static str {
        match self {
            Self::V2_1 => "2.1.0.0",
            Self::V3_1 => "3.1.0.0",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Field {
    /// Printable text without `$ , *`, at most this long.
    Text(usize),
    Whole(u32, u32),
    OneOf(&'static [u32]),
    /// A finite number, at most this large, printed as short as its value allows.
    Real(f32),
    /// A finite number, printed like an angular rate.
    Rate,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct RegisterRow {
    pub(crate) number: u16,
    pub(crate) read_only: bool,
    pub(crate) fields: &'static [Field],
    pub(crate) default: &'static str,
}

use Field::{OneOf, Rate, Real, Text, Whole};

const RESERVED: Field = Whole(0, 0);
const FLAG: Field = Whole(0, 1);
const UP_TO_2: Field = Whole(0, 2);
const UP_TO_3: Field = Whole(0, 3);
const UP_TO_4: Field = Whole(0, 4);
const U16: Field = Whole(0, 65_535);
const U32: Field = Whole(0, u32::MAX);
/// The maker states no longest window; this length suffices for a reading at 0.8 Hz.
const WINDOW: Field = Whole(0, 1000);
const ANY: Field = Real(f32::MAX);
const CALIBRATION: &[Field] = &[ANY; 12];
const NO_CALIBRATION: &str = "1,0,0,0,1,0,0,0,1,0,0,0";

const fn writable(number: u16, fields: &'static [Field], default: &'static str) -> RegisterRow {
    RegisterRow { number, read_only: false, fields, default }
}

const fn read_only(number: u16, fields: &'static [Field], default: &'static str) -> RegisterRow {
    RegisterRow { number, read_only: true, fields, default }
}

/// All registers with settings, except those that are kept per port (5, 6, 7), contain masks (75 to
/// 77), or are counted (33).
///
/// Ranges that the maker does not state are as wide as the named values of the field. Register 83
/// has no agreed defaults: all are zero except the distance for a new computation.
pub(crate) const ROWS: &[RegisterRow] = &[
    writable(0, &[Text(20)], ""),
    read_only(1, &[Text(24)], "VN-100S-CR"),
    read_only(2, &[U32], "7"),
    writable(21, &[ANY; 6], "1,0,1.8,0,0,-9.793746"),
    writable(23, CALIBRATION, NO_CALIBRATION),
    writable(25, CALIBRATION, NO_CALIBRATION),
    writable(26, &[Real(1.0); 9], "1,0,0,0,1,0,0,0,1"),
    writable(30, &[UP_TO_4, UP_TO_2, UP_TO_4, UP_TO_2, OneOf(&[1, 3]), OneOf(&[0, 1, 3]), UP_TO_2], "0,0,0,0,1,0,1"),
    writable(
        32,
        &[Whole(3, 6), FLAG, U16, RESERVED, OneOf(&[0, 1, 2, 3, 6]), FLAG, U16, U32, RESERVED],
        "3,0,0,0,0,0,0,100000000,0",
    ),
    writable(35, &[FLAG, UP_TO_2, FLAG, FLAG], "1,1,1,1"),
    writable(36, &[Real(10.0); 9], "4,4,4,5,5,5,5.5,5.5,5.5"),
    writable(38, &[Real(10.0); 9], "6,6,6,3,3,3,5,5,5"),
    writable(43, &[Rate; 3], "0,0,0"),
    writable(44, &[UP_TO_2, OneOf(&[1, 3]), Whole(1, 5)], "0,1,5"),
    read_only(47, CALIBRATION, NO_CALIBRATION),
    writable(82, &[FLAG, FLAG, UP_TO_3, FLAG, RESERVED], "0,0,0,0,0"),
    writable(83, &[FLAG, FLAG, RESERVED, RESERVED, U32, ANY, Real(90.0), Real(180.0), ANY], "0,0,0,0,1000,0,0,0,0"),
    writable(84, CALIBRATION, NO_CALIBRATION),
    writable(
        85,
        &[WINDOW, WINDOW, WINDOW, WINDOW, WINDOW, UP_TO_3, UP_TO_3, UP_TO_3, UP_TO_3, UP_TO_3],
        "0,4,4,4,0,0,3,3,3,0",
    ),
];
