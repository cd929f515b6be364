//! Attaches to a sensor and prints its samples:
//! `cargo run --example print_samples -- /dev/ttyUSB0`.
#![allow(clippy::print_stdout, reason = "that is what it is for")]

use tokio_util::sync::CancellationToken;
use vn100_capture::{Clock, Event};
use vn100_driver::{LinkOptions, SerialPorts, open_link};

#[tokio::main(flavor = "current_thread")]
async fn main() {
    let port = std::env::args().nth(1).unwrap_or_else(|| "/dev/ttyUSB0".into());
    let port = SerialPorts::new(&port, Clock::start());
    let (_link, mut events) = open_link(port, LinkOptions::default(), CancellationToken::new());
    while let Some(event) = events.recv().await {
        match event {
            Event::Batch(batch) => {
                let Some(layout) = &batch.layout else { continue };
                for counts in batch.rows() {
                    let values = counts.iter().zip(layout.channels.iter());
                    let texts: Vec<_> =
                        values.map(|(&count, channel)| format!("{} {}", channel.name, channel.value(count))).collect();
                    println!("{}", texts.join(", "));
                }
            }
            Event::Link(event) => println!("{:?}", event.kind),
            Event::End(end) => println!("the end: {:?}", end.error),
        }
    }
}
