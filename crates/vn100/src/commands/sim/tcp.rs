//! The emulated sensor at a TCP address, as a serial server has it: for other programs, on every system.

use std::{io, net::SocketAddr, time::Duration};

use anyhow::{Context, Result};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpListener, TcpStream},
    runtime::Runtime,
    time,
};
use vn100_analysis::Completion;
use vn100_capture::{Clock, Source};
use vn100_driver::{Connect, Connection};
use vn100_protocol::stream::StreamInput;
use vn100_session::{EmulatedConnection, EmulatedPort};

use super::times;
use crate::{
    args::SimArgs,
    exit::{HangUp, print, report, stop_on_interrupt},
    live_source::emulated_port,
};

/// The sensor at `address`; port 0 takes any free one. What is printed is the address by which `attach` finds it, such as
/// `tcp://127.0.0.1:40123`.
pub(super) fn emulate_at(address: SocketAddr, args: &SimArgs) -> Result<Completion> {
    let runtime = Runtime::new().context("cannot start the worker threads")?;
    runtime.block_on(async {
        let stop = stop_on_interrupt(HangUp::Stops)?;
        let (port, baud) = emulated_port(&args.sensor, Clock::start())?;
        let listener = TcpListener::bind(address).await;
        let listener = listener
            .with_context(|| format!("cannot listen at {address}: choose another port, or 0 for a free one"))?;
        print(&format!("tcp://{}\n", listener.local_addr()?))?;
        let (mut openings, mut bytes_sent) = (0, 0);
        tokio::select! {
            served = serve(&listener, port, baud, &mut openings, &mut bytes_sent) => {
                served.context("the emulated sensor accepts no more connections")?;
            }
            () = stop.cancelled() => {}
            () = time::sleep(args.duration.unwrap_or(Duration::MAX)) => {}
        }
        report(&format!("opened {}, {bytes_sent} bytes sent", times(openings)));
        Ok(Completion::Complete)
    })
}

/// Serves one program after another, until the future is dropped. A serial server has its own baud rate to the sensor, here `baud`. While
/// the sensor is unplugged, connections are closed at once.
async fn serve(
    listener: &TcpListener,
    mut port: EmulatedPort,
    baud: u32,
    openings: &mut u64,
    bytes_sent: &mut u64,
) -> io::Result<()> {
    loop {
        let (host, _) = listener.accept().await?;
        if let Ok(sensor) = port.open(baud).await {
            *openings += 1;
            // the host has left, or the sensor was unplugged
            _ = pass_on(host, sensor, bytes_sent).await;
        }
    }
}

/// Passes bytes on in both directions until one end closes.
async fn pass_on(mut host: TcpStream, mut sensor: EmulatedConnection, bytes_sent: &mut u64) -> io::Result<()> {
    host.set_nodelay(true)?;
    let mut written = [0; 1024];
    loop {
        tokio::select! {
            count = host.read(&mut written) => match count? {
                0 => return Ok(()),
                count => sensor.write(&written[..count]).await?,
            },
            input = sensor.next_input() => match input? {
                Some(StreamInput::Chunk(chunk)) => {
                    host.write_all(&chunk.bytes).await?;
                    *bytes_sent += chunk.bytes.len() as u64;
                }
                Some(StreamInput::Link(_)) => {}
                None => return Ok(()),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::{net::Ipv4Addr, num::NonZeroU32};

    use tokio::io::{AsyncBufReadExt, BufReader};
    use vn100_sim::{
        device::{Device, DeviceConfig},
        fault::FaultPlan,
        wire::Wire,
    };

    use super::*;

    /// The first line that begins with `head`.
    async fn line(host: &mut BufReader<TcpStream>, head: &str) -> String {
        let mut lines = host.lines();
        loop {
            match lines.next_line().await.unwrap() {
                Some(line) if line.starts_with(head) => return line,
                Some(_) => {}
                None => panic!("the sensor has hung up"),
            }
        }
    }

    #[tokio::test]
    async fn one_program_after_another_reads_the_sensor_and_asks_it() {
        let device = Device::new(DeviceConfig::default());
        let baud = NonZeroU32::new(device.baud()).unwrap();
        let wire = Wire::new(device, &FaultPlan::default(), 1, baud);
        let port = EmulatedPort::new(wire, Duration::from_secs(2), 0);
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
        let address = listener.local_addr().unwrap();
        let (mut openings, mut bytes_sent) = (0, 0);
        let programs = async {
            for _ in 0..2 {
                let mut host = BufReader::new(TcpStream::connect(address).await.unwrap());
                line(&mut host, "$VNYMR").await;
                host.write_all(b"$VNRRG,01*72\r\n").await.unwrap();
                assert!(line(&mut host, "$VNRRG,01").await.contains("VN-100"));
            }
        };
        tokio::select! {
            () = programs => {}
            ended = serve(&listener, port, baud.get(), &mut openings, &mut bytes_sent) => panic!("{ended:?}"),
        }
        assert_eq!(openings, 2);
    }
}
