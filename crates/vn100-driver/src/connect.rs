//! The transport of a link (a port, a socket or a script), and the errors of opening it.

use std::{ffi::OsStr, fs, future::Future, io, path::Path};

use thiserror::Error;
use vn100_capture::Source;
use vn100_protocol::stream::StreamInput;

use crate::ports::{LatencyTimer, PortEntry};

/// Opens a connection, and opens it again after the link is lost.
pub trait Connect: Send + 'static {
    /// The connections of this connector.
    type Connection: Connection;

    /// Whether the link has a baud rate that must equal that of the sensor.
    const HAS_BAUD: bool;

    /// Opens the link at a baud rate; links without one ignore it.
    ///
    /// # Errors
    /// The reason why the link cannot be opened, and the remedy.
    fn open(&mut self, baud: u32) -> impl Future<Output = Result<Self::Connection, ConnectError>> + Send;

    /// The time now, in nanoseconds from the origin of the times of the connection's
    /// [`Chunk`](vn100_protocol::stream::Chunk)s.
    fn now_ns(&self) -> i64;

    /// The name of the link as given by the user.
    fn name(&self) -> String;
}

/// An open connection: a [`Source`] whose end means that the link is lost, and the way to the
/// sensor.
pub trait Connection: Source {
    /// The name by which the connection was opened, such as `/dev/ttyUSB0`.
    fn name(&self) -> &str;

    /// Changes the baud rate. Bytes that were received at the old one may still come from it.
    ///
    /// # Errors
    /// If the port does not support the baud rate.
    fn set_baud(&mut self, baud: u32) -> io::Result<()>;

    /// Sends bytes.
    ///
    /// # Errors
    /// If not all bytes can be passed to the system, as after an unplug.
    fn write(&mut self, bytes: &[u8]) -> impl Future<Output = io::Result<()>> + Send;

    /// Closes the connection. When this has returned, the port can be opened again. Returns the
    /// inputs that were read but not taken, so that every byte is counted.
    fn close(self) -> impl Future<Output = Vec<StreamInput>> + Send;

    /// The file by which other programs open the same port; `None` if there is no such file.
    fn device_file(&self) -> Option<&Path> {
        None
    }

    /// The latency timer of the adapter; `None` if the adapter has none.
    fn latency_timer(&self) -> Option<&LatencyTimer> {
        None
    }
}

/// The reason why a live source cannot be opened.
#[derive(Debug, Error)]
pub enum ConnectError {
    /// A serial port cannot be opened.
    #[error("cannot open {port} at {baud} baud: {problem}")]
    Port {
        /// The name of the port.
        port: String,
        /// The baud rate requested.
        baud: u32,
        /// The reason why the port cannot be opened.
        problem: PortProblem,
    },
    /// `tcp://` is followed by anything other than a host and a port.
    #[error("{0} is not an address of the form tcp://host:port, such as tcp://192.168.1.20:2000")]
    Address(String),
    /// The server at the address cannot be reached.
    #[error("cannot connect to {address}: {}", server_advice(error))]
    Server {
        /// The address.
        address: String,
        /// The error of the system.
        error: io::Error,
    },
}

/// The reason why a serial port cannot be opened. The candidates are the ports of this machine, the
/// likely ones first.
#[derive(Debug, Error)]
pub enum PortProblem {
    /// A program has the port open: its name and the number of its process, if this user may see
    /// them.
    #[error("it is in use by {}; end that program first", .0.as_deref().unwrap_or("another program"))]
    Busy(Option<String>),
    /// There is no port of this name.
    #[error("there is no such port; check the cable; {}", available_ports(.0))]
    NotFound(Vec<PortEntry>),
    /// The adapter was unplugged, and the name of the port now refers to another adapter.
    #[error("another adapter has that name now; plug in the one that had it; {}", available_ports(.0))]
    AnotherAdapter(Vec<PortEntry>),
    /// The user may not open the port, only members of this group may: `dialout` if the group is
    /// not known, `None` if only root may.
    #[error("permission denied; {}", permission_advice(.0.as_deref()))]
    Denied(Option<String>),
    /// The file is not a serial port.
    #[error("it is not a serial port; {}", available_ports(.0))]
    NotASerialPort(Vec<PortEntry>),
    /// Any other error of the system.
    #[error("{0}")]
    Other(io::Error),
}

