//! What a face can ask of a session.

/// A command to a session. Those for a playback have no effect on a live source.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Exclude everything so far from the result, as warm-up.
    EndWarmUp,
    /// Discard everything so far and restart; data time counts from here.
    StartOver,
    /// Mark this place of a live stream, and of its recording, with a text.
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
    /// Continue the playback at this part of the capture, 0 to 1; else at the nearer end.
    GoTo(f64),
    /// Continue the playback so much of the capture, -1 to 1, from where it is or is about to be.
    Seek(f64),
    /// Measure this part of the capture alone, from and to 0 to 1, and pause at its end.
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
    /// Marks are for the stream of a live link, which is open.
    NoMark,
}
