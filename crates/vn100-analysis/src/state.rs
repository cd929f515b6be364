//! The mergeable state of recordings: exact sums of pieces and of whole recordings, as bytes.
//!
//! A state holds recordings by their names, each in pieces that know their place in it. Merging is
//! the union of both: associative and commutative. The pieces of one recording give, bit by bit,
//! the results of the undivided recording, across gaps as well. Different recordings are kept side
//! by side, so that no window reaches from one into another, and each keeps what its parameters,
//! statistics, spectrum and warnings need. [`Pool`](crate::Pool) takes them together.
//!
//! What cannot be pooled: rows that were placed by arrival times are whole recordings, and not
//! pieces of one ([`NotAppended`]); what changes with time (blocks, trends, disturbances,
//! temperature) belongs to one recording, and is not a property of several. The rows themselves are
//! not in a state: none can be added to it, removed from it, or measured with other settings.

use std::collections::{BTreeMap, btree_map::Entry};

use state_bytes::{BadEncoding, ByteReader, Encoded};
use thiserror::Error;
use vn100_protocol::Layout;

use crate::accumulate::{
    analysis::Analysis,
    piece::{NotAppended, PieceStart},
};

/// The first bytes of a state.
const MAGIC: [u8; 4] = *b"VN1S";

/// Version of the form in bytes.
const VERSION: u16 = 3;

/// Length of the header: magic, version, layout of the sums, length of what follows.
const HEADER: usize = 4 + 2 + 8 + 8;

/// Length of the CRC-32 (ISO-HDLC) of all bytes before it.
const CHECKSUM: usize = 4;

/// Recordings, or pieces of them, that merge in any order.
///
/// ```
/// use vn100_analysis::{Analysis, Settings, State};
///
/// let one = State::of("monday.mcap", None, &mut Analysis::new(Settings::default()));
/// let other = State::of("tuesday.mcap", None, &mut Analysis::new(Settings::default()));
/// let bytes = one.merged(other)?.to_bytes();
/// assert_eq!(State::from_bytes(&bytes)?.recordings().count(), 2);
/// # Ok::<(), vn100_analysis::StateError>(())
/// ```
#[derive(Debug, Default)]
pub struct State {
    recordings: BTreeMap<String, Recording>,
}

/// One recording.
#[derive(Debug, Default)]
struct Recording {
    /// Start of the recording in nanoseconds since 1970-01-01 UTC; `None` where not known.
    started_ns: Option<i64>,
    /// Why the recording could not be read, or not to its end.
    error: Option<String>,
    /// The pieces in order of time, without overlap.
    pieces: Vec<Piece>,
}

/// A recording, or a part of one, as the bytes of its [`Analysis`], which take a fifth of the
/// memory.
#[derive(Debug, Clone)]
struct Piece {
    bytes: Box<[u8]>,
    start: PieceStart,
    end: PieceStart,
    layout: Option<Layout>,
}

/// A recording of a [`State`].
#[derive(Debug, Clone, Copy)]
pub struct RecordedPieces<'a> {
    /// Name of the recording.
    pub name: &'a str,
    /// Start of the recording, in nanoseconds since 1970-01-01 UTC; `None` where not known.
    pub started_ns: Option<i64>,
    /// Why the recording could not be read, or not to its end; `None` where it was read to its end.
    pub error: Option<&'a str>,
    pieces: &'a [Piece],
}

/// Why bytes are no state, or two states cannot be merged. Nothing was merged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StateError {
    /// The bytes do not begin as those of a state.
    #[error("these bytes are no state: they do not begin with VN1S")]
    NotAState,
    /// Another version of the form wrote the bytes.
    #[error("the state has version {found}, this program reads version {known}: make it anew from the recording")]
    OtherVersion {
        /// The version in the bytes.
        found: u16,
        /// The version of this program.
        known: u16,
    },
    /// The sums in the bytes are over other windows, bins or blocks.
    #[error("the sums of the state have the layout {found:016x}, those of this program {known:016x}: make it anew")]
    OtherLayout {
        /// The layout of the sums in the bytes.
        found: u64,
        /// The layout of the sums in this program.
        known: u64,
    },
    /// Bytes are missing at the end.
    #[error("the state ends after {bytes} of {expected} bytes: copy it again")]
    Truncated {
        /// Number of bytes.
        bytes: u64,
        /// Number of bytes by the header.
        expected: u64,
    },
    /// The checksum does not match the bytes.
    #[error("the state is damaged: its checksum is {found:08x}, that of its bytes {computed:08x}")]
    Damaged {
        /// The checksum in the bytes.
        found: u32,
        /// The checksum computed from the bytes.
        computed: u32,
    },
    /// The checksum matches, and the bytes hold a value that no state has.
    #[error("the state is damaged: {0}")]
    Contradictory(#[from] BadEncoding),
    /// Two pieces of a recording hold samples of the same time, or hold none and have the same
    /// place, so that their order is not known.
    #[error(
        "{recording}: both states hold the samples from {start} to {end}: merge each piece once, and name recordings differently"
    )]
    Overlap {
        /// Name of the recording.
        recording: String,
        /// Index of the first sample that both hold.
        start: u64,
        /// Index after the last sample of either piece.
        end: u64,
    },
    /// The pieces of a recording are of different messages.
    #[error("{recording}: the pieces hold different messages or channels: name recordings differently")]
    OtherMessage {
        /// Name of the recording.
        recording: String,
    },
    /// The counts of a channel are worth different amounts in two pieces.
    #[error(
        "{recording}: a count of {channel} is worth {scale:e} and {other:e} in its pieces: measure all with the same resolution, or \
         name recordings differently"
    )]
    OtherScale {
        /// Name of the recording.
        recording: String,
        /// Name of the channel.
        channel: String,
        /// What a count is worth in a piece.
        scale: f64,
        /// What it is worth in another one.
        other: f64,
    },
    /// The two states name another start or error of the recording.
    #[error("{recording}: the states contradict each other on when it began, or whether it could be read")]
    OtherFacts {
        /// Name of the recording.
        recording: String,
    },
}