impl ConnectError {
    /// The error of opening a port under its current `name`; the user gave the name `given`.
    pub(crate) fn of_port(given: &str, name: &str, baud: u32, error: serialport::Error, ports: Vec<PortEntry>) -> Self {
        use serialport::ErrorKind::{Io, NoDevice};
        let path = Path::new(name);
        let problem = match error.kind {
            Io(io::ErrorKind::NotFound) => PortProblem::NotFound(ports),
            Io(io::ErrorKind::PermissionDenied) => PortProblem::Denied(group_of(path)),
            // on other systems the same kind means that there is none
            NoDevice if cfg!(unix) => PortProblem::Busy(programs_on(path).next().map(in_words)),
            NoDevice => PortProblem::NotFound(ports),
            _ if error.description == NOT_A_TERMINAL || !may_be_port(path) => PortProblem::NotASerialPort(ports),
            _ => PortProblem::Other(error.into()),
        };
        let is_given = name == given || matches!(problem, PortProblem::NotFound(_));
        let port = if is_given { given.to_owned() } else { format!("{given} as {name}") };
        Self::Port { port, baud, problem }
    }

    /// Whether another attempt can help. A missing port returns when it is plugged in, and udev
    /// sets its permissions a moment after it creates the node; a file that is not a serial port
    /// will not become one.
    pub(crate) fn is_passing(&self) -> bool {
        !matches!(self, Self::Port { problem: PortProblem::NotASerialPort(_), .. } | Self::Address { .. })
    }
}

/// The text of the system for ENOTTY.
const NOT_A_TERMINAL: &str = "Not a typewriter";

#[cfg(unix)]
fn may_be_port(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_char_device())
}

#[cfg(not(unix))]
fn may_be_port(_path: &Path) -> bool {
    true
}

/// The group whose members may read and write the port, `dialout` if the group is not known.
/// Membership in the group of root would give access to far more than a port.
#[cfg(unix)]
fn group_of(path: &Path) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    const READ_AND_WRITE: u32 = 0o060;
    let Ok(metadata) = fs::metadata(path) else { return Some("dialout".into()) };
    if metadata.gid() == 0 || metadata.mode() & READ_AND_WRITE != READ_AND_WRITE {
        return None;
    }
    let groups = fs::read_to_string("/etc/group").unwrap_or_default();
    Some(group_name(&groups, metadata.gid()).unwrap_or("dialout").to_owned())
}

#[cfg(not(unix))]
fn group_of(_path: &Path) -> Option<String> {
    Some("dialout".into())
}

fn server_advice(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::ConnectionRefused => {
            "connection refused: start the serial server, and check its port number".into()
        }
        io::ErrorKind::TimedOut => "no answer: check that the server is on and in this network".into(),
        _ => format!("{error}; check the name of the server and the network"),
    }
}

fn permission_advice(group: Option<&str>) -> String {
    match group {
        Some(group) => format!("join the group {group}: `sudo usermod -aG {group} $USER`, then log in again"),
        None => {
            "it belongs to no group that a user could join: a udev rule can assign one, as for most adapters".into()
        }
    }
}

/// The name of a group in the text of `/etc/group`.
#[cfg(unix)]
fn group_name(groups: &str, id: u32) -> Option<&str> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(id)).then_some(name)
    })
}

