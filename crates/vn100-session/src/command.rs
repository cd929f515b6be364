//! What a face can ask of a session.

/// A command to a session. Those for a playback have no effect on a live source.
#[derive(Debug, Clone, PartialEq, Eq)]
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
    /// The next higher speed of the playback.
    Faster,
    /// The next lower speed of the playback.
    Slower,
}

/// Why a command had no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandRefusal {
    /// The capture was replayed to its end.
    AtEnd,
    /// The measurement is over.
    Over,
    /// Only the stream of an open live link can be marked.
    NoMark,
}
