//! The seeds of mutations: pieces of the captures of the project, and examples of every form.

use std::{fs, io::Write, path::Path};

use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use vn100_capture::RecordingWriter;
use vn100_protocol::stream::{Chunk, LinkEvent, LinkEventKind, StreamInput};

const REPLIES: &str =
    "VNRRG,01,VN-100S-CR\nVNRRG,05,115200\nVNWRG,07,40\nVNASY,0\nVNERR,0C\nVNERR,03\nVNWNV\nVNRST\nVNTAR\nVNSGB";

/// The beginning and a middle part of each capture.
fn logs() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../replay-logs");
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.retain(|name| name.extension().is_some_and(|extension| extension == "bin" || extension == "vnymr"));
    names.sort();
    let pieces = |bytes: Vec<u8>| [bytes[..1500].to_vec(), bytes[40_000..42_500].to_vec()];
    names.into_iter().flat_map(|name| pieces(fs::read(name).unwrap())).collect()
}

fn clean() -> Vec<u8> {
    logs().swap_remove(2)
}

pub(super) fn streams() -> Vec<Vec<u8>> {
    logs().into_iter().map(|log| [&[0, 36], &log[..]].concat()).collect()
}

pub(super) fn bodies() -> Vec<Vec<u8>> {
    let measurements = [
        "VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391",
        "VNYMR,-085.46,+074.97,+063.75,-0.5551,+0.4403,+0.9048,+08.971,-02.145,-01.093,+00.0000,-00.0003,-00.0004",
        "VNYMR,-179.999,-000.000,+180.000,+09.9999,-10.0000,+00.0000,-199.999,+00.000,-00.000,+40.000000,-00.000000,-39.999999,T0000000543,S00FF",
        "VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322",
        "VNMAR,-01.0640,-00.2531,+03.0614,+00.005,+00.344,-09.758,-00.001222,-00.000450,-00.001218",
        "VNQMR,+0.004183,+0.001149,+0.089285,+0.995997,+00.0113,-00.2384,+00.1800,+00.020,-00.092,-09.683,-00.000272,+00.000824,+00.000073,T0000000543",
        "VNQMR,+0.021375,-0.049923,+0.797361,-0.601055,-0.2354,+0.8029,+1.8875,+00.795,-00.412,-09.709,-00.0201,-00.0055,-00.0149",
        "VNRRG,54,-02.0841,+00.6045,+02.8911,+00.381,-00.154,-09.657,-00.005683,+00.000262,+00.001475,+21.6,+00099.761",
    ];
    let registers = [
        "VNRRG,02,7",
        "VNRRG,03,0100014967",
        "VNRRG,04,2.0.0.0",
        "VNRRG,06,14",
        "VNRRG,21,+1.0,+0.0,+1.8,+0.0,+0.0,-9.793746",
        "VNRRG,23,1,0,0,0,1,0,0,0,1,0,0,0",
        "VNRRG,26,1,0,0,0,1,0,0,0,1",
        "VNRRG,30,0,0,0,0,1,0,1",
        "VNRRG,32,3,0,0,0,6,1,3,100000000,0",
        "VNRRG,35,1,1,1,1",
        "VNRRG,43,0,0,0",
        "VNRRG,44,1,3,5",
        "VNRRG,47,1,0,0,0,1,0,0,0,1,0,0,0",
        "VNRRG,75,3,400,01,0321",
        "VNRRG,82,0,0,0,0,0",
        "VNRRG,85,0,4,4,4,0,0,3,3,3,0",
    ];
    let all = measurements.into_iter().chain(registers).chain(REPLIES.lines());
    all.flat_map(|body| [0, 1].map(|check| [&[check], body.as_bytes()].concat())).collect()
}

