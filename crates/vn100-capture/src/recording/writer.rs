//! Writes a recording.

use std::{
    collections::BTreeMap,
    io::{self, BufWriter, Write},
};

use mcap::{
    McapResult, WriteOptions, Writer,
    records::{MessageHeader, Metadata},
    write::NoSeek,
};

use super::{
    BYTES_ENCODING, BYTES_TOPIC, CALLER_METADATA, END_METADATA, FORMAT, LINK_ENCODING, LINK_TOPIC, PROFILE,
    READS_ENCODING, READS_TOPIC, RECORDING_METADATA, UNSTAMPED, link_to_json, log_time, reads::Reads,
};
use crate::mcap_records::io_error;
use vn100_protocol::stream::{Chunk, LinkEvent, StreamInput};

const PROGRAM: &str = concat!("vn100 ", env!("CARGO_PKG_VERSION"));

/// Bytes that may stay in memory between two flushes; more are written at once.
const BUFFERED_BYTES: usize = 64 * 1024;

/// Writes [`StreamInput`]s as an MCAP file, to any writer.
///
/// Reads within 50 ms are written together. All flushed inputs can be replayed, even if the file is
/// cut later. After an error nothing more is written, and the file is a recording that was cut.
///
/// ```
/// use vn100_capture::{RecordingReader, RecordingWriter};
/// use vn100_protocol::stream::{Chunk, StreamInput};
///
/// let read = StreamInput::Chunk(Chunk { bytes: "$VNYMR,".into(), at_ns: Some(1_700_000_000_000_000_000) });
/// let mut recording = RecordingWriter::new(Vec::new(), &[("operator".into(), "me".into())].into())?;
/// recording.write(&read)?;
/// let file = recording.finish(Some("done"))?;
///
/// let mut replay = RecordingReader::open(&file[..])?;
/// assert_eq!(replay.next_input()?, Some(read));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct RecordingWriter<W: Write> {
    /// `None` after an error.
    mcap: Option<Writer<NoSeek<BufWriter<W>>>>,
    bytes_channel: u16,
    reads_channel: u16,
    link_channel: u16,
    /// The reads that are not written yet.
    reads: Reads,
    messages: u32,
    last_ns: i64,
}

impl<W: Write> RecordingWriter<W> {
    /// Starts a recording and flushes its head; `metadata` is the information about the recording
    /// for a replay, under names of the caller's choice.
    ///
    /// # Errors
    /// The first error of `out`.
    pub fn new(out: W, metadata: &BTreeMap<String, String>) -> io::Result<Self> {
        Self::begin(out, &head(metadata))
    }

    /// Writes an input after the earlier ones. The times need not ascend.
    ///
    /// # Errors
    /// The first error of the writer; every call after it fails as well.
    pub fn write(&mut self, input: &StreamInput) -> io::Result<()> {
        match input {
            StreamInput::Chunk(Chunk { bytes, at_ns: Some(at_ns) }) => {
                if !self.reads.takes(*at_ns, bytes) {
                    self.write_reads()?;
                }
                self.reads.push(*at_ns, bytes);
                match self.mcap.is_some() {
                    true if self.reads.is_full() => self.write_reads(),
                    true => Ok(()),
                    false => Err(stopped()),
                }
            }
            StreamInput::Chunk(Chunk { bytes, at_ns: None }) => {
                self.write_reads()?;
                let unstamped = BTreeMap::from([(UNSTAMPED.0.into(), UNSTAMPED.1.into())]);
                let channel = self.put(|mcap| mcap.add_channel(0, BYTES_TOPIC, BYTES_ENCODING, &unstamped))?;
                self.write_message(channel, self.last_ns, bytes)
            }
            StreamInput::Link(LinkEvent { at_ns, kind }) => {
                self.write_reads()?;
                self.write_message(self.link_channel, *at_ns, &link_to_json(kind))
            }
        }
    }

    /// Flushes the writer, so that the system has all that was written.
    ///
    /// # Errors
    /// As [`RecordingWriter::write`].
    pub fn flush(&mut self) -> io::Result<()> {
        self.write_reads()?;
        self.put(Writer::flush)
    }

