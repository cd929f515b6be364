//! Reads a register of a sensor while it streams:
//! `cargo run --example read_register -- /dev/ttyUSB0 7`.
#![allow(clippy::print_stdout, reason = "that is what it is for")]

use tokio_util::sync::CancellationToken;
use vn100_capture::Clock;
use vn100_driver::{LinkOptions, SerialPorts, open_link};
use vn100_protocol::Register;

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let port = arguments.next().unwrap_or_else(|| "/dev/ttyUSB0".into());
    let register = arguments.next().unwrap_or_else(|| "1".into()).parse()?;
    let (link, mut events) =
        open_link(SerialPorts::new(&port, Clock::start()), LinkOptions::default(), CancellationToken::new());
    // a link sends samples in any case; here they are not used
    tokio::spawn(async move { while events.recv().await.is_some() {} });
    match link.read(Register(register)).await? {
        Some(contents) => println!("register {register}: {}", contents.fields),
        None => println!("this sensor has no register {register}"),
    }
    Ok(())
}
