//! A sensor on a serial server, reached over TCP.

use std::{
    io::{self, ErrorKind},
    time::Duration,
};

use bytes::BytesMut;
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
    time::timeout,
};

use crate::connect::{Connect, ConnectError, Connection};
use vn100_capture::{Clock, Source};
use vn100_protocol::stream::{Chunk, StreamInput};

const READ_BYTES: usize = 4096;

/// The timeout for an answer of the server: the system alone would wait for minutes.
const ANSWER_TIME: Duration = Duration::from_secs(5);

/// A byte stream at `tcp://host:port`. The serial server sets the baud rate of its port.
#[derive(Debug, Clone)]
pub struct TcpServer {
    host_and_port: String,
    clock: Clock,
}

impl TcpServer {
    /// The server at `address`, written `tcp://host:port`; nothing is opened yet.
    ///
    /// # Errors
    /// [`ConnectError::Address`] if the address is not written in this form.
    pub fn new(address: &str, clock: Clock) -> Result<Self, ConnectError> {
        let host_and_port = address.strip_prefix("tcp://").filter(|rest| {
            // an IPv6 address has colons of its own, in brackets
            let parts = rest.rsplit_once(':');
            parts.is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0))
        });
        match host_and_port {
            Some(host_and_port) => Ok(Self { host_and_port: host_and_port.into(), clock }),
            None => Err(ConnectError::Address(address.into())),
        }
    }
}

impl Connect for TcpServer {
    type Connection = TcpConnection;

    const HAS_BAUD: bool = false;

    async fn open(&mut self, _baud: u32) -> Result<TcpConnection, ConnectError> {
        let connect = async {
            let stream = in_answer_time(TcpStream::connect(&self.host_and_port)).await?;
            // a command is one small packet, which must not wait for another
            stream.set_nodelay(true)?;
            Ok(stream)
        };
        match connect.await {
            Ok(stream) => Ok(TcpConnection {
                name: self.name(),
                stream,
                buffer: BytesMut::with_capacity(READ_BYTES),
                clock: self.clock,
            }),
            Err(error) => Err(ConnectError::Server { address: self.name(), error }),
        }
    }

    fn now_ns(&self) -> i64 {
        self.clock.now_ns()
    }

    fn name(&self) -> String {
        format!("tcp://{}", self.host_and_port)
    }
}

/// The result of `connecting`; an error if the server does not answer in time.
async fn in_answer_time<T>(connecting: impl Future<Output = io::Result<T>>) -> io::Result<T> {
    timeout(ANSWER_TIME, connecting).await.unwrap_or_else(|_| Err(ErrorKind::TimedOut.into()))
}

/// An open connection. While its bytes are not read, the server must wait.
#[derive(Debug)]
pub struct TcpConnection {
    name: String,
    stream: TcpStream,
    buffer: BytesMut,
    clock: Clock,
}

impl Source for TcpConnection {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        self.buffer.reserve(READ_BYTES);
        let n = self.stream.read_buf(&mut self.buffer).await?;
        let at_ns = Some(self.clock.now_ns());
        Ok((n > 0).then(|| Chunk { bytes: self.buffer.split().freeze(), at_ns }.into()))
    }
}

impl Connection for TcpConnection {
    fn name(&self) -> &str {
        &self.name
    }

    fn set_baud(&mut self, _baud: u32) -> io::Result<()> {
        Err(io::Error::new(ErrorKind::Unsupported, "the serial server sets its own baud rate"))
    }

    async fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes).await.map_err(|error| match error.kind() {
            // for a socket the error means that the server has hung up; for a port, that it was
            // unplugged
            ErrorKind::BrokenPipe => ErrorKind::ConnectionReset.into(),
            _ => error,
        })
    }

    async fn close(mut self) -> Vec<StreamInput> {
        // the socket is closed when it is dropped, with or without a shutdown
        let _ = self.stream.shutdown().await;
        // no input waits, because each read is forwarded at once
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use tokio::net::TcpListener;

    use super::*;

    #[test]
    fn addresses() {
        for good in ["tcp://sensor.local:2000", "tcp://[::1]:2000"] {
            assert_eq!(TcpServer::new(good, Clock::start()).unwrap().name(), good);
        }
        for bad in ["tcp://sensor.local", "tcp://:2000", "tcp://host:0", "tcp://host:70000", "host:2000"] {
            let error = TcpServer::new(bad, Clock::start()).unwrap_err();
            assert!(error.to_string().starts_with(bad), "{error}");
        }
    }

    #[tokio::test]
    async fn bytes_pass_in_both_directions_and_the_end_is_reported() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = format!("tcp://{}", listener.local_addr().unwrap());
        let mut server = TcpServer::new(&address, Clock::start()).unwrap();
        let (connection, accepted) = tokio::join!(server.open(0), listener.accept());
        let (mut connection, (mut far, _)) = (connection.unwrap(), accepted.unwrap());

        let sent_ns = server.now_ns();
        far.write_all(b"$VNYMR").await.unwrap();
        let Some(StreamInput::Chunk(chunk)) = connection.next_input().await.unwrap() else { panic!("no chunk") };
        assert_eq!(&chunk.bytes[..], b"$VNYMR");
        assert!((sent_ns..=server.now_ns()).contains(&chunk.at_ns.unwrap()), "by the clock of the server");

        connection.write(b"$VNRRG,01*72\r\n").await.unwrap();
        let mut command = [0; 14];
        far.read_exact(&mut command).await.unwrap();
        assert_eq!(&command, b"$VNRRG,01*72\r\n");

        let refused = connection.set_baud(9600).unwrap_err();
        assert!(refused.to_string().contains("the serial server sets its own"), "{refused}");

        drop(far);
        assert_eq!(connection.next_input().await.unwrap(), None);
        connection.close().await;
    }

    #[tokio::test]
    async fn a_server_that_is_not_there_is_named() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = format!("tcp://{}", listener.local_addr().unwrap());
        drop(listener);
        let error = TcpServer::new(&address, Clock::start()).unwrap().open(0).await.unwrap_err();
        let message = error.to_string();
        assert!(message.contains(&address) && message.contains("start the serial server"), "{message}");
    }

    #[tokio::test(start_paused = true)]
    async fn a_server_that_does_not_answer_is_given_up() {
        let begin = tokio::time::Instant::now();
        let error = in_answer_time(std::future::pending::<io::Result<()>>()).await.unwrap_err();
        assert_eq!((error.kind(), begin.elapsed()), (ErrorKind::TimedOut, ANSWER_TIME));
        let message = ConnectError::Server { address: "tcp://sensor:2000".into(), error }.to_string();
        assert_eq!(
            message,
            "cannot connect to tcp://sensor:2000: no answer: check that the server is on and in this network"
        );
    }
}
