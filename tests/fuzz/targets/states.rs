//! The content of a state with a right checksum: a state or an error, and what is read of it, or
//! merged with it, ends in no panic. Its own bytes are read as what they say.

use std::sync::Arc;

use vn100_analysis::{Analysis, Assessment, PieceStart, Settings, State};
use vn100_protocol::{Layout, VNYMR, stream::Batch};

/// Magic, version and layout.
const HEAD: usize = 14;

/// What follows the header, without its checksum.
pub(crate) fn check(content: &[u8]) {
    let _ = State::from_bytes(content);
    let bytes = with_header(content);
    let Ok(state) = State::from_bytes(&bytes) else { return };
    assert_eq!(State::from_bytes(&state.to_bytes()).unwrap().to_bytes(), state.to_bytes());
    read(&state);
    for seed in seeds() {
        let other = || state_of(&with_header(&seed));
        for merged in [state_of(&bytes).merged(other()), other().merged(state_of(&bytes))] {
            merged.iter().for_each(read);
        }
    }
}

fn state_of(bytes: &[u8]) -> State {
    State::from_bytes(bytes).unwrap()
}

fn with_header(content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u64).to_le_bytes();
    let mut bytes = [&State::default().to_bytes()[..HEAD], &length, content].concat();
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

fn read(state: &State) {
    for recording in state.recordings() {
        if let Ok(Some(analysis)) = recording.analysis() {
            let snapshot = analysis.final_snapshot();
            let _ = Assessment::new(&snapshot, 0.95);
        }
    }
}

/// Pieces of a record of one channel, an angle and a rate.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let piece = |channel: usize, rows: std::ops::Range<u64>| {
        let channels = vec![VNYMR.channels[channel].clone()];
        let layout = Layout { channels: channels.into(), ..VNYMR.clone() };
        let counts = rows.clone().map(|row| (row * row % 91) as i32 - 45).collect();
        let start = PieceStart { index: rows.start, places: rows.start, samples: rows.start };
        let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() }).starting_at(start);
        analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts, ..Batch::default() });
        let bytes = State::of("a", Some(7), &mut analysis).to_bytes();
        bytes[HEAD + 8..bytes.len() - 4].to_vec()
    };
    vec![piece(0, 0..700), piece(0, 700..730), piece(9, 0..40), piece(9, 40..900)]
}
