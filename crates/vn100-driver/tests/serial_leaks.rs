//! A port that is opened and closed a thousand times leaves no thread and no open file. The test is
//! alone in its process, in order to count them.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::Duration;

use serialport::{SerialPort, TTYPort};
use vn100_capture::Clock;
use vn100_driver::{Connect, Connection, SerialPorts};

const AT_ONCE: usize = 50;

fn count(folder: &str) -> usize {
    std::fs::read_dir(folder).unwrap().count()
}

#[test]
fn a_thousand_openings_leave_nothing_behind() {
    // one thread opens ports, and it stays
    let mut runtime = tokio::runtime::Builder::new_current_thread();
    let runtime = runtime.enable_all().max_blocking_threads(1).thread_keep_alive(Duration::from_secs(3600));
    let runtime = runtime.build().unwrap();
    runtime.block_on(async { tokio::task::spawn_blocking(|| ()).await }).unwrap();
    runtime.block_on(open_and_close());
}

async fn open_and_close() {
    let terminals: Vec<_> = (0..AT_ONCE).map(|_| TTYPort::pair().unwrap()).collect();
    let names: Vec<_> = terminals.iter().map(|(_, ours)| ours.name().unwrap()).collect();
    let (files, threads) = (count("/proc/self/fd"), count("/proc/self/task"));
    for round in 0..1000 / AT_ONCE {
        let mut connections = Vec::new();
        for name in &names {
            connections.push(SerialPorts::new(name, Clock::start()).open(115_200).await.unwrap());
        }
        assert_eq!(count("/proc/self/task"), threads + AT_ONCE);
        // together, because each takes up to the time that a read waits
        let closing: Vec<_> = connections.into_iter().map(|connection| tokio::spawn(connection.close())).collect();
        for closed in closing {
            closed.await.unwrap();
        }
        assert_eq!(count("/proc/self/fd"), files, "round {round}");
        // a thread is done with everything before the system takes it off its list
        while count("/proc/self/task") > threads {
            tokio::task::yield_now().await;
        }
    }
}