pub(super) fn packets() -> Vec<Vec<u8>> {
    let floats = |count: usize| 0.125_f32.to_le_bytes().repeat(count);
    vec![
        [&[0x01, 0x08, 0x00], &floats(3)[..]].concat(),
        [&[0x05, 0x08, 0x00, 0x10, 0x00], &floats(4)[..]].concat(),
        [&[0x01, 0x09, 0x00], &floats(5)[..]].concat(),
        [&[0x17, 0xFF, 0x7F, 0xFF, 0x03, 0xFF, 0x0F, 0xFF, 0x31], &[0x24; 511][..]].concat(),
        [&[0x01, 0x09, 0x00], &b"$VNRRG,01*72\r\n$VNRRG"[..]].concat(),
    ]
}

pub(super) fn conversations() -> Vec<Vec<u8>> {
    let replies: Vec<u8> = REPLIES.lines().flat_map(|reply| [b"\x09", reply.as_bytes(), b"\n"].concat()).collect();
    let ask: Vec<u8> = (0..=255_u8).step_by(9).flat_map(|choice| [0, choice, 2]).collect();
    vec![
        [&ask[..], &replies, &[5, 60, 4, 2, 8]].concat(),
        [b"\x00\x38\x02", &b"\x09VNRRG,07,40\n"[..], b"\x00\x3a\x02\x05\x37\x04\x02\x09VNWRG,07,11\n\x08\x07"].concat(),
        [&[6, 0], &ask[..], &[7, 8], &ask, &[6, 20, 4, 2, 8]].concat(),
        [0, 4, 2, 0, 5, 2, 0, 6, 2].repeat(20),
    ]
}

pub(super) fn captures() -> Vec<Vec<u8>> {
    let mut seeds = logs();
    let sentence = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63";
    let rows = |form: fn(usize) -> String| (0..40).map(form).collect::<String>();
    seeds.push(
        format!(
            "t,gyro_x,accel_x\n{}",
            rows(|row| format!("{}.{:03},0.00{row},-9.8{row}\n", row / 40, row * 25 % 1000))
        )
        .into_bytes(),
    );
    seeds.push(format!("a;az;t\r\n{}", rows(|row| format!("{row};1.0{row};{}\r\n", row * 25_000_000))).into_bytes());
    seeds.push(
        format!("t,raw\n{}", (0..20).map(|row| format!("0.{:03},\"{sentence}\"\n", row * 25)).collect::<String>())
            .into_bytes(),
    );
    let odd = "# a comment\n\n9,1e300,nan,-0.00000000000000000000001e5,,\"1\",+,.,1e,0,0,0,0\r\n";
    seeds.push(
        format!("raw_data,t\n{odd}{}", rows(|row| format!("1761939168.{row:03},\"$VNYMR,{row}\r\n\"\r\n-3.5,{row}\n")))
            .into_bytes(),
    );
    // over telnet, with noise between the sentences
    seeds.push(format!("{sentence}\r\n").into_bytes().into_iter().chain([0xff, 0xff]).cycle().take(2000).collect());
    let recording = recording();
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(&clean()).unwrap();
    seeds.push(gzip.finish().unwrap());
    seeds.push(compress_to_vec(&clean()[..], CompressionLevel::Fastest));
    seeds.push(recording[..recording.len() / 2].to_vec());
    seeds.push(in_chunk(&recording, "", |records| records.to_vec()));
    seeds.push(in_chunk(&recording, "zstd", |records| compress_to_vec(records, CompressionLevel::Fastest)));
    seeds.push(recording);
    (0..).zip(seeds).map(|(index, seed)| [&[index, 200], &seed[..]].concat()).collect()
}

