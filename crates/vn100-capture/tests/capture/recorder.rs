//! Recorders and their files: created, flushed, finished, resumed.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use tempfile::TempDir;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use vn100_capture::{Capture, CaptureOptions, Event, RecordError, Recorded, Recorder, RecordingReader, Rotation};
use vn100_protocol::stream::{Chunk, LinkEvent, LinkEventKind, ReadOptions, StreamInput};

const SECOND_NS: i64 = 1_000_000_000;

fn place() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("day.mcap");
    (folder, path)
}

fn conditions(operator: &str) -> BTreeMap<String, String> {
    [("operator".into(), operator.into())].into()
}

fn read(at_ns: i64) -> StreamInput {
    Chunk { bytes: format!("read at {at_ns};").into(), at_ns: Some(at_ns) }.into()
}

fn link(at_ns: i64, kind: LinkEventKind) -> StreamInput {
    StreamInput::Link(LinkEvent { at_ns, kind })
}

fn down(at_ns: i64, cause: &str) -> StreamInput {
    link(at_ns, LinkEventKind::Down { cause: cause.into() })
}

fn replay(path: &Path) -> (Vec<StreamInput>, Recorded) {
    let mut reader = RecordingReader::open(fs::File::open(path).unwrap()).unwrap();
    let inputs = std::iter::from_fn(|| reader.next_input().unwrap()).collect();
    (inputs, reader.recorded().clone())
}

async fn record(recorder: Recorder, inputs: &[StreamInput], reason: &str) {
    for input in inputs {
        recorder.inputs().send(input.clone()).await.unwrap();
    }
    let state = recorder.finish(reason).await;
    assert!(state.ended && state.error.is_none(), "{state:?}");
}

fn files(folder: &TempDir) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<String> = fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

#[tokio::test]
async fn recorded_inputs_are_in_the_file() {
    let (_folder, path) = place();
    let inputs = [read(5), down(6, "unplugged"), read(SECOND_NS), read(7)];
    record(Recorder::create(&path, &conditions("me")).unwrap(), &inputs, "stopped").await;
    let (read, recorded) = replay(&path);
    assert_eq!((&read[..], recorded.started_ns, &recorded.metadata), (&inputs[..], Some(5), &conditions("me")));
    let end = recorded.end.get().unwrap();
    assert_eq!((end.complete, end.reason.as_deref(), end.ended_ns), (true, Some("stopped"), Some(7)));
}

#[tokio::test]
async fn each_second_of_stream_and_each_event_is_flushed() {
    let (_folder, path) = place();
    let recorder = Recorder::create(&path, &conditions("me")).unwrap();
    assert_eq!(replay(&path).1.metadata, conditions("me"), "what was given is there from the start");
    let mut state = recorder.state();
    let mut sent = Vec::new();
    let mut bytes = 0;
    for (input, flushed) in [
        (read(0), false),
        (read(SECOND_NS - 1), false),
        (read(SECOND_NS), true),
        (read(3 * SECOND_NS), false),
        (link(3 * SECOND_NS + 1, LinkEventKind::Overrun { bytes: 1 }), true),
        (read(4 * SECOND_NS), false),
        // a clock was set back
        (read(2 * SECOND_NS), true),
    ] {
        recorder.inputs().send(input.clone()).await.unwrap();
        if let StreamInput::Chunk(chunk) = &input {
            bytes += chunk.bytes.len() as u64;
        }
        sent.push(input);
        if flushed {
            state.wait_for(|state| state.bytes == bytes).await.unwrap();
            let (read, recorded) = replay(&path);
            assert_eq!(read, sent);
            assert!(!recorded.end.get().unwrap().complete);
        }
    }
    drop(recorder);
}

