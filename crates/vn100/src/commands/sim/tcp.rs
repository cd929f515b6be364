//! The emulated sensor at a TCP address, as a serial server has it: for other programs, on every system.

use std::{io, net::SocketAddr};

use super::times;
use anyhow::{Context, Result};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpListener, TcpStream},
};
use vn100_capture::Source;
use vn100_driver::{Connect, Connection};
use vn100_protocol::stream::StreamInput;
use vn100_session::{EmulatedConnection, EmulatedPort};

/// The emulated sensor and the address at which it waits for a program.
pub(super) struct TcpSensor {
    port: EmulatedPort,
    baud: u32,
    listener: TcpListener,
    openings: u64,
    bytes_sent: u64,
}

impl TcpSensor {
    /// The sensor at `address`; port 0 takes any free one. A serial server has its own baud rate to the sensor, here `baud`.
    pub(super) async fn bind(port: EmulatedPort, baud: u32, address: SocketAddr) -> Result<Self> {
        let listener = TcpListener::bind(address).await;
        let listener = listener
            .with_context(|| format!("cannot listen at {address}: choose another port, or 0 for a free one"))?;
        Ok(Self { port, baud, listener, openings: 0, bytes_sent: 0 })
    }

    /// The address by which `attach` finds it, such as `tcp://127.0.0.1:40123`.
    pub(super) fn address(&self) -> io::Result<String> {
        Ok(format!("tcp://{}", self.listener.local_addr()?))
    }

    /// Serves one program after another, until the future is dropped. While the sensor is unplugged, connections are closed at once.
    pub(super) async fn serve(&mut self) -> io::Result<()> {
        loop {
            let (host, _) = self.listener.accept().await?;
            if let Ok(sensor) = self.port.open(self.baud).await {
                self.openings += 1;
                // the host has left, or the sensor was unplugged
                _ = pass_on(host, sensor, &mut self.bytes_sent).await;
            }
        }
    }

    /// The sentence about a served sensor at its end.
    pub(super) fn summary(&self) -> String {
        format!("opened {}, {} bytes sent", times(self.openings), self.bytes_sent)
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
    use std::{net::Ipv4Addr, num::NonZeroU32, time::Duration};

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
        let mut sensor = TcpSensor::bind(port, baud.get(), (Ipv4Addr::LOCALHOST, 0).into()).await.unwrap();
        let address = sensor.address().unwrap();
        let address = address.strip_prefix("tcp://").unwrap();
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
            ended = sensor.serve() => panic!("{ended:?}"),
        }
        assert!(sensor.summary().starts_with("opened 2 times, "), "{}", sensor.summary());
    }
}
