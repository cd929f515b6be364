//! Which requests are answered: those that only read, and whose host is a name or an address of
//! this machine. A foreign page whose name resolves to this machine is refused (DNS rebinding).

use std::{net::IpAddr, sync::Arc};

use axum::{
    extract::{Request, State},
    http::{
        HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri,
        header::{self, HOST},
    },
    middleware::Next,
    response::{IntoResponse, Response},
};

use crate::serve::{
    app::App,
    compression::{compressed, takes_gzip},
};

/// The address of this machine that a connection came to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Local(pub(crate) Option<IpAddr>);

/// The host that a request names; `None` where it names none, or several.
fn asked_host(uri: &Uri, headers: &HeaderMap) -> Option<String> {
    let mut hosts = headers.get_all(HOST).iter();
    let host = hosts.next()?.to_str().ok()?;
    hosts.next().is_none().then(|| uri.host().unwrap_or(host).to_owned())
}

/// Whether the host is this machine under one of these names, for a connection to `local`. The port
/// does not count: a tunnel may have another.
fn is_own(host: &str, names: &[String], local: Option<IpAddr>) -> bool {
    let host = bare(host);
    let is_loopback = local.is_some_and(|local| local.to_canonical().is_loopback());
    let is_local = match host.parse::<IpAddr>() {
        Ok(ip) if ip.is_loopback() => is_loopback,
        Ok(ip) => local.is_some_and(|local| local.to_canonical() == ip.to_canonical()),
        Err(_) => host == "localhost" && is_loopback,
    };
    is_local || names.contains(&host)
}

/// A host without its port and the brackets of an IPv6 address, in lower case.
pub(crate) fn bare(host: &str) -> String {
    let host = host.trim();
    let name = match host.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((address, _)) => address,
        // an address of IPv6 has colons of its own
        None if host.matches(':').count() > 1 => host,
        None => host.split(':').next().unwrap_or(host),
    };
    name.trim_end_matches('.').to_ascii_lowercase()
}

/// Headers of every answer: no other site may frame the page, load it, or learn of it.
const HEADERS: [(HeaderName, &str); 5] = [
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::CACHE_CONTROL, "no-store"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

const POLICY: &str = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

pub(crate) async fn guard(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let local = request.extensions().get::<Local>().and_then(|local| local.0);
    let host = asked_host(request.uri(), request.headers());
    let is_packed = request.method() == Method::GET && takes_gzip(request.headers());
    let mut response = match host {
        _ if !matches!(*request.method(), Method::GET | Method::HEAD) => {
            (StatusCode::METHOD_NOT_ALLOWED, [(header::ALLOW, "GET, HEAD")], "this page only reads\n").into_response()
        }
        Some(host) if is_own(&host, &app.hosts, local) => next.run(request).await,
        Some(_) => (StatusCode::FORBIDDEN, "this name is unknown here: --serve-host NAME allows it\n").into_response(),
        None => (StatusCode::BAD_REQUEST, "a request names one host\n").into_response(),
    };
    if is_packed {
        response = compressed(response);
    }
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.entry(header::CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(POLICY));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_is_an_address_of_the_connection_or_a_name_of_the_machine() {
        let names = ["Bench", "imu.lab", "10.0.0.9"].map(bare);
        let (loopback, lan) = ("127.0.0.1", "192.168.1.7");
        for (host, local, is_allowed) in [
            ("127.0.0.1:8100", loopback, true),
            ("localhost", loopback, true),
            ("LOCALHOST.:9000", loopback, true),
            ("[::1]:8100", "::1", true),
            ("::1", "::1", true),
            ("[::ffff:192.168.1.7]", lan, true),
            ("192.168.1.7", "::ffff:192.168.1.7", true),
            ("192.168.1.7:80", lan, true),
            ("bench:8100", lan, true),
            ("imu.lab.", loopback, true),
            ("10.0.0.9", lan, true),
            ("localhost", lan, false),
            ("127.0.0.1", lan, false),
            ("192.168.1.8", lan, false),
            ("evil.example", loopback, false),
            ("localhost.evil.example", loopback, false),
            ("bench.evil.example", lan, false),
            ("", loopback, false),
        ] {
            assert_eq!(is_own(host, &names, local.parse().ok()), is_allowed, "{host} at {local}");
        }
        assert!(!is_own("127.0.0.1", &names, None));
    }

    #[test]
    fn a_request_asks_for_one_host() {
        let headers = |names: &[&'static str]| {
            names.iter().map(|name| (HOST, HeaderValue::from_static(name))).collect::<HeaderMap>()
        };
        let here: Uri = "/".parse().unwrap();
        assert_eq!(asked_host(&here, &headers(&["a"])).as_deref(), Some("a"));
        assert_eq!(asked_host(&here, &headers(&["a", "b"])), None);
        assert_eq!(asked_host(&here, &headers(&[])), None);
        let whole: Uri = "http://evil.example/".parse().unwrap();
        assert_eq!(asked_host(&whole, &headers(&["localhost"])).as_deref(), Some("evil.example"));
    }
}