impl State {
    /// A state with one recording of this name, or with a piece of it
    /// ([`starting_at`](Analysis::starting_at)). Rows of the analysis that are pending are decided.
    #[must_use]
    pub fn of(name: &str, started_ns: Option<i64>, analysis: &mut Analysis) -> Self {
        analysis.finish();
        let recording = match Piece::of(analysis) {
            Some(piece) => Recording { started_ns, error: None, pieces: vec![piece] },
            None => {
                let error = format!("{name}: its sums are beyond what a state holds: measure it by itself");
                Recording { started_ns, error: Some(error), pieces: Vec::new() }
            }
        };
        Self { recordings: BTreeMap::from([(name.to_owned(), recording)]) }
    }

    /// A state with one recording that could not be read.
    #[must_use]
    pub fn unreadable(name: &str, error: &str) -> Self {
        let recording = Recording { error: Some(error.to_owned()), ..Recording::default() };
        Self { recordings: BTreeMap::from([(name.to_owned(), recording)]) }
    }

    /// The state, with the error that ended the reading of its recordings.
    #[must_use]
    pub fn with_error(mut self, error: &str) -> Self {
        self.recordings.values_mut().for_each(|recording| recording.error = Some(error.to_owned()));
        self
    }

    /// The union of both states, which does not depend on their order.
    ///
    /// # Errors
    /// [`StateError`]: when both hold samples of the same time of one recording, and when
    /// recordings of one name differ in message, start or error.
    pub fn merged(mut self, other: Self) -> Result<Self, StateError> {
        for (name, theirs) in other.recordings {
            match self.recordings.entry(name) {
                Entry::Vacant(free) => _ = free.insert(theirs),
                Entry::Occupied(mut taken) => {
                    let name = taken.key().clone();
                    taken.get_mut().merge(&name, theirs)?;
                }
            }
        }
        Ok(self)
    }

    /// The state with neighbouring pieces joined, which takes fewer bytes; to be called once no
    /// piece can come between them. Pieces that cannot be appended stay apart, and
    /// [`analysis`](RecordedPieces::analysis) gives the reason.
    #[must_use]
    pub fn joined(mut self) -> Self {
        self.recordings.values_mut().for_each(Recording::join);
        self
    }

    /// The recordings, by name.
    pub fn recordings(&self) -> impl Iterator<Item = RecordedPieces<'_>> {
        self.recordings.iter().map(|(name, recording)| RecordedPieces {
            name,
            started_ns: recording.started_ns,
            error: recording.error.as_deref(),
            pieces: &recording.pieces,
        })
    }

    /// The form in bytes, which is the same for the same pieces, in whatever order they were
    /// merged.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend_from_slice(&VERSION.to_le_bytes());
        out.extend_from_slice(&imu_noise::layout_of_sums().to_le_bytes());
        out.extend_from_slice(&[0; 8]);
        self.recordings.len().encode(&mut out);
        for (name, recording) in &self.recordings {
            name.encode(&mut out);
            recording.encode(&mut out);
        }
        let length = (out.len() - HEADER) as u64;
        out[HEADER - 8..HEADER].copy_from_slice(&length.to_le_bytes());
        let checksum = crc32fast::hash(&out);
        out.extend_from_slice(&checksum.to_le_bytes());
        out
    }

    /// A state from bytes that [`to_bytes`](Self::to_bytes) gave. Any other bytes give a state or
    /// an error, and allocate at most a fixed multiple of their number.
    ///
    /// # Errors
    /// [`StateError`]: when the bytes are of another kind, version or layout, damaged or
    /// incomplete.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, StateError> {
        let truncated = |expected: u64| StateError::Truncated { bytes: bytes.len() as u64, expected };
        if !bytes.starts_with(&MAGIC) {
            return Err(StateError::NotAState);
        }
        let (header, rest) = bytes.split_at_checked(HEADER).ok_or_else(|| truncated(HEADER as u64))?;
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
        let (found, layout, length) = (number(&header[4..6]) as u16, number(&header[6..14]), number(&header[14..]));
        if found != VERSION {
            return Err(StateError::OtherVersion { found, known: VERSION });
        }
        let known = imu_noise::layout_of_sums();
        if layout != known {
            return Err(StateError::OtherLayout { found: layout, known });
        }
        if rest.len() as u64 != length.saturating_add(CHECKSUM as u64) {
            return Err(truncated(length.saturating_add((HEADER + CHECKSUM) as u64)));
        }
        let (content, checksum) = rest.split_at(rest.len() - CHECKSUM);
        let (found, computed) = (number(checksum) as u32, crc32fast::hash(&bytes[..bytes.len() - CHECKSUM]));
        if found != computed {
            return Err(StateError::Damaged { found, computed });
        }
        let mut input = ByteReader::new(content);
        let recordings = BTreeMap::decode(&mut input)?;
        state_bytes::check(input.left() == 0)?;
        Ok(Self { recordings })
    }
}

