//! What a face can ask of a session.

/// A command to a session. Those for a playback have no effect on a live source.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Exclude everything so far from the result, as warm-up.
    EndWarmUp,
    /// Discard everything so far and restart; data time counts from here.
    StartOver,
    /// Mark this place of a live stream, and of its recording, with this text.
    Mark(String),
    /// End the session. What was measured so far is the result.
    Stop,
    /// Pause the playback, or resume it.
    TogglePause,
    /// Pause the playback after one more second of data.
    Step,
    /// The next higher speed of the playback.
    Faster,
    /// The next lower speed of the playback.
    Slower,
    /// Continue the playback at this part of the capture, from 0 (its start) to 1 (its end); other
    /// values are taken for the nearer of the two.
    GoTo(f64),
    /// Move the playback by this part of the capture, from -1 to 1, relative to its place, or to
    /// the place that an earlier command moves it to.
    Seek(f64),
    /// Measure the part of the capture from the first to the second value alone, each from 0 to 1,
    /// and pause at its end.
    Select(f64, f64),
}

/// Why a command had no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandRefusal {
    /// The samples of the capture are not counted yet, or cannot be.
    NotCounted,
    /// The capture was replayed to its end: only an earlier place can be replayed.
    AtEnd,
    /// The measurement is over.
    Over,
    /// Only the stream of an open live link can be marked.
    NoMark,
}
