//! How often each unsolicited device error came.

use crate::DeviceError;

/// Errors that the manual has; all others share a count behind these.
const KNOWN: [DeviceError; 13] = DeviceError::KNOWN;

/// Counts of errors by their code.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct UnsolicitedErrors {
    counts: [u64; KNOWN.len() + 1],
    /// The first error that the manual does not have.
    first_unknown: Option<DeviceError>,
}

impl UnsolicitedErrors {
    /// Counts an error.
    pub fn count(&mut self, error: DeviceError) {
        let place = KNOWN.iter().position(|&known| known == error).unwrap_or(KNOWN.len());
        self.counts[place] += 1;
        if place == KNOWN.len() {
            self.first_unknown.get_or_insert(error);
        }
    }

    /// Those that came, with how often, by code. Codes that the manual does not have count as
    /// the first of them.
    pub fn iter(&self) -> impl Iterator<Item = (DeviceError, u64)> {
        let errors = KNOWN.into_iter().map(Some).chain([self.first_unknown]);
        errors.zip(self.counts).filter(|(_, count)| *count > 0).filter_map(|(error, count)| Some((error?, count)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_code_has_its_count_and_unknown_ones_share_one() {
        let mut errors = UnsolicitedErrors::default();
        for code in 0..=u8::MAX {
            errors.count(DeviceError::from_code(code));
        }
        errors.count(DeviceError::OutputBufferOverflow);
        let counted: Vec<_> = errors.iter().map(|(error, count)| (error.code(), count)).collect();
        let mut expected: Vec<_> = KNOWN.map(DeviceError::code).map(|code| (code, 1 + u64::from(code == 0x0B))).into();
        expected.push((0, 256 - KNOWN.len() as u64));
        assert_eq!(counted, expected);
    }
}
