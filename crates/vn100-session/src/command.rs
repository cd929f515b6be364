//! The commands that a face can send to a session.

/// A command to a session. Commands for a playback have no effect on a live source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Command {
    /// Exclude everything so far from the result, as warm-up.
    EndWarmUp,
    /// Discard everything so far and restart; data time counts from here.
    StartOver,
    /// Mark this place of a live stream, and of its recording, with this text.
    Mark(String),
    /// End the session. The measurement so far is the result.
    Stop,
    /// Pause the playback, or resume it.
    TogglePause,
    /// The next higher speed of the playback.
    Faster,
    /// The next lower speed of the playback.
    Slower,
}

/// The reason why a command had no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandRefusal {
    /// The capture was replayed to its end.
    AtEnd,
    /// The measurement is over.
    Over,
    /// Only the stream of an open live link can be marked.
    NoMark,
}