/// Bags of each form, with options and the size of reads before each.
pub(super) fn bags() -> Vec<Vec<u8>> {
    macro_rules! bag {
        ($name:literal) => {
            include_bytes!(concat!("../../../crates/vn100-capture/tests/bags/", $name)).as_slice()
        };
    }
    let bags = [
        bag!("imu_none.bag"),
        bag!("imu_bz2.bag"),
        bag!("imu_lz4.bag"),
        bag!("sentences.bag"),
        bag!("db3/db3.db3"),
        bag!("db3_message_zstd/db3_message_zstd.db3"),
        bag!("mcap/mcap.mcap"),
        bag!("mcap_storage_zstd/mcap_storage_zstd.mcap"),
    ];
    bags.map(|bag| [&[0, 200], bag].concat()).into()
}

fn recording() -> Vec<u8> {
    let mut writer = RecordingWriter::new(Vec::new(), &[("axis up".into(), "z".into())].into()).unwrap();
    let link = |at_ns, kind| StreamInput::Link(LinkEvent { at_ns, kind });
    let up = || LinkEventKind::Up { port: "/dev/ttyUSB0".into(), baud: Some(115_200) };
    writer.write(&link(0, LinkEventKind::DiscardedDuringBaudScan { bytes: 9 })).unwrap();
    writer.write(&link(1, up())).unwrap();
    for (at_ns, bytes) in (0..).step_by(25_000_000).zip(clean().chunks(100)) {
        writer.write(&Chunk { bytes: bytes.to_vec().into(), at_ns: Some(at_ns) }.into()).unwrap();
    }
    writer.write(&link(2_000_000_000, LinkEventKind::Down { cause: "unplugged".into() })).unwrap();
    writer.write(&link(2_000_000_001, up())).unwrap();
    writer.write(&link(2_000_000_002, LinkEventKind::Overrun { bytes: 3 })).unwrap();
    writer.finish(Some("the end")).unwrap()
}

/// The first records of a recording inside one chunk, without a checksum, so that damage is not
/// detected by it.
fn in_chunk(recording: &[u8], compression: &str, pack: fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let length = |bytes: &[u8]| (bytes.len() as u64).to_le_bytes();
    let (magic, records) = recording.split_at(8);
    let mut end = 0;
    while end < 1500 {
        end += 9 + u64::from_le_bytes(records[end + 1..end + 9].try_into().unwrap()) as usize;
    }
    let (records, packed) = (&records[..end], pack(&records[..end]));
    let name = [&(compression.len() as u32).to_le_bytes()[..], compression.as_bytes()].concat();
    let chunk = [&[0; 16][..], &length(records), &[0; 4], &name, &length(&packed), &packed].concat();
    [magic, &[6], &length(&chunk), &chunk, &[15], &length(&[0; 4]), &[0; 4]].concat()
}

pub(super) fn sidecars() -> Vec<Vec<u8>> {
    let rows: String =
        (0..20_u64).map(|row| format!("{},{}\n", 1_700_000_000_000_000_000 + row * 25_000_000, row * 122)).collect();
    let few = "t_ns,offset\n# by hand\n-9223372036854775808,0\n9223372036854775807,244\n";
    [&*rows, few, &rows[..200], ""].map(|rows| [rows.as_bytes(), b"\0", &clean()].concat()).into()
}

pub(super) fn options() -> Vec<Vec<u8>> {
    [
        "gyro_x=wx:deg/s,accel_z=4:g,t=time:ns\nmag_x=a=b:c:uT,temperature=T:K",
        "drop@12.5s flip@0.1%:bit6 unplug@20s+3s stale splice@2min stall@1s+100ms\nunplug@1h+1ms:other reboot@3s baud@0s:9600 badopen@50% drop@1s+2s",
        "5h\n10min\n18446744073709551615s\n1ns\n100000000y",
        "gyro N\naccel B\nmag K\ngyro_x N ±5%\ngyro B +- 20 %",
        "gyro N ±5%\ngyro B\ngyro K >= 2e-7 rad/s/sqrt(s)\naccel B >= 0.02 mg",
        "40\n0.001\n1s\n18446744073709551615s",
        "100000\n0s\n0s",
    ]
    .map(|text| text.as_bytes().to_vec())
    .into()
}
