//! The options of the live page.

use std::{
    net::{IpAddr, Ipv4Addr, SocketAddr},
    path::Path,
};

const DEFAULT_PORT: u16 = 8100;
const DEFAULT: &str = "127.0.0.1:8100";

/// How a measurement is watched from elsewhere.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Live page")]
pub(crate) struct ServeArgs {
    /// Show the measurement in browsers, at this address and port, either of which may be omitted
    /// [default: 127.0.0.1:8100, this machine alone]
    ///
    /// The page and its report can be read by everyone who reaches the address, without encryption
    /// or password; nothing can be changed there. From another machine the default is reached
    /// through ssh -L 8100:127.0.0.1:8100 USER@HOST.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, require_equals = true, default_missing_value = DEFAULT,
        value_parser = address)]
    pub(crate) serve: Option<SocketAddr>,

    /// A further name by which browsers may ask for the page, beside the address and the name of
    /// this machine
    #[arg(long, value_name = "NAME", requires = "serve")]
    pub(crate) serve_host: Vec<String>,
}

impl ServeArgs {
    /// What is wrong with an address behind `--serve` and a space, which is one of these sources
    /// then; `None` if no source looks like one.
    pub(crate) fn refused(&self, mut sources: impl Iterator<Item = String>) -> Option<String> {
        self.serve?;
        let taken = sources.find(|source| address(source).is_ok() && !Path::new(source).exists())?;
        Some(format!(
            "{taken} stands where a source does: the address of the page is joined by an equals sign, as in --serve={taken}"
        ))
    }
}

/// An address, a port, or both.
fn address(text: &str) -> Result<SocketAddr, String> {
    // the only name that is not looked up
    let local = text.strip_prefix("localhost").map(|rest| format!("{}{rest}", Ipv4Addr::LOCALHOST));
    let text = local.as_deref().unwrap_or(text);
    let port = || text.trim_start_matches(':').parse().ok();
    let ip = || text.trim_matches(['[', ']']).parse().ok();
    (text.parse().ok())
        .or_else(|| Some(SocketAddr::new(ip()?, DEFAULT_PORT)))
        .or_else(|| Some(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port()?)))
        .ok_or_else(|| format!("neither an address nor a port: name one as in {DEFAULT}, 0.0.0.0, [::1]:8100 or :8101"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_omitted_is_the_default() {
        for (text, expected) in [
            (DEFAULT, DEFAULT),
            ("0.0.0.0", "0.0.0.0:8100"),
            ("::1", "[::1]:8100"),
            ("[::]", "[::]:8100"),
            ("[::1]:80", "[::1]:80"),
            (":8101", "127.0.0.1:8101"),
            ("0", "127.0.0.1:0"),
            ("localhost", DEFAULT),
            ("localhost:8101", "127.0.0.1:8101"),
        ] {
            assert_eq!(address(text).unwrap(), expected.parse().unwrap(), "{text}");
        }
        for text in ["", ":", "bench:8100", "localhosts", "70000", "1.2.3", "1.2.3.4:x"] {
            assert!(address(text).is_err(), "{text}");
        }
    }
}