/// The name and the process of another program that has the port at `path` open: `screen (process
/// 71)`. `None` if there is none, for a program of another user, which the system does not show,
/// and on systems other than Linux.
pub fn other_program_on(path: &Path) -> Option<String> {
    programs_on(path).find(|(process, _)| *process != std::process::id()).map(in_words)
}

fn in_words((process, name): (u32, String)) -> String {
    match process == std::process::id() {
        true => "this program itself, for another source".into(),
        false => format!("{name} (process {process})"),
    }
}

/// All programs that have the port open, as far as `/proc` shows them, by the numbers of their processes
/// and their names: programs of other users are not shown. The program on the other side of a
/// pseudo-terminal, such as an emulated sensor, is the device and not a user of the port.
fn programs_on(path: &Path) -> impl Iterator<Item = (u32, String)> {
    let port = fs::canonicalize(path).ok();
    let processes = port.is_some().then(|| fs::read_dir("/proc").ok()).flatten();
    processes.into_iter().flatten().flatten().filter_map(move |process| {
        let number = process.file_name().to_str()?.parse().ok()?;
        let (port, process) = (port.as_ref()?, process.path());
        let files: Vec<_> = fs::read_dir(process.join("fd")).ok()?.flatten().collect();
        let reads = |file: &fs::DirEntry| {
            fs::read_link(file.path()).is_ok_and(|target| target == *port) && can_read(&process, &file.file_name())
        };
        let holds =
            files.iter().any(reads) && !files.iter().any(|file| is_other_side(&process, &file.file_name(), port));
        let name = holds.then(|| fs::read_to_string(process.join("comm")).ok()).flatten()?;
        // a process that is about to run another program had the files of the first one until now
        files.iter().any(reads).then(|| (number, name.trim().into()))
    })
}

/// Whether this file of a process is open for reading.
fn can_read(process: &Path, file: &OsStr) -> bool {
    const ACCESS_MODE: u32 = 0o3;
    const WRITE_ONLY: u32 = 0o1;
    let info = fs::read_to_string(process.join("fdinfo").join(file)).unwrap_or_default();
    let flags = info.lines().find_map(|line| u32::from_str_radix(line.strip_prefix("flags:")?.trim(), 8).ok());
    flags.is_none_or(|flags| flags & ACCESS_MODE != WRITE_ONLY)
}

/// Whether this file of a process is the master of the pseudo-terminal `port`.
fn is_other_side(process: &Path, file: &OsStr, port: &Path) -> bool {
    let Some(number) = port.strip_prefix("/dev/pts").ok().and_then(Path::to_str) else { return false };
    let info = fs::read_to_string(process.join("fdinfo").join(file)).unwrap_or_default();
    info.lines().any(|line| line.strip_prefix("tty-index:").is_some_and(|index| index.trim() == number))
}

