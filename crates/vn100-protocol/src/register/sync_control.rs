//! Register 32: what the synchronisation pins do.

use core::fmt;

use super::{
    Register, RegisterContents, RegisterValue, ValueError, WritableValue, field_reader::FieldReader, write_list,
};

/// The modes of SyncIn and SyncOut. The numbers are kept as they are, so that one that is not known
/// here survives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SyncControl {
    /// What an edge on SyncIn does: 3 counts, 4 starts a sample, 5 sends one line, 6 sends one of
    /// every stream.
    pub in_mode: u8,
    /// 0 a rising edge, 1 a falling one.
    pub in_edge: u8,
    /// Edges passed over between two that count.
    pub in_skip: u16,
    /// Reserved, 0.
    pub reserved_in: u32,
    /// What an edge of SyncOut means: 0 nothing, 1 a sample begins, 2 a sample is ready, 3 an
    /// attitude is ready.
    pub out_mode: u8,
    /// 0 pulses go low, 1 high.
    pub out_polarity: u8,
    /// Events passed over between two pulses: their count runs at 800 Hz / (`out_skip` + 1) in
    /// modes 1 and 2.
    pub out_skip: u16,
    /// The length of a pulse in nanoseconds.
    pub out_pulse_ns: u32,
    /// Reserved, 0.
    pub reserved_out: u32,
}

/// As sold.
impl Default for SyncControl {
    fn default() -> Self {
        Self {
            in_mode: 3,
            in_edge: 0,
            in_skip: 0,
            reserved_in: 0,
            out_mode: 0,
            out_polarity: 0,
            out_skip: 0,
            out_pulse_ns: 100_000_000,
            reserved_out: 0,
        }
    }
}

impl RegisterValue for SyncControl {
    const REGISTERS: &'static [Register] = &[Register::SYNC_CONTROL];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let control = Self {
            in_mode: fields.integer("SyncIn mode")?,
            in_edge: fields.integer("SyncIn edge")?,
            in_skip: fields.integer("SyncIn skip factor")?,
            reserved_in: fields.integer("reserved")?,
            out_mode: fields.integer("SyncOut mode")?,
            out_polarity: fields.integer("SyncOut polarity")?,
            out_skip: fields.integer("SyncOut skip factor")?,
            out_pulse_ns: fields.integer("SyncOut pulse width")?,
            reserved_out: fields.integer("reserved")?,
        };
        fields.end()?;
        Ok(control)
    }
}

impl WritableValue for SyncControl {
    fn register(&self) -> Register {
        Register::SYNC_CONTROL
    }
}

impl fmt::Display for SyncControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_list(
            f,
            [
                self.in_mode.into(),
                self.in_edge.into(),
                self.in_skip.into(),
                self.reserved_in,
                self.out_mode.into(),
                self.out_polarity.into(),
                self.out_skip.into(),
                self.out_pulse_ns,
                self.reserved_out,
            ],
        )
    }
}
