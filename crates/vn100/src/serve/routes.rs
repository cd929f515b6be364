//! The addresses of the server, and what each answers.

use std::sync::Arc;

use axum::{
    Router,
    body::{Body, Bytes},
    extract::{Path, Request, State},
    http::{HeaderMap, StatusCode, header},
    middleware::from_fn_with_state,
    response::{IntoResponse, Response},
    routing::get,
};
use sha2::{Digest, Sha256};
use vn100_report::METRICS_TYPE;
use vn100_report::html::LIVE_ICON;

use crate::serve::{
    app::App,
    drawing::Drawer,
    events::{EventPlace, EventReader},
    guard::guard,
};

pub(crate) fn router(app: &Arc<App>) -> Router {
    Router::new()
        .route("/", get(async |state| page(state, Path("0".into())).await))
        .route("/{place}", get(page))
        .route("/icon.svg", get(async || text("image/svg+xml", LIVE_ICON)))
        .route("/events", get(events))
        .route("/snapshot.json", get(snapshot))
        .route("/report.html", get(report))
        .route("/metrics", get(metrics))
        .route("/healthz", get(health))
        .layer(from_fn_with_state(Arc::clone(app), guard))
        .with_state(Arc::clone(app))
}

fn text(kind: &'static str, text: impl Into<Body>) -> Response {
    ([(header::CONTENT_TYPE, kind)], text.into()).into_response()
}

/// A page that carries its style and its script in itself, and nothing else may run on it.
fn html(page: Bytes) -> Response {
    let content = String::from_utf8_lossy(&page);
    let policy = format!(
        "default-src 'none'; style-src {}; script-src {}; connect-src 'self'; img-src 'self'; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'",
        hashes(&content, "style"),
        hashes(&content, "script")
    );
    ([(header::CONTENT_SECURITY_POLICY, policy)], text("text/html; charset=utf-8", page)).into_response()
}

async fn page(State(app): State<Arc<App>>, Path(place): Path<String>) -> Result<Response, StatusCode> {
    let place = place.parse().map_err(|_| StatusCode::NOT_FOUND)?;
    let page = app.ask(move |drawer, now| drawer.html(now, place)).await?;
    page.map(|page| html(page.into())).ok_or(StatusCode::NOT_FOUND)
}

async fn snapshot(State(app): State<Arc<App>>) -> Result<Response, StatusCode> {
    Ok(text("application/json", app.ask(Drawer::documents).await?))
}

async fn report(State(app): State<Arc<App>>) -> Result<Response, StatusCode> {
    Ok(html(app.ask(Drawer::report).await?))
}

async fn metrics(State(app): State<Arc<App>>) -> Result<Response, StatusCode> {
    Ok(text(METRICS_TYPE, app.ask(Drawer::metrics).await?))
}

async fn health(State(app): State<Arc<App>>) -> Result<Response, StatusCode> {
    let (is_healthy, lines) = app.ask(|drawer, now| drawer.health(now)).await?;
    let status = if is_healthy { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    Ok((status, text("text/plain; charset=utf-8", lines)).into_response())
}

async fn events(State(app): State<Arc<App>>, request: Request) -> Result<Response, StatusCode> {
    let query = request.uri().query().unwrap_or_default();
    let page = asked(query, "page").and_then(|page| page.parse().ok()).unwrap_or(0);
    let place = place(request.headers(), query);
    // a stream of no page would be taken from those that read one
    if !app.ask(move |drawer, _| drawer.has_page(page)).await? {
        return Err(StatusCode::NOT_FOUND);
    }
    let stream = Arc::clone(&app.streams).try_acquire_owned().ok();
    let reader = EventReader { states: app.page.subscribe(), page, place, over: app.over.clone(), stream };
    Ok(reader.answer())
}

/// How far the reader has come: a browser that connects again sends the id of its last event.
fn place(headers: &HeaderMap, query: &str) -> Option<EventPlace> {
    let again = headers.get("last-event-id").and_then(|id| EventPlace::parse(id.to_str().ok()?));
    again.or_else(|| EventPlace::parse(asked(query, "since")?))
}

/// A value of a query.
fn asked<'a>(query: &'a str, name: &str) -> Option<&'a str> {
    query.split('&').find_map(|part| part.strip_prefix(name)?.strip_prefix('='))
}

/// The hashes of the contents of all elements of that name that have no attribute, for a content
/// security policy. What has one is data, which does not run.
fn hashes(page: &str, element: &str) -> String {
    let (begin, end) = (format!("<{element}>"), format!("</{element}>"));
    let contents = page.split(&begin).skip(1).filter_map(|rest| Some(rest.split_once(&end)?.0));
    let hash = |content: &str| format!("'sha256-{}'", base64(&Sha256::digest(content)));
    let hashes: Vec<String> = contents.map(hash).collect();
    if hashes.is_empty() { "'none'".into() } else { hashes.join(" ") }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let of_three = |three: &[u8]| {
        let bits = (0..3).fold(0_u32, |bits, place| bits << 8 | u32::from(three.get(place).copied().unwrap_or(0)));
        [18, 12, 6, 0].map(|shift| char::from(DIGITS[(bits >> shift) as usize & 63]))
    };
    let mut text = String::new();
    for three in bytes.chunks(3) {
        text.extend(of_three(three).into_iter().take(three.len() + 1));
        text.extend(std::iter::repeat_n('=', 3 - three.len()));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_as_rfc_4648_has_them() {
        for (bytes, text) in [("", ""), ("M", "TQ=="), ("Ma", "TWE="), ("Man", "TWFu"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn every_script_that_runs_and_every_style_has_its_hash() {
        let page = "<style>a{}</style><p>x</p><script type=\"application/json\">[]</script><script>alert(1)</script>";
        // printf 'alert(1)' | openssl dgst -sha256 -binary | base64
        let script = "'sha256-bhHHL3z2vDgxUt0W3dWQOrprscmda2Y5pLsLg4GF+pI='";
        assert_eq!(hashes(page, "script"), script, "data has none");
        assert_eq!(hashes(page, "style").matches("sha256-").count(), 1);
        assert_eq!(hashes("<p>", "style"), "'none'");
    }

    #[test]
    fn a_reader_is_known_by_its_last_event() {
        let mut headers = HeaderMap::new();
        assert_eq!(place(&headers, ""), None);
        let since = Some(EventPlace { run: 7, version: 3 });
        assert_eq!(place(&headers, "x=1&since=7-3"), since);
        assert_eq!(place(&headers, "since=nonsense"), None);
        headers.insert("last-event-id", "7-9".parse().unwrap());
        assert_eq!(place(&headers, "since=7-3"), Some(EventPlace { run: 7, version: 9 }));
    }
}
