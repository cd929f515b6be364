//! Connections: few at a time, and none that sends its request slowly, sends a large one, or does
//! not read its answer.

use std::{
    io,
    net::SocketAddr,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use axum::{Router, extract::Request};
use hyper::{
    body::Incoming,
    server::conn::http1,
    service::{Service, service_fn},
};
use hyper_util::{
    rt::{TokioIo, TokioTimer},
    service::TowerToHyperService,
};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    net::{TcpListener, TcpStream},
    sync::{OwnedSemaphorePermit, Semaphore},
    time::{self, Sleep},
};
use tokio_util::{sync::CancellationToken, task::TaskTracker};

use crate::serve::guard::Local;

/// Connections at the same time; further ones are closed at once.
const CONNECTIONS: usize = 128;

/// The longest wait for a request, also for the next one on a connection that is kept open.
const REQUEST_WITHIN: Duration = Duration::from_secs(5);

/// The longest time in which a reader may take nothing of its answer.
const TAKE_WITHIN: Duration = Duration::from_secs(20);

/// The longest request, with all its headers.
const REQUEST_BYTES: usize = 16 << 10;
const HEADERS: usize = 64;

/// The delay before the next attempt where a connection cannot be accepted, as with too many open
/// files.
const ACCEPT_AGAIN: Duration = Duration::from_millis(200);

/// Accepts connections and answers their requests until `over` is cancelled, and waits for those
/// that are open, `grace` at most.
pub(crate) async fn accept(listener: TcpListener, router: Router, grace: Duration, over: &CancellationToken) {
    let free = Arc::new(Semaphore::new(CONNECTIONS));
    let open = TaskTracker::new();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = over.cancelled() => break,
        };
        match accepted {
            Ok((stream, _)) => {
                if let Ok(place) = Arc::clone(&free).try_acquire_owned() {
                    open.spawn(answer(stream, router.clone(), over.clone(), place));
                }
            }
            Err(_) => time::sleep(ACCEPT_AGAIN).await,
        }
    }
    open.close();
    let _ = time::timeout(grace, open.wait()).await;
}

async fn answer(stream: TcpStream, router: Router, over: CancellationToken, _place: OwnedSemaphorePermit) {
    // events are small, and are to be seen at once
    let _ = stream.set_nodelay(true);
    let local = Local(stream.local_addr().ok().map(|local: SocketAddr| local.ip()));
    let router = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(local);
        router.call(request)
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(REQUEST_WITHIN)
        .max_buf_size(REQUEST_BYTES)
        .max_headers(HEADERS)
        .serve_connection(TokioIo::new(Patient::new(stream)), service);
    tokio::pin!(connection);
    tokio::select! {
        // what breaks a connection is the business of its other end
        _ = connection.as_mut() => return,
        () = over.cancelled() => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

/// A stream whose other end has to take what is written.
struct Patient {
    stream: TcpStream,
    waiting: Option<Pin<Box<Sleep>>>,
}

impl Patient {
    const fn new(stream: TcpStream) -> Self {
        Self { stream, waiting: None }
    }

    /// The outcome of a write, or that it took too long.
    fn within<T>(&mut self, context: &mut Context<'_>, done: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if done.is_ready() {
            self.waiting = None;
            return done;
        }
        let waiting = self.waiting.get_or_insert_with(|| Box::pin(time::sleep(TAKE_WITHIN)));
        waiting.as_mut().poll(context).map(|()| Err(io::ErrorKind::TimedOut.into()))
    }
}

impl AsyncRead for Patient {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, into)
    }
}

impl AsyncWrite for Patient {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let done = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.within(context, done)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let done = Pin::new(&mut self.stream).poll_write_vectored(context, bytes);
        self.within(context, done)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use axum::{http::StatusCode, routing::get};
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    use super::*;

    async fn served(router: Router) -> (SocketAddr, CancellationToken) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let (address, over) = (listener.local_addr().unwrap(), CancellationToken::new());
        let token = over.clone();
        tokio::spawn(async move { accept(listener, router, Duration::ZERO, &token).await });
        (address, over)
    }

    /// All that comes until the other end closes, and after how long by the clock of the test.
    async fn answer_to(address: SocketAddr, request: &str) -> (String, Duration) {
        let begin = time::Instant::now();
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer).await;
        (String::from_utf8_lossy(&answer).into_owned(), begin.elapsed())
    }

    // paused, the clock runs ahead to the next deadline as soon as nothing else is to be done
    #[tokio::test(start_paused = true)]
    async fn a_request_that_does_not_end_is_closed() {
        let (address, _over) = served(Router::new().route("/", get(async || StatusCode::OK))).await;
        let (answer, took) = answer_to(address, "GET / HTTP/1.1\r\nHost: x\r\nX: ").await;
        assert!(!answer.contains(" 200 "), "{answer}");
        assert!((REQUEST_WITHIN..REQUEST_WITHIN + Duration::from_secs(1)).contains(&took), "{took:?}");
        // one that is kept without another request, too
        let (answer, took) = answer_to(address, "GET / HTTP/1.1\r\nHost: x\r\n\r\n").await;
        assert!(answer.contains(" 200 "), "{answer}");
        assert!((REQUEST_WITHIN..REQUEST_WITHIN + Duration::from_secs(1)).contains(&took), "{took:?}");
    }

    #[tokio::test(start_paused = true)]
    async fn an_answer_that_is_not_taken_is_given_up() {
        let large = vec![b'x'; 64 << 20];
        let given_up = Arc::new(Semaphore::new(0));
        struct Noted(Arc<Semaphore>);
        impl Drop for Noted {
            fn drop(&mut self) {
                self.0.add_permits(1);
            }
        }
        let note = Arc::clone(&given_up);
        let answer = get(move || {
            let noted = Noted(Arc::clone(&note));
            let pieces = tokio_stream::iter(large.chunks(1 << 20).map(<[u8]>::to_vec).collect::<Vec<_>>());
            let pieces = tokio_stream::StreamExt::map(pieces, move |piece| {
                let _ = &noted;
                Ok::<_, io::Error>(piece)
            });
            async { axum::body::Body::from_stream(pieces) }
        });
        let (address, _over) = served(Router::new().route("/", answer)).await;
        let begin = time::Instant::now();
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n").await.unwrap();
        given_up.acquire().await.unwrap().forget();
        assert!(begin.elapsed() >= TAKE_WITHIN, "{:?}", begin.elapsed());
        drop(stream);
    }

    #[tokio::test(start_paused = true)]
    async fn connections_beyond_the_limit_are_closed_at_once() {
        let (address, _over) = served(Router::new().route("/", get(async || StatusCode::OK))).await;
        let mut open = Vec::new();
        for _ in 0..CONNECTIONS {
            open.push(TcpStream::connect(address).await.unwrap());
        }
        let (answer, took) = answer_to(address, "GET / HTTP/1.1\r\nHost: x\r\n\r\n").await;
        assert_eq!((answer.as_str(), took < REQUEST_WITHIN), ("", true));
        // in time they are closed, and others answered
        assert_eq!(open[0].read(&mut [0]).await.unwrap(), 0);
        let request = "GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";
        assert!(answer_to(address, request).await.0.contains(" 200 "));
    }
}
