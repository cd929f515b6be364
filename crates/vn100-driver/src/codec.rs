//! The parser as a `tokio_util` codec, for users of this library who hold an `AsyncRead` instead of
//! a [`Source`](crate::Source).

use std::io;

use bytes::{Buf, Bytes, BytesMut};
use vn100_protocol::{BadKind, Decoder, Imu, Item, Options, Tally, Ymr};

/// For programs of their own that read a sensor with tokio: decodes a byte stream into [`Decoded`]
/// items.
///
/// Bad lines are items: the codec's only errors are those of the reader around it, so that a
/// `FramedRead` ends when its reader does and never before.
///
/// ```
/// use tokio_stream::StreamExt;
/// use tokio_util::codec::FramedRead;
/// use vn100_driver::{Decoded, SentenceCodec};
///
/// # #[tokio::main(flavor = "current_thread")] async fn main() -> Result<(), std::io::Error> {
/// let bytes = &b"noise$VNYPR,-129.867,-000.355,-000.296*61\r\n$VNYPR,-12"[..];
/// let mut items = FramedRead::new(bytes, SentenceCodec::default());
/// assert!(matches!(items.next().await.transpose()?, Some(Decoded::Other(_))));
/// assert!(matches!(items.next().await.transpose()?, Some(Decoded::Bad { offset: 43, .. })));
/// assert!(items.next().await.is_none());
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct SentenceCodec {
    decoder: Decoder,
}

/// What [`SentenceCodec`] gives to programs of their own: an item of the stream that owns its
/// bytes.
#[derive(Debug, Clone, PartialEq)]
pub enum Decoded {
    /// A `$VNYMR` measurement.
    Ymr(Ymr),
    /// A `$VNIMU` measurement.
    Imu(Imu),
    /// A reply to a command: the whole sentence.
    Reply(Bytes),
    /// Any other good sentence.
    Other(Bytes),
    /// A binary packet.
    Packet(Bytes),
    /// A line that was not let in.
    Bad {
        /// What is wrong with it.
        kind: BadKind,
        /// Its bytes.
        raw: Bytes,
        /// Place of its `$` in the stream.
        offset: u64,
    },
}

impl SentenceCodec {
    /// A codec at the beginning of a stream.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { decoder: Decoder::new(options) }
    }

    /// What has passed so far.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    fn step(&mut self, bytes: &mut BytesMut, end: bool) -> Option<Decoded> {
        let (consumed, item) = self.decoder.next(bytes, end);
        let own = Bytes::copy_from_slice;
        let item = item.map(|item| match item {
            Item::Ymr(ymr) => Decoded::Ymr(ymr),
            Item::Imu(imu) => Decoded::Imu(imu),
            Item::Reply(sentence) => Decoded::Reply(own(sentence.raw)),
            Item::Other(sentence) => Decoded::Other(own(sentence.raw)),
            Item::Packet(packet) => Decoded::Packet(own(packet.raw)),
            Item::Bad(bad) => Decoded::Bad { kind: bad.kind, raw: own(bad.raw), offset: bad.offset },
        });
        bytes.advance(consumed);
        item
    }
}

impl Default for SentenceCodec {
    fn default() -> Self {
        Self::new(Options::default())
    }
}

impl tokio_util::codec::Decoder for SentenceCodec {
    type Item = Decoded;
    type Error = io::Error;

    fn decode(&mut self, bytes: &mut BytesMut) -> io::Result<Option<Decoded>> {
        Ok(self.step(bytes, false))
    }

    fn decode_eof(&mut self, bytes: &mut BytesMut) -> io::Result<Option<Decoded>> {
        Ok(self.step(bytes, true))
    }
}
