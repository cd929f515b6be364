//! Disks that are full, and disks that are slow.

use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering},
    mpsc::Receiver,
};

use super::*;
use crate::RecordingReader;
use vn100_protocol::stream::{LinkEvent, LinkEventKind};

/// A disk with little room, in memory.
#[derive(Clone, Default)]
struct Disk {
    room: usize,
    /// Room appears as soon as the disk was full.
    freed: bool,
    /// Bytes in all its files.
    used: Arc<AtomicUsize>,
    file: Arc<Mutex<Vec<u8>>>,
}

impl Disk {
    /// The same disk with another file.
    fn next_file(&self) -> Self {
        Self { file: Arc::default(), ..self.clone() }
    }
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut file = self.file.lock().unwrap();
        let taken = bytes.len().min(self.room - self.used.load(Ordering::Relaxed));
        file.extend_from_slice(&bytes[..taken]);
        self.used.fetch_add(taken, Ordering::Relaxed);
        if taken > 0 {
            return Ok(taken);
        }
        if self.freed {
            self.room = usize::MAX;
        }
        Err(ErrorKind::StorageFull.into())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A disk that needs one token for each write.
struct SlowDisk(Receiver<()>, Disk);

impl Write for SlowDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // a disk whose gate was dropped is fast
        let _ = self.0.recv();
        self.1.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A read every 100 ms.
fn read(number: i64) -> StreamInput {
    Chunk { bytes: format!("read {number};").into(), at_ns: Some(number * 100_000_000) }.into()
}

/// Reads that are written together.
fn near_read(number: i64) -> StreamInput {
    Chunk { bytes: format!("read {number};").into(), at_ns: Some(number * 20_000_000) }.into()
}

/// A read of a pipe.
fn read_without_time(number: i64) -> StreamInput {
    Chunk { bytes: format!("read {number};").into(), at_ns: None }.into()
}

fn replay(disk: &Disk) -> Vec<StreamInput> {
    let file = disk.file.lock().unwrap().clone();
    let mut reader = RecordingReader::open(&file[..]).unwrap();
    std::iter::from_fn(|| reader.next_input().unwrap()).collect()
}

fn start<W: Write + Send + 'static>(out: W) -> io::Result<Recorder> {
    start_in_parts(out, None)
}

fn start_in_parts<W: Write + Send + 'static>(out: W, next_part: Option<NextPart<W>>) -> io::Result<Recorder> {
    Recorder::start(Path::new("x.mcap"), RecordingWriter::new(out, &BTreeMap::new())?, |_| Ok(()), next_part)
}

#[tokio::test]
async fn a_full_disk_stops_the_recording_and_keeps_what_it_took() {
    for form in [read, near_read, read_without_time] {
        let reads: Vec<StreamInput> = (0..40).map(form).collect();
        let (mut whole, mut cut, mut unended) = (0, 0, 0);
        for (room, freed) in (0..3000).flat_map(|room| [(room, false), (room, true)]) {
            let disk = Disk { room, freed, ..Disk::default() };
            let Ok(recorder) = start(disk.clone()) else { continue };
            for read in &reads {
                // fails once the recording has stopped, as for any link
                let _ = recorder.inputs().send(read.clone()).await;
            }
            let state = recorder.finish("done").await;
            let kept = replay(&disk);
            assert_eq!(kept, reads[..kept.len()], "room for {room} bytes");
            let stored: usize = kept.iter().map(length).sum();
            assert!(state.ended && state.bytes <= stored as u64, "room for {room} bytes: {state:?}");
            match state.error.as_ref().map(|error| error.kind()) {
                None => {
                    assert_eq!(kept.len(), reads.len());
                    whole += 1;
                }
                Some(ErrorKind::StorageFull) if kept.len() < reads.len() => cut += 1,
                Some(ErrorKind::StorageFull) => unended += 1,
                Some(other) => panic!("{other}"),
            }
        }
        assert!(whole > 0 && cut > 0 && unended > 0, "{whole} whole, {cut} cut, {unended} without an end");
    }
}