#[tokio::test]
async fn no_file_is_replaced() {
    let (folder, path) = place();
    fs::write(&path, "mine").unwrap();
    let error = Recorder::create(&path, &BTreeMap::new()).unwrap_err();
    assert!(matches!(error, RecordError::Exists { .. }), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    #[cfg(unix)]
    {
        let link = folder.path().join("link.mcap");
        std::os::unix::fs::symlink(folder.path().join("elsewhere"), &link).unwrap();
        assert!(matches!(Recorder::create(&link, &BTreeMap::new()), Err(RecordError::Exists { .. })));
        assert_eq!(files(&folder), ["day.mcap", "link.mcap"]);
    }
}

/// Each name that cannot be recorded to, in a file, in parts and resumed, with the cure in words.
#[tokio::test]
async fn a_name_without_a_place_is_refused_with_its_cure() {
    let (folder, _) = place();
    let nowhere = folder.path().join("none");
    let missing = format!("there is no folder {}: create it, or choose another name", nowhere.display());
    let none = BTreeMap::new();
    let parts = Recorder::in_parts(nowhere.join("a.mcap"), &none, Rotation::Bytes(1000), false);
    assert_eq!(parts.unwrap_err().to_string(), missing);
    for (path, said) in [
        (nowhere.join("a.mcap"), missing),
        (folder.path().to_owned(), format!("{} is not a file: choose another name", folder.path().display())),
        #[cfg(unix)]
        ("/dev/null".into(), "/dev/null is not a file: choose another name".into()),
    ] {
        assert_eq!(Recorder::create(&path, &none).unwrap_err().to_string(), said);
        assert_eq!(Recorder::resume(&path, &none).unwrap_err().to_string(), said);
    }
}

#[tokio::test]
async fn a_complete_recording_continues_after_a_break() {
    let (folder, path) = place();
    record(Recorder::create(&path, &conditions("me")).unwrap(), &[read(5), read(6)], "stopped").await;
    fs::write(folder.path().join(".day.mcap.resuming"), "left by a program that was killed").unwrap();
    record(Recorder::resume(&path, &conditions("you")).unwrap(), &[read(9)], "stopped again").await;
    let (inputs, recorded) = replay(&path);
    assert_eq!(inputs, [read(5), read(6), down(6, "recording ended (stopped) and resumed"), read(9)]);
    assert_eq!((recorded.started_ns, &recorded.metadata), (Some(5), &conditions("me")));
    assert_eq!(recorded.end.get().unwrap().reason.as_deref(), Some("stopped again"));
    assert_eq!(files(&folder), ["day.mcap"]);

    // the reason of the first end is not the reason of a later cut
    let whole = fs::read(&path).unwrap();
    let mut cuts = (0..whole.len()).rev().map(|cut| {
        fs::write(&path, &whole[..cut]).unwrap();
        replay(&path)
    });
    let (_, recorded) =
        cuts.find(|(inputs, recorded)| inputs.len() == 4 && recorded.end.get().unwrap().reason.is_none()).unwrap();
    assert!(!recorded.end.get().unwrap().complete);
}

#[tokio::test]
async fn a_resumed_recording_names_its_sensor() {
    let (_folder, path) = place();
    let said = |bytes: &'static str| StreamInput::from(Chunk { bytes: bytes.into(), at_ns: Some(5) });
    // complete in two reads
    let inputs = [said("$VNRRG,03,0100012345*5C\r\n$VNRRG,03,01000"), said("99887*5A\r\n")];
    let recorder = Recorder::create(&path, &conditions("me")).unwrap();
    assert_eq!(recorder.known_serial(), None);
    record(recorder, &inputs, "stopped").await;
    let recorder = Recorder::resume(&path, &conditions("me")).unwrap();
    assert_eq!(recorder.known_serial(), Some("0100099887"));
    record(recorder, &[], "stopped").await;
}

#[tokio::test]
async fn a_resumed_recording_in_parts_names_the_sensor_of_its_first_part() {
    let (folder, path) = place();
    let begin = || Recorder::in_parts(&path, &conditions("me"), Rotation::Bytes(20), true).unwrap();
    let reply = Chunk { bytes: "$VNRRG,03,0100099887*5A\r\n".into(), at_ns: Some(5) };
    record(begin(), &[reply.into(), read(6), read(7), read(8)], "stopped").await;
    assert!(files(&folder).len() > 2, "{:?}", files(&folder));
    assert_eq!(begin().known_serial(), Some("0100099887"));
}

#[tokio::test]
async fn a_cut_recording_resumes_wherever_it_was_cut() {
    let (_folder, path) = place();
    // each is in a message of its own
    let before = [read(5), read(100_000_006), read(200_000_007)];
    record(Recorder::create(&path, &conditions("me")).unwrap(), &before, "stopped").await;
    let whole = fs::read(&path).unwrap();
    let mut interrupted = 0;
    for cut in (0..whole.len()).rev().step_by(7) {
        fs::write(&path, &whole[..cut]).unwrap();
        record(Recorder::resume(&path, &conditions("you")).unwrap(), &[read(300_000_009)], "stopped again").await;
        let (mut inputs, _) = replay(&path);
        assert_eq!(inputs.pop(), Some(read(300_000_009)), "cut at {cut}");
        if let Some(StreamInput::Link(event)) = inputs.pop() {
            interrupted += usize::from(event.kind == LinkEventKind::Down { cause: "recording interrupted".into() });
        }
        assert_eq!(inputs, before[..inputs.len()], "cut at {cut}");
    }
    assert!(interrupted > 10, "{interrupted}");
}

#[tokio::test]
async fn one_call_begins_a_recording_and_resumes_it_however_it_was_cut() {
    let (folder, path) = place();
    let begin = || Recorder::resume(&path, &conditions("me")).unwrap();
    let first = begin();
    assert!(!first.is_resumed());
    record(first, &[read(5)], "stopped").await;
    let whole = fs::read(&path).unwrap();
    for cut in (0..whole.len()).rev().step_by(7) {
        fs::write(&path, &whole[..cut]).unwrap();
        let recorder = begin();
        let is_resumed = recorder.is_resumed();
        record(recorder, &[read(300_000_009)], "stopped again").await;
        let (inputs, _) = replay(&path);
        assert_eq!(inputs.last(), Some(&read(300_000_009)), "cut at {cut}");
        assert!(is_resumed || inputs.len() == 1, "cut at {cut}");
        assert_eq!(files(&folder), ["day.mcap"]);
    }
    // the beginning of a recording by another program is not replaced either
    let mut other = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    other.add_channel(0, "/camera", "application/octet-stream", &BTreeMap::new()).unwrap();
    other.finish().unwrap();
    let whole = fs::read(&path).unwrap();
    // before its 32nd byte it could be a file of any program
    for cut in (32..whole.len()).step_by(3) {
        fs::write(&path, &whole[..cut]).unwrap();
        let error = Recorder::resume(&path, &BTreeMap::new()).unwrap_err();
        assert!(matches!(error, RecordError::NotResumable { .. }), "{error}");
        assert_eq!(fs::read(&path).unwrap(), &whole[..cut], "cut at {cut}");
    }
    // content that is no beginning of a recording is not replaced
    for content in ["$VNYMR,-085", "\u{89}"] {
        fs::write(&path, content).unwrap();
        let error = Recorder::resume(&path, &BTreeMap::new()).unwrap_err();
        assert!(matches!(error, RecordError::NotResumable { .. }), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), content);
    }
}

