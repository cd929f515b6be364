//! Answers compressed by gzip, each piece at once: an event is read when it has come.

use std::io::{self, Write};

use axum::{
    body::{Body, Bytes},
    http::{HeaderMap, HeaderValue, header},
    response::Response,
};
use flate2::{Compression, write::GzEncoder};
use tokio_stream::StreamExt;

pub(crate) fn takes_gzip(headers: &HeaderMap) -> bool {
    let accepted = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|accepted| accepted.to_str().ok());
    let mut kinds = accepted.flat_map(|accepted| accepted.split(','));
    kinds.any(|kind| kind.trim() == "gzip" || kind.trim().starts_with("gzip;q=0."))
}

pub(crate) fn compressed(response: Response) -> Response {
    let (mut head, body) = response.into_parts();
    head.headers.remove(header::CONTENT_LENGTH);
    head.headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    let mut encoder = Some(GzEncoder::new(Vec::new(), Compression::default()));
    let pieces = body.into_data_stream().map(Some).chain(tokio_stream::once(None));
    let pack = move |piece: Option<Result<Bytes, axum::Error>>| -> io::Result<Bytes> {
        let Some(piece) = piece else {
            let end = encoder.take().map(GzEncoder::finish).transpose()?;
            return Ok(end.unwrap_or_default().into());
        };
        let piece = piece.map_err(io::Error::other)?;
        let Some(encoder) = &mut encoder else { return Ok(piece) };
        encoder.write_all(&piece)?;
        encoder.flush()?;
        Ok(std::mem::take(encoder.get_mut()).into())
    };
    Response::from_parts(head, Body::from_stream(pieces.map(pack)))
}