/// These ports in words, the likely ones marked.
pub fn available_ports(ports: &[PortEntry]) -> String {
    if ports.is_empty() {
        return "no serial port is available".into();
    }
    let named = |port: &PortEntry| format!("{}{}", port.name, if port.likely { " (likely)" } else { "" });
    format!("available ports: {}", ports.iter().map(named).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(kind: serialport::ErrorKind, text: &str, port: &str) -> String {
        ConnectError::of_port(port, port, 115_200, serialport::Error::new(kind, text), Vec::new()).to_string()
    }

    #[test]
    fn each_error_gives_a_remedy() {
        use serialport::ErrorKind::{Io, Unknown};
        let missing = message(Io(io::ErrorKind::NotFound), "", "/dev/ttyUSB9");
        assert_eq!(
            missing,
            "cannot open /dev/ttyUSB9 at 115200 baud: there is no such port; check the cable; no serial port is available"
        );
        let denied = message(Io(io::ErrorKind::PermissionDenied), "", "/dev/ttyUSB9");
        assert!(denied.contains("`sudo usermod -aG dialout $USER`, then log in again"), "{denied}");
        assert!(message(Unknown, NOT_A_TERMINAL, "/dev/null").contains("not a serial port"));
        assert!(message(Unknown, "Is a directory", "/").contains("not a serial port"));
        assert!(message(Unknown, "I/O error", "/dev/null").ends_with("/dev/null at 115200 baud: I/O error"));
    }

    #[cfg(unix)]
    #[test]
    fn a_port_in_use_is_no_missing_port() {
        let busy = message(serialport::ErrorKind::NoDevice, "Device or resource busy", "/dev/null");
        assert!(busy.contains("in use"), "{busy}");
        // a character device may be a port in spite of its error; a file is none
        assert!(may_be_port(Path::new("/dev/null")) && !may_be_port(Path::new("/")));
    }

    #[test]
    fn candidates_are_listed_with_the_likely_marked() {
        let port = |name: &str, likely| PortEntry { name: name.into(), stable_name: None, usb: None, likely };
        let ports = [port("/dev/ttyUSB1", true), port("/dev/ttyS0", false)];
        assert_eq!(available_ports(&ports), "available ports: /dev/ttyUSB1 (likely), /dev/ttyS0");
    }

    #[cfg(unix)]
    #[test]
    fn groups_are_found_by_number() {
        let groups = "root:x:0:\ndialout:x:20:ann,bob\nbroken\n";
        assert_eq!(group_name(groups, 20), Some("dialout"));
        assert_eq!(group_name(groups, 21), None);
        assert!(permission_advice(Some("dialout")).contains("usermod -aG dialout"));
    }

    #[test]
    fn a_program_that_only_writes_to_a_port_takes_no_bytes_from_it() {
        let process = tempfile::tempdir().unwrap();
        fs::create_dir(process.path().join("fdinfo")).unwrap();
        for (flags, expected) in
            [("0100000", true), ("0100001", false), ("02000001", false), ("0102", true), ("", true)]
        {
            fs::write(process.path().join("fdinfo/5"), format!("pos:\t0\nflags:\t{flags}\n")).unwrap();
            assert_eq!(can_read(process.path(), OsStr::new("5")), expected, "{flags}");
        }
        assert!(can_read(process.path(), OsStr::new("6")), "nothing says otherwise");
    }

    #[test]
    fn the_master_of_a_pseudo_terminal_is_its_other_side() {
        let process = tempfile::tempdir().unwrap();
        fs::create_dir(process.path().join("fdinfo")).unwrap();
        fs::write(process.path().join("fdinfo/5"), "pos:\t0\nflags:\t0102\ntty-index:\t7\n").unwrap();
        fs::write(process.path().join("fdinfo/6"), "pos:\t7\nflags:\t0102\n").unwrap();
        for (file, port, expected) in [
            ("5", "/dev/pts/7", true),
            ("5", "/dev/pts/8", false),
            ("5", "/dev/ttyUSB7", false),
            ("6", "/dev/pts/7", false),
            ("9", "/dev/pts/7", false),
        ] {
            assert_eq!(is_other_side(process.path(), OsStr::new(file), Path::new(port)), expected, "{file} {port}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn joining_the_group_of_root_is_never_advised() {
        // a group without the right to write gives none, the rights of others do
        let file = tempfile::NamedTempFile::new().unwrap();
        let mode = |mode| fs::set_permissions(file.path(), std::os::unix::fs::PermissionsExt::from_mode(mode)).unwrap();
        mode(0o640);
        assert_eq!(group_of(file.path()), None);
        mode(0o660);
        let own = std::os::unix::fs::MetadataExt::gid(&fs::metadata(file.path()).unwrap());
        assert_eq!(group_of(file.path()).is_some(), own != 0);
        assert_eq!(group_of(Path::new("/nowhere")).as_deref(), Some("dialout"));
        // the file belongs to root, and no group may write it
        assert_eq!(group_of(Path::new("/proc/kmsg")), None);
        assert!(!permission_advice(None).contains("usermod"));
    }
}
