//! From the last byte of a line to its place in the sums.
//!
//! A feeder, another process, writes whole lines or packets to pseudo-terminals and notes when; each
//! line says its number in its yaw, each packet in its device time. This process does what `attach` does, on a runtime like its own: the
//! reading thread, the task of the link, the accumulators, a snapshot every 100 ms. Both use the
//! boot-time clock. So the figure holds the way of a line through the kernel and the program, not
//! the time it takes on a wire and in an adapter.

use std::{
    env,
    hint::black_box,
    io::{self, BufRead, BufReader, Write},
    process::{ChildStdout, Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use serialport::{SerialPort, TTYPort};
use tokio::{runtime::Builder, task::JoinSet, time};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Analysis, Settings};
use vn100_capture::{Clock, Event};
use vn100_driver::{LinkOptions, SerialPorts, open_link};
use vn100_protocol::crc16;

use crate::figures;

/// The first argument of the feeder.
pub(crate) const FEED: &str = "feed";

/// What the feeder writes.
const LINES: &str = "lines";
const PACKETS: &str = "packets";

/// Frames of the beginning, while ports are opened and the rate is found out.
const SETTLING: Duration = Duration::from_secs(2);
const MEASURING: Duration = Duration::from_secs(6);

/// When a line was written or absorbed, in nanoseconds since 1970, by its number.
type Times = Vec<(u32, i64)>;

pub(crate) fn measure() {
    println!("{:<34}{:>9}{:>9}{:>9}{:>9}", "last byte to sums, microseconds", "p50", "p99", "max", "lines");
    for (ports, rate_hz, frames) in
        [(1, 40, LINES), (1, 200, LINES), (16, 200, LINES), (1, 800, PACKETS), (4, 800, PACKETS), (16, 200, PACKETS)]
    {
        let mut delays_us = delays_us(ports, rate_hz, frames);
        delays_us.sort_by(f64::total_cmp);
        let quantile = |p: f64| delays_us[(p * (delays_us.len() - 1) as f64) as usize];
        let name = format!("{ports} at {rate_hz} Hz, {frames}");
        println!("{name:<34}{:>9.0}{:>9.0}{:>9.0}{:>9}", quantile(0.5), quantile(0.99), quantile(1.0), delays_us.len());
        let values = [("p50 µs", 0.5), ("p99 µs", 0.99), ("longest µs", 1.0)]
            .map(|(name, p)| (name, format!("{:.0}", quantile(p))));
        figures::record("latency", &name, &values);
    }
}

fn delays_us(ports: usize, rate_hz: u32, frames: &str) -> Vec<f64> {
    let mut command = Command::new(env::current_exe().unwrap());
    command.args([FEED, &ports.to_string(), &rate_hz.to_string(), frames]);
    let mut feeder = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut told = BufReader::new(feeder.stdout.take().unwrap());
    let names: Vec<String> = (0..ports).map(|_| told_line(&mut told)).collect();
    let stop = CancellationToken::new();
    // as in `attach`
    let runtime = Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    let absorbed: Vec<Times> = runtime.block_on(async {
        let mut measurements = JoinSet::new();
        for (port, name) in names.into_iter().enumerate() {
            let stop = stop.clone();
            measurements.spawn(async move { (port, absorb(name, rate_hz, stop).await) });
        }
        time::sleep(SETTLING + MEASURING + Duration::from_secs(1)).await;
        stop.cancel();
        let mut absorbed = measurements.join_all().await;
        absorbed.sort_by_key(|(port, _)| *port);
        absorbed.into_iter().map(|(_, times)| times).collect()
    });
    // its ports are there until then
    drop(feeder.stdin.take());
    let mut delays_us = Vec::new();
    for absorbed in absorbed {
        let lines: u32 = told_line(&mut told).parse().unwrap();
        let written_ns: Vec<i64> = (0..lines).map(|_| told_line(&mut told).parse().unwrap()).collect();
        let settled = (SETTLING.as_secs() as u32) * rate_hz;
        let absorbed = absorbed.into_iter().filter(|(line, _)| *line >= settled);
        let delays = absorbed.map(|(line, at_ns)| (at_ns - written_ns[line as usize]) as f64 / 1e3);
        let before = delays_us.len();
        delays_us.extend(delays);
        assert_eq!(delays_us.len() - before, (lines - settled) as usize, "a line was lost");
    }
    assert!(feeder.wait().unwrap().success());
    delays_us
}

fn told_line(told: &mut BufReader<ChildStdout>) -> String {
    let mut line = String::new();
    told.read_line(&mut line).unwrap();
    line.trim_end().into()
}

/// Measures one port until told to stop: when each line was in the sums.
async fn absorb(port: String, rate_hz: u32, stop: CancellationToken) -> Times {
    let clock = Clock::start();
    let options = LinkOptions { baud: Some(921_600), listen_only: true, ..LinkOptions::default() };
    let (_link, mut events) = open_link(SerialPorts::new(&port, clock), options, stop);
    let mut analysis = Analysis::new(Settings::default());
    let mut snapshots = time::interval(Duration::from_millis(100));
    let mut absorbed = Vec::new();
    loop {
        tokio::select! {
            event = events.recv() => match event.unwrap() {
                Event::Batch(batch) => {
                    analysis.absorb(&batch);
                    let at_ns = clock.now_ns();
                    let packets = batch.device_ns.iter().map(|device_ns| (device_ns / TICK_NS) as u32 * rate_hz / 800);
                    let lines = batch.rows().map(|row| (row[0] + HALF_TURN) as u32);
                    match batch.device_ns.is_empty() {
                        true => absorbed.extend(lines.map(|number| (number, at_ns))),
                        false => absorbed.extend(packets.map(|number| (number, at_ns))),
                    }
                }
                Event::Link(event) => analysis.take_link_event(&event),
                Event::End(_) => return absorbed,
            },
            _ = snapshots.tick() => drop(black_box(analysis.snapshot())),
        }
    }
}

/// 180 degrees, in thousandths of a degree.
const HALF_TURN: i32 = 180_000;

/// A line whose yaw says its number, from 0 to 359 999.
fn line(number: u32) -> String {
    let yaw = f64::from(number as i32 - HALF_TURN) / 1000.0;
    let body = format!(
        "VNYMR,{yaw:+08.3},+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391"
    );
    let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{checksum:02X}\r\n")
}

/// From packet to packet at 800 Hz.
const TICK_NS: u64 = 1_250_000;

/// A packet whose device time says its number, without an end of a line but by chance.
fn packet(number: u32) -> Vec<u8> {
    let mut packet = vec![0xFA, 0x05, 0x01, 0x00, 0x1C, 0x00];
    packet.extend((u64::from(number) * TICK_NS).to_le_bytes());
    packet.extend([0.025_f32, -0.0125, -9.8, 1e-3, -2e-3, 3e-3, 25.0].iter().flat_map(|value| value.to_le_bytes()));
    packet.extend(crc16(&packet[1..]).to_be_bytes());
    packet
}

/// The other process: tells its ports, writes frames to each in turn, and tells when it wrote them
/// once its input ends.
pub(crate) fn feed(ports: usize, rate_hz: u32, frames: &str) {
    let mut terminals: Vec<_> = (0..ports).map(|_| TTYPort::pair().unwrap()).collect();
    for (_, ours) in &terminals {
        println!("{}", ours.name().unwrap());
    }
    let clock = Clock::start();
    let lines = (SETTLING + MEASURING).as_secs() as u32 * rate_hz;
    let mut written_ns = vec![Vec::new(); ports];
    let start = Instant::now();
    for number in 0..lines {
        for (port, ((sensor, _), written_ns)) in terminals.iter_mut().zip(&mut written_ns).enumerate() {
            let turns = f64::from(number) + port as f64 / ports as f64;
            let due = start + Duration::from_secs_f64(turns / f64::from(rate_hz));
            sleep(due.saturating_duration_since(Instant::now()));
            // packets at 200 Hz are every fourth of 800
            let frame = if frames == LINES { line(number).into_bytes() } else { packet(number * (800 / rate_hz)) };
            written_ns.push(clock.now_ns());
            sensor.write_all(&frame).unwrap();
        }
    }
    io::stdin().read_line(&mut String::new()).unwrap();
    for written_ns in written_ns {
        println!("{}", written_ns.len());
        written_ns.iter().for_each(|at_ns| println!("{at_ns}"));
    }
}