#[tokio::test]
async fn a_full_disk_stops_a_recording_in_parts_and_keeps_what_it_took() {
    for form in [read, near_read, read_without_time] {
        let reads: Vec<StreamInput> = (0..40).map(form).collect();
        let (mut whole, mut cut, mut most_parts) = (0, 0, 0);
        for room in (0..9000).step_by(3) {
            let first = Disk { room, ..Disk::default() };
            let parts = Arc::new(Mutex::new(vec![first.clone()]));
            let (all, mut in_part) = (Arc::clone(&parts), 0);
            let next_part = move |_: &StreamInput| {
                in_part = in_part % 10 + 1;
                let mut all = all.lock().unwrap();
                if in_part < 10 {
                    return None;
                }
                let part = all[0].next_file();
                all.push(part.clone());
                let begun = RecordingWriter::new(part, &BTreeMap::new());
                Some(begun.map(|writer| (format!("{}.mcap", all.len()).into(), writer)))
            };
            let Ok(recorder) = start_in_parts(first, Some(Box::new(next_part))) else { continue };
            for read in &reads {
                let _ = recorder.inputs().send(read.clone()).await;
            }
            let state = recorder.finish("done").await;
            let parts = parts.lock().unwrap();
            let is_begun = |part: &&Disk| RecordingReader::open(&part.file.lock().unwrap()[..]).is_ok();
            let kept: Vec<StreamInput> = parts.iter().filter(is_begun).flat_map(replay).collect();
            assert_eq!(kept, reads[..kept.len()], "room for {room} bytes in {} parts", parts.len());
            match state.error {
                None => {
                    assert_eq!(kept.len(), reads.len());
                    whole += 1;
                }
                Some(error) => {
                    assert_eq!(error.kind(), ErrorKind::StorageFull);
                    cut += 1;
                }
            }
            most_parts = most_parts.max(parts.len());
        }
        assert!(whole > 0 && cut > 0 && most_parts == 5, "{whole} whole, {cut} cut, {most_parts} parts");
    }
}

#[tokio::test]
async fn all_before_a_part_that_cannot_begin_is_kept_and_counted() {
    let disk = Disk { room: usize::MAX, ..Disk::default() };
    let mut inputs = 0;
    let next_part = move |_: &StreamInput| {
        inputs += 1;
        (inputs == 10).then(|| Err(ErrorKind::AlreadyExists.into()))
    };
    let recorder = start_in_parts(disk.clone(), Some(Box::new(next_part))).unwrap();
    // within less than the time between two flushes
    let reads: Vec<StreamInput> = (0..20).map(near_read).collect();
    for read in &reads {
        let _ = recorder.inputs().send(read.clone()).await;
    }
    let state = recorder.finish("done").await;
    assert_eq!(state.error.unwrap().kind(), ErrorKind::AlreadyExists);
    assert_eq!(replay(&disk), reads[..9]);
    assert_eq!(state.bytes, reads[..9].iter().map(length).sum::<usize>() as u64);
}

#[tokio::test]
async fn a_record_that_a_full_disk_tore_is_never_repaired_with_something_else() {
    // more than the buffer holds within a second, so that a write fails in the middle of a record
    for length in 60..160 {
        let read = |number: u8| StreamInput::from(Chunk { bytes: vec![number; length].into(), at_ns: Some(0) });
        let reads: Vec<StreamInput> = (0..1000).map(|number| read((number % 251) as u8)).collect();
        let disk = Disk { room: 50_000, freed: true, ..Disk::default() };
        let recorder = start(disk.clone()).unwrap();
        for read in &reads {
            let _ = recorder.inputs().send(read.clone()).await;
        }
        assert!(recorder.finish("done").await.error.is_some());
        let kept = replay(&disk);
        assert!(!kept.is_empty() && kept[..] == reads[..kept.len()], "reads of {length} bytes: {} kept", kept.len());
    }
}

fn length(input: &StreamInput) -> usize {
    match input {
        StreamInput::Chunk(chunk) => chunk.bytes.len(),
        StreamInput::Link(_) => 0,
    }
}

#[tokio::test]
async fn what_a_slow_disk_does_not_take_is_reported_in_the_file() {
    let (gate, tokens) = std::sync::mpsc::channel();
    let disk = Disk { room: usize::MAX, ..Disk::default() };
    // the head of the file is written
    gate.send(()).unwrap();
    let recorder = start(SlowDisk(tokens, disk.clone())).unwrap();
    let inputs = recorder.inputs();
    let (mut sent, mut lost) = (0, 0);
    for read in (0..WAITING_INPUTS as i64 + 2000).map(read) {
        sent += length(&read);
        if let Err(error) = inputs.try_send(read) {
            lost += length(&error.into_inner()) as u64;
        }
    }
    assert!(lost > 0, "few are written");
    drop(gate);
    let overrun = LinkEvent { at_ns: 300_000_000_000, kind: LinkEventKind::Overrun { bytes: lost } };
    inputs.send(StreamInput::Link(overrun)).await.unwrap();
    drop(inputs);
    let state = recorder.finish("done").await;
    assert!(state.error.is_none());
    let mut reported_lost = 0;
    let kept: usize = replay(&disk)
        .iter()
        .map(|input| {
            if let StreamInput::Link(LinkEvent { kind: LinkEventKind::Overrun { bytes }, .. }) = input {
                reported_lost += bytes;
            }
            length(input)
        })
        .sum();
    assert_eq!((reported_lost, kept), (lost, sent - usize::try_from(lost).unwrap()));
    assert_eq!(state.bytes, kept as u64);
}
