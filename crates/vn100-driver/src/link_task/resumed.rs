//! An output that was found paused: made to go on, told, and paused again at the end.

use vn100_protocol::Command;

use super::LinkTask;
use crate::{connect::Connect, link_output::NobodyListens, link_state::LinkState, link_state::Up, set_again::exchange};
use vn100_protocol::stream::LinkEventKind;

impl<C: Connect> LinkTask<C> {
    /// Tells that the sensor sends because it was told to.
    pub(super) async fn tell_resumed(&mut self, up: &mut Up) -> Result<(), NobodyListens> {
        up.output_resumed = true;
        self.state.send_replace(LinkState::Up(up.clone()));
        self.tell(LinkEventKind::OutputResumed).await
    }

    /// Leaves the output as it was found.
    pub(super) async fn pause_again(&mut self, connection: &mut C::Connection) {
        let output = &mut self.output;
        // what comes meanwhile is behind the end of the measurement
        let mut behind = Vec::new();
        let answers = exchange(connection, [Command::Async(false)], &mut behind, |line| output.note_sent(line)).await;
        if answers.is_ok_and(|answers| answers.iter().all(Result::is_ok)) {
            self.is_paused_again = true;
            // also into a recording, where nobody takes the events any more
            let _ = self.tell(LinkEventKind::OutputPaused).await;
        }
        let _ = self.set_aside(behind).await;
    }
}
