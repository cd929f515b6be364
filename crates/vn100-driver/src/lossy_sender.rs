//! A channel that never makes its sender wait: inputs that do not fit are dropped, counted and reported.

use std::collections::VecDeque;

use tokio::sync::mpsc;

use vn100_protocol::stream::{LinkEvent, LinkEventKind, StreamInput};

/// Link events that may wait for room; later ones are dropped. A reconnect causes two.
const WAITING_EVENTS: usize = 64;

/// Sends [`StreamInput`]s without waiting. Bytes that do not fit into the channel become an
/// [`Overrun`](LinkEventKind::Overrun) at their place; a link event is kept until there is room, so
/// that the bytes before and after it are not joined.
#[derive(Debug)]
pub(crate) struct LossySender {
    inputs: mpsc::Sender<StreamInput>,
    waiting: VecDeque<LinkEvent>,
    lost_bytes: u64,
}

impl LossySender {
    pub(crate) fn new(inputs: mpsc::Sender<StreamInput>) -> Self {
        Self { inputs, waiting: VecDeque::new(), lost_bytes: 0 }
    }

    /// Sends an input after all pending ones. `now_ns` is the time of an overrun.
    pub(crate) fn send(&mut self, input: StreamInput, now_ns: i64) {
        match input {
            StreamInput::Chunk(chunk) => {
                let length = chunk.bytes.len();
                if !self.send_waiting() || self.inputs.try_send(chunk.into()).is_err() {
                    self.lose(length as u64, now_ns);
                }
            }
            StreamInput::Link(event) => {
                if self.waiting.len() < WAITING_EVENTS {
                    self.waiting.push_back(event);
                }
                self.send_waiting();
            }
        }
    }

    /// Sends pending inputs, as far as there is room. Returns whether none is pending any more.
    pub(crate) fn send_waiting(&mut self) -> bool {
        while let Some(event) = self.waiting.front() {
            if self.inputs.try_send(StreamInput::Link(event.clone())).is_err() {
                return false;
            }
            self.waiting.pop_front();
        }
        true
    }

    /// Sends pending inputs, and blocks until there is room for them.
    pub(crate) fn send_waiting_blocking(&mut self) {
        for event in self.waiting.drain(..) {
            // a receiver that was dropped does not need it
            let _ = self.inputs.blocking_send(StreamInput::Link(event));
        }
    }

    /// Sends pending inputs, and waits until there is room for them.
    pub(crate) async fn send_waiting_async(&mut self) {
        for event in self.waiting.drain(..) {
            // a receiver that was dropped does not need it
            let _ = self.inputs.send(StreamInput::Link(event)).await;
        }
    }

    pub(crate) fn lost_bytes(&self) -> u64 {
        self.lost_bytes
    }

    fn lose(&mut self, length: u64, now_ns: i64) {
        self.lost_bytes += length;
        match self.waiting.back_mut() {
            Some(LinkEvent { kind: LinkEventKind::Overrun { bytes }, .. }) => *bytes += length,
            _ => self.waiting.push_back(LinkEvent { at_ns: now_ns, kind: LinkEventKind::Overrun { bytes: length } }),
        }
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;
    use proptest::prelude::*;

    use super::*;
    use vn100_protocol::stream::Chunk;

    fn chunk(length: usize) -> StreamInput {
        Chunk { bytes: Bytes::from(vec![b'x'; length]), at_ns: None }.into()
    }

    fn link(kind: LinkEventKind) -> StreamInput {
        StreamInput::Link(LinkEvent { at_ns: 7, kind })
    }

    fn down() -> StreamInput {
        link(LinkEventKind::Down { cause: "unplugged".into() })
    }

    #[test]
    fn a_loss_is_reported_at_its_place() {
        let (sender, mut inputs) = mpsc::channel(2);
        let mut sender = LossySender::new(sender);
        for input in [chunk(3), chunk(3), chunk(3), chunk(4), down(), chunk(5)] {
            sender.send(input, 7);
        }
        assert_eq!((inputs.try_recv().unwrap(), inputs.try_recv().unwrap()), (chunk(3), chunk(3)));
        assert!(!sender.send_waiting(), "room for two of three");
        let overrun = |bytes| link(LinkEventKind::Overrun { bytes });
        assert_eq!((inputs.try_recv().unwrap(), inputs.try_recv().unwrap()), (overrun(7), down()));
        sender.send(chunk(6), 7);
        assert_eq!((inputs.try_recv().unwrap(), inputs.try_recv().unwrap()), (overrun(5), chunk(6)));
        assert_eq!(sender.lost_bytes(), 12);
    }

    #[test]
    fn pending_inputs_are_bounded() {
        let (sender, _inputs) = mpsc::channel(1);
        let mut sender = LossySender::new(sender);
        (0..10_000).for_each(|_| [down(), chunk(1)].into_iter().for_each(|input| sender.send(input, 7)));
        assert!(sender.waiting.len() <= WAITING_EVENTS + 1);
    }

    proptest! {
        #[test]
        fn every_byte_arrives_or_is_reported_lost(room in 1..6_usize, steps in prop::collection::vec((1..50_usize, any::<bool>()), 0..100)) {
            let (sender, mut inputs) = mpsc::channel(room);
            let mut sender = LossySender::new(sender);
            let (mut arrived, mut lost, mut sent) = (0, 0, 0);
            let mut take = |input| match input {
                StreamInput::Chunk(chunk) => arrived += chunk.bytes.len() as u64,
                StreamInput::Link(LinkEvent { kind: LinkEventKind::Overrun { bytes }, .. }) => lost += bytes,
                StreamInput::Link(other) => panic!("{other:?}"),
            };
            for (length, receive) in steps {
                sender.send(chunk(length), 7);
                sent += length as u64;
                if receive && let Ok(input) = inputs.try_recv() {
                    take(input);
                }
            }
            loop {
                let done = sender.send_waiting();
                while let Ok(input) = inputs.try_recv() {
                    take(input);
                }
                if done {
                    break;
                }
            }
            prop_assert_eq!(arrived + lost, sent);
            prop_assert_eq!(lost, sender.lost_bytes());
        }
    }
}