#[tokio::test]
async fn other_files_are_not_touched() {
    let (folder, path) = place();
    let content = "$VNYMR,-085";
    fs::write(&path, content).unwrap();
    let error = Recorder::resume(&path, &BTreeMap::new()).unwrap_err();
    assert!(matches!(error, RecordError::NotResumable { .. }), "{error}");
    assert!(error.to_string().ends_with("it is no MCAP file"), "{error}");
    assert_eq!((fs::read_to_string(&path).unwrap(), files(&folder)), (content.into(), vec!["day.mcap".into()]));
    let content = {
        let mut capture = vn100_capture::RecordingWriter::new(Vec::new(), &BTreeMap::new()).unwrap();
        capture.write(&read(0)).unwrap();
        capture.finish(None).unwrap()
    };
    fs::write(&path, &content).unwrap();
    let error = Recorder::resume(&path, &BTreeMap::new()).unwrap_err();
    assert!(error.to_string().contains("its times count from zero"), "{error}");
    assert_eq!((fs::read(&path).unwrap(), files(&folder)), (content, vec!["day.mcap".into()]));
    let mut mixed = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    for topic in ["/vn100/bytes", "/camera"] {
        mixed.add_channel(0, topic, "application/octet-stream", &BTreeMap::new()).unwrap();
    }
    mixed.finish().unwrap();
    let content = fs::read(&path).unwrap();
    let error = Recorder::resume(&path, &BTreeMap::new()).unwrap_err().to_string();
    assert!(error.ends_with("did not record: /camera"), "{error}");
    assert_eq!((fs::read(&path).unwrap(), files(&folder)), (content, vec!["day.mcap".into()]));
    #[cfg(unix)]
    {
        let link = folder.path().join("link.mcap");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        let resumed = Recorder::resume(&link, &BTreeMap::new());
        assert!(matches!(resumed, Err(RecordError::SymbolicLink { .. })));
    }
}

#[cfg(unix)]
#[tokio::test]
async fn a_recording_that_is_removed_meanwhile_is_reported() {
    let metadata = conditions("me");
    for resumed in [false, true] {
        let (_folder, path) = place();
        record(Recorder::create(&path, &metadata).unwrap(), &[read(1)], "stopped").await;
        let recorder = if resumed {
            Recorder::resume(&path, &metadata).unwrap()
        } else {
            fs::remove_file(&path).unwrap();
            Recorder::create(&path, &metadata).unwrap()
        };
        let mut state = recorder.state();
        fs::remove_file(&path).unwrap();
        // within a second of the stream
        recorder.inputs().send(read(0)).await.unwrap();
        recorder.inputs().send(read(SECOND_NS)).await.unwrap();
        let ended = timeout(Duration::from_secs(20), state.wait_for(|state| state.ended)).await.unwrap();
        let told = ended.unwrap().error.clone().unwrap();
        assert_eq!(
            (told.kind(), told.to_string()),
            (std::io::ErrorKind::NotFound, "the file was removed while it was written".into())
        );
        assert!(recorder.finish("stopped").await.error.is_some());
        assert!(!path.exists(), "nothing else takes its place");
    }
    // the same delay at the end
    let (_folder, path) = place();
    let recorder = Recorder::create(&path, &metadata).unwrap();
    recorder.inputs().send(read(0)).await.unwrap();
    fs::remove_file(&path).unwrap();
    assert!(recorder.finish("stopped").await.error.is_some());
}

