//! `--serve`: the live page, as the command line has it.

use std::{
    io,
    net::{SocketAddr, TcpListener},
    sync::Arc,
    time::Duration,
};

use anyhow::{Context, Result, anyhow};
use tokio::time::Instant;
use vn100_analysis::Settings;
use vn100_report::{Evaluation, goals::Goals};
use vn100_session::Session;

use crate::{
    args::ServeArgs,
    asked::asked,
    serve::{Drawer, ServedSource, Server},
};

/// How long the end of the program waits for readers of its last state: on a busy machine, half a
/// second was too short to send it to those who read.
const GRACE: Duration = Duration::from_secs(2);

/// Where a measurement is watched from elsewhere, before anything is measured.
pub(crate) struct Watched {
    listener: TcpListener,
    names: Vec<String>,
}

impl Watched {
    /// Takes the address; `None` if nothing is asked for.
    pub(crate) fn of(args: &ServeArgs) -> Result<Option<Self>> {
        let Some(address) = args.serve else { return Ok(None) };
        let listener = TcpListener::bind(address).map_err(|error| anyhow!(refused(address, &error)))?;
        let names = machine_names().into_iter().chain(args.serve_host.iter().cloned()).collect();
        Ok(Some(Self { listener, names }))
    }

    /// Where the page is, as others ask for it; `None` if its address is not known.
    pub(crate) fn url(&self) -> Option<String> {
        let address = self.listener.local_addr().ok()?;
        Some(url(address, self.name()))
    }

    /// The first name of this machine.
    fn name(&self) -> Option<&str> {
        self.names.first().map(String::as_str)
    }

    /// Shows these sessions, and says where.
    pub(crate) fn show<'a>(
        self,
        sessions: impl IntoIterator<Item = &'a Session>,
        goals: &Goals,
        settings: &Settings,
        evaluation: &Arc<Evaluation>,
        say: impl FnOnce(String),
    ) -> Result<Server> {
        let source = |session: &Session| ServedSource { state: session.state.clone(), goals: goals.clone() };
        let address = self.listener.local_addr()?;
        say(announced(address, self.name()));
        let sources = sessions.into_iter().map(source).collect();
        let drawer = Drawer::new(sources, Arc::clone(evaluation), asked(), settings.confidence, Instant::now());
        let server = Server::start(self.listener, self.names, drawer, GRACE);
        server.context("cannot start the live page")
    }
}

fn refused(address: SocketAddr, error: &io::Error) -> String {
    let advice = match error.kind() {
        io::ErrorKind::AddrInUse => {
            "another program has it, perhaps another vn100: choose another port, as in --serve=:8101, or any free one with --serve=:0"
        }
        io::ErrorKind::PermissionDenied => "ports below 1024 need privileges: choose another, as in --serve=:8100",
        io::ErrorKind::AddrNotAvailable => "this machine has no such address: --serve alone takes 127.0.0.1",
        _ => "choose another address, as in --serve=127.0.0.1:8101",
    };
    format!("cannot show the live page at {address}: {error}; {advice}")
}

/// Where the page is, and who can read it.
fn announced(address: SocketAddr, name: Option<&str>) -> String {
    let (url, port) = (url(address, name), address.port());
    if address.ip().is_loopback() {
        return format!(
            "live page: {url} (this machine alone; elsewhere after ssh -L {port}:{address} USER@{})",
            name.unwrap_or("HOST")
        );
    }
    format!("live page: {url} WARNING: everyone who reaches this machine can read it, without password or encryption")
}

/// As it is asked for: where all addresses answer, by the name of this machine.
fn url(address: SocketAddr, name: Option<&str>) -> String {
    match name {
        Some(name) if address.ip().is_unspecified() => format!("http://{name}:{}/", address.port()),
        _ => format!("http://{address}/"),
    }
}

/// The names by which others know this machine, as far as it knows them itself.
fn machine_names() -> Vec<String> {
    #[cfg(unix)]
    let name = rustix::system::uname().nodename().to_string_lossy().into_owned();
    #[cfg(not(unix))]
    let name = std::env::var("COMPUTERNAME").unwrap_or_default();
    if name.is_empty() {
        return Vec::new();
    }
    let local = format!("{name}.local");
    vec![name, local]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_that_others_reach_is_announced_with_a_warning() {
        let text = announced("127.0.0.1:8100".parse().unwrap(), Some("bench"));
        assert!(
            text.contains("http://127.0.0.1:8100/") && text.contains("ssh -L 8100:127.0.0.1:8100 USER@bench"),
            "{text}"
        );
        assert!(!text.contains("WARNING"), "{text}");
        for (address, url) in [("0.0.0.0:8100", "http://bench:8100/ "), ("192.168.1.7:80", "http://192.168.1.7:80/ ")] {
            let text = announced(address.parse().unwrap(), Some("bench"));
            assert!(text.contains(url) && text.contains("WARNING"), "{text}");
        }
        let all = "0.0.0.0:8100".parse().unwrap();
        let text = announced(all, None);
        assert!(text.contains("http://0.0.0.0:8100/ WARNING"), "{text}");
    }

    #[test]
    fn an_address_in_use_is_refused_with_what_to_do() {
        let taken = TcpListener::bind("127.0.0.1:0").unwrap();
        let args = ServeArgs { serve: Some(taken.local_addr().unwrap()), ..ServeArgs::default() };
        let error = Watched::of(&args).err().unwrap().to_string();
        assert!(error.contains("--serve=:8101"), "{error}");
        assert!(Watched::of(&ServeArgs::default()).unwrap().is_none());
    }
}