    /// Ends the recording, with the reason if it is known, and returns the flushed writer. A
    /// recording that is dropped without this is ended as well, but its errors are lost.
    ///
    /// # Errors
    /// As [`RecordingWriter::write`].
    pub fn finish(mut self, reason: Option<&str>) -> io::Result<W> {
        self.write_reads()?;
        if let Some(reason) = reason {
            self.put_metadata(&[Metadata {
                name: END_METADATA.into(),
                metadata: [("reason".into(), reason.into())].into(),
            }])?;
        }
        self.put(|mcap| mcap.finish().map(drop))?;
        let mcap = self.mcap.take().ok_or_else(stopped)?;
        mcap.into_inner().into_inner().into_inner().map_err(io::IntoInnerError::into_error)
    }

    /// Begins a recording with all metadata before its first message.
    pub(super) fn begin(out: W, head: &[Metadata]) -> io::Result<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .use_chunks(false)
            .disable_seeking(true)
            .profile(PROFILE)
            .library(format!("{PROGRAM}, {}", mcap::LIBRARY_IDENTIFIER));
        let out = NoSeek::new(BufWriter::with_capacity(BUFFERED_BYTES, out));
        let mcap = Some(options.create(out).map_err(io_error)?);
        let mut writer = Self {
            mcap,
            bytes_channel: 0,
            reads_channel: 0,
            link_channel: 0,
            reads: Reads::default(),
            messages: 0,
            last_ns: 0,
        };
        writer.put_metadata(head)?;
        writer.bytes_channel = writer.put(|mcap| mcap.add_channel(0, BYTES_TOPIC, BYTES_ENCODING, &BTreeMap::new()))?;
        writer.reads_channel = writer.put(|mcap| mcap.add_channel(0, READS_TOPIC, READS_ENCODING, &BTreeMap::new()))?;
        writer.link_channel = writer.put(|mcap| mcap.add_channel(0, LINK_TOPIC, LINK_ENCODING, &BTreeMap::new()))?;
        writer.flush()?;
        Ok(writer)
    }

    pub(super) fn put_metadata(&mut self, metadata: &[Metadata]) -> io::Result<()> {
        self.write_reads()?;
        metadata.iter().try_for_each(|metadata| self.put(|mcap| mcap.write_metadata(metadata)))
    }

    fn write_reads(&mut self) -> io::Result<()> {
        let Some((at_ns, are_several, data)) = self.reads.take() else { return Ok(()) };
        self.write_message(if are_several { self.reads_channel } else { self.bytes_channel }, at_ns, &data)
    }

    fn write_message(&mut self, channel_id: u16, at_ns: i64, data: &[u8]) -> io::Result<()> {
        let time = log_time(at_ns);
        let header = MessageHeader { channel_id, sequence: self.messages, log_time: time, publish_time: time };
        self.messages = self.messages.wrapping_add(1);
        self.last_ns = at_ns;
        self.put(|mcap| mcap.write_to_known_channel(&header, data))
    }

    fn put<T>(&mut self, write: impl FnOnce(&mut Writer<NoSeek<BufWriter<W>>>) -> McapResult<T>) -> io::Result<T> {
        let mcap = self.mcap.as_mut().ok_or_else(stopped)?;
        let result = write(mcap);
        if result.is_err() {
            // if it were dropped, it would write its end after half a record
            self.mcap.take().map(Writer::into_inner);
        }
        result.map_err(io_error)
    }
}

impl<W: Write> Drop for RecordingWriter<W> {
    fn drop(&mut self) {
        // the error is lost with the writer
        let _ = self.write_reads();
    }
}

/// The metadata before the first message of a recording by this program.
pub(super) fn head(metadata: &BTreeMap<String, String>) -> Vec<Metadata> {
    let about = [("format".into(), FORMAT.into()), ("program".into(), PROGRAM.into())];
    let about = Metadata { name: RECORDING_METADATA.into(), metadata: about.into() };
    let given = Metadata { name: CALLER_METADATA.into(), metadata: metadata.clone() };
    if metadata.is_empty() { vec![about] } else { vec![about, given] }
}

fn stopped() -> io::Error {
    io::Error::other("the recording stopped at an earlier error")
}