impl Piece {
    /// The piece that an analysis is of; `None` for sums that no measurement can have.
    fn of(analysis: &Analysis) -> Option<Self> {
        let mut bytes = Vec::new();
        analysis.encode(&mut bytes);
        Self::decode(&mut ByteReader::new(&bytes)).ok()
    }

    fn analysis(&self) -> Result<Analysis, BadEncoding> {
        Analysis::decode(&mut ByteReader::new(&self.bytes))
    }

    /// Both pieces joined; `None` where the other is no neighbour, or cannot be appended.
    fn continued_by(&self, next: &Self) -> Option<Self> {
        let mut analysis = self.analysis().ok().filter(|_| self.end == next.start)?;
        analysis.append_finished(&next.analysis().ok()?).ok()?;
        Self::of(&analysis)
    }
}

impl Encoded for Piece {
    fn encode(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.bytes);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let mut behind = *input;
        let analysis = Analysis::decode(&mut behind)?;
        let bytes = input.take(input.left() - behind.left())?.into();
        Ok(Self { bytes, start: analysis.start(), end: analysis.end(), layout: analysis.layout().cloned() })
    }
}

impl Recording {
    fn join(&mut self) {
        let mut joined: Vec<Piece> = Vec::with_capacity(self.pieces.len());
        for piece in std::mem::take(&mut self.pieces) {
            let longer = joined.last().and_then(|last| last.continued_by(&piece));
            match (longer, joined.last_mut()) {
                (Some(longer), Some(last)) => *last = longer,
                _ => joined.push(piece),
            }
        }
        self.pieces = joined;
    }

    fn merge(&mut self, name: &str, other: Self) -> Result<(), StateError> {
        let recording = || name.to_owned();
        if (self.started_ns, &self.error) != (other.started_ns, &other.error) {
            return Err(StateError::OtherFacts { recording: recording() });
        }
        let layouts: Vec<_> =
            self.pieces.iter().chain(&other.pieces).filter_map(|piece| piece.layout.as_ref()).collect();
        if let Some(pair) = layouts.windows(2).find(|pair| pair[0] != pair[1]) {
            return Err(other_layout(name, pair[0], pair[1]));
        }
        self.pieces.extend(other.pieces);
        self.pieces.sort_by_key(|piece| (piece.start.index, piece.end.index));
        for pair in self.pieces.windows(2) {
            let (start, end) = (pair[1].start.index, pair[1].end.index);
            let is_twice = (pair[0].start.index, pair[0].end.index) == (start, end);
            if start < pair[0].end.index || is_twice {
                return Err(StateError::Overlap { recording: recording(), start, end });
            }
        }
        Ok(())
    }
}

/// The first scale in which layouts of the same channels differ, else that the channels do.
fn other_layout(recording: &str, ours: &Layout, theirs: &Layout) -> StateError {
    let recording = recording.to_owned();
    let names = |layout: &Layout| layout.channels.iter().map(|channel| channel.name.clone()).collect::<Vec<_>>();
    let mut pairs = ours.channels.iter().zip(theirs.channels.iter());
    match pairs.find(|(ours, theirs)| ours.scale != theirs.scale) {
        Some((channel, other)) if ours.message == theirs.message && names(ours) == names(theirs) => {
            StateError::OtherScale {
                recording,
                channel: channel.name.to_string(),
                scale: channel.scale,
                other: other.scale,
            }
        }
        _ => StateError::OtherMessage { recording },
    }
}

state_bytes::encoded!(Recording { started_ns, error, pieces } if |recording| {
    recording.pieces.windows(2).all(|pair| pair[0].end.index <= pair[1].start.index)
});

impl RecordedPieces<'_> {
    /// The sums of the recording, as of the undivided record; samples between the pieces count as
    /// missing. `None` where the recording could not be read.
    ///
    /// # Errors
    /// [`NotAppended`] when the pieces cannot be appended to each other.
    pub fn analysis(&self) -> Result<Option<Analysis>, NotAppended> {
        let mut whole: Option<Analysis> = None;
        // bytes that were read once can be read again
        for piece in self.pieces.iter().filter_map(|piece| piece.analysis().ok()) {
            match &mut whole {
                Some(whole) => whole.append_finished(&piece)?,
                None => whole = Some(piece),
            }
        }
        Ok(whole)
    }
}