#[tokio::test]
async fn a_part_bears_its_name_only_with_its_identity() {
    let (folder, path) = place();
    let begin = || Recorder::in_parts(&path, &conditions("ada"), Rotation::Bytes(20), true);
    // a remnant of a killed program
    fs::write(folder.path().join(".day.0001.mcap.resuming"), "").unwrap();
    record(begin().unwrap(), &[read(SECOND_NS), read(2 * SECOND_NS)], "stopped").await;
    assert_eq!(files(&folder), ["day.0001.mcap", "day.0002.mcap"]);
    // the third cannot be written in advance
    fs::create_dir(folder.path().join(".day.0003.mcap.resuming")).unwrap();
    assert!(matches!(begin(), Err(RecordError::Io { .. })));
    assert_eq!(files(&folder), [".day.0003.mcap.resuming", "day.0001.mcap", "day.0002.mcap"]);
}

#[tokio::test]
async fn no_part_follows_the_one_with_the_largest_number() {
    let (folder, path) = place();
    let begin = || Recorder::in_parts(&path, &conditions("ada"), Rotation::Bytes(20), true);
    record(begin().unwrap(), &[read(SECOND_NS)], "stopped").await;
    let last = format!("day.{}.mcap", u32::MAX);
    fs::rename(folder.path().join("day.0001.mcap"), folder.path().join(&last)).unwrap();
    let error = begin().unwrap_err().to_string();
    assert!(error.contains(&last) && error.contains("choose another name"), "{error}");
    assert_eq!(files(&folder), [last]);
}

#[tokio::test]
async fn only_a_part_that_is_cut_is_a_loss_of_the_link_to_the_next() {
    let (folder, path) = place();
    let recorder = Recorder::in_parts(&path, &conditions("ada"), Rotation::Bytes(20), true).unwrap();
    record(recorder, &[1, 2, 3].map(|second| read(second * SECOND_NS)), "stopped").await;
    let [first, later @ ..] = &files(&folder).iter().map(|name| folder.path().join(name)).collect::<Vec<_>>()[..]
    else {
        panic!("no part")
    };
    assert_eq!(later.len(), 2);
    let losses = async || {
        let options = CaptureOptions { later_parts: later.to_vec(), ..CaptureOptions::default() };
        let capture = Capture::open(first, &options).unwrap();
        let mut events = capture.read(ReadOptions::default(), CancellationToken::new()).unwrap();
        let mut losses = Vec::new();
        while let Some(event) = events.recv().await {
            if let Event::Link(LinkEvent { at_ns, kind: LinkEventKind::Down { cause } }) = event {
                losses.push((at_ns, cause));
            }
        }
        losses
    };
    assert_eq!(losses().await, []);
    let whole = fs::read(first).unwrap();
    let read_first = b"read at 1000000000;";
    let end = whole.windows(read_first.len()).position(|bytes| bytes == read_first).unwrap() + read_first.len();
    fs::write(first, &whole[..end]).unwrap();
    assert_eq!(losses().await, [(SECOND_NS, "part 1 of the recording is cut".to_owned())]);
}

#[tokio::test]
async fn a_part_that_cannot_be_read_is_named() {
    let (folder, path) = place();
    let recorder = Recorder::in_parts(&path, &conditions("ada"), Rotation::Bytes(20), true).unwrap();
    record(recorder, &[1, 2].map(|second| read(second * SECOND_NS)), "stopped").await;
    let [first, later] = ["day.0001.mcap", "day.0002.mcap"].map(|name| folder.path().join(name));
    for is_there in [true, false] {
        if is_there {
            fs::write(&later, "no part").unwrap();
        } else {
            fs::remove_file(&later).unwrap();
        }
        let options = CaptureOptions { later_parts: vec![later.clone()], ..CaptureOptions::default() };
        let capture = Capture::open(&first, &options).unwrap();
        let mut events = capture.read(ReadOptions::default(), CancellationToken::new()).unwrap();
        let mut failure = None;
        while let Some(event) = events.recv().await {
            if let Event::End(end) = event {
                failure = end.error.map(|error| error.to_string());
            }
        }
        let failure = failure.unwrap();
        assert!(failure.contains("day.0002.mcap"), "{failure}");
    }
}
