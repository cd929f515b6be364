//! A measurement under way in a browser: one page for all sources of a command, its events, its
//! document, its report and its metrics.
//!
//! Nothing can be changed from here: the server holds the states of the sessions and no way to
//! command them. It runs on a thread of its own; measuring never waits for it.
//!
//! | file | is |
//! |---|---|
//! | `connection.rs` | connections: how many, how long, how large |
//! | `guard.rs` | which requests are answered, and with which headers |
//! | `routes.rs` | what is answered |
//! | `events.rs` | the stream of what has changed |
//! | `compression.rs` | answers as a browser unpacks them |
//! | `drawing.rs` | the parts of the pages, drawn when they have changed |

mod app;
mod compression;
mod connection;
mod drawing;
mod events;
mod guard;
mod routes;
#[cfg(test)]
mod tests;

use std::{
    io,
    net::TcpListener,
    sync::{Arc, Mutex, PoisonError},
    thread::{self, JoinHandle},
    time::Duration,
};

use tokio::{
    runtime::Builder,
    sync::{Semaphore, watch},
    time::{self, Instant, MissedTickBehavior},
};
use tokio_util::sync::CancellationToken;
use vn100_report::{goals::Goals, html::Program};
use vn100_session::SourceState;

use app::App;
pub(crate) use drawing::Drawer;
use drawing::PageState;

/// The program, as its reports name it.
pub(crate) const PROGRAM: Program<'static> =
    Program { name: concat!("vn100 ", env!("CARGO_PKG_VERSION")), commit: option_env!("VN100_COMMIT") };

/// The shortest interval between two versions of the page.
const PERIOD: Duration = Duration::from_secs(1);

/// The most streams of events that stay open at the same time.
const STREAMS: usize = 16;

/// A source that the page shows.
#[derive(Debug)]
pub(crate) struct ServedSource {
    /// The published state of its session.
    pub(crate) state: watch::Receiver<SourceState>,
    /// What its measurement ends by: durations and precisions.
    pub(crate) goals: Goals,
}

/// A running server. It serves until it is dropped, which waits for slow readers, but not for long,
/// and then for the end of its thread.
#[derive(Debug)]
pub(crate) struct Server {
    ending: CancellationToken,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts to serve what the drawer draws, on a thread of its own, to those who ask for one of these
    /// names or an address of this machine. The drawing of the last state, and then the readers, may
    /// take as long as `grace` before the server ends without them.
    pub(crate) fn start(
        listener: TcpListener,
        host_names: Vec<String>,
        drawer: Drawer,
        grace: Duration,
    ) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        let hosts = host_names.iter().map(|name| guard::bare(name)).collect();
        let ending = CancellationToken::new();
        let token = ending.clone();
        let run = move || {
            // drawing blocks: it is done by one thread, and others wait
            let runtime =
                Builder::new_current_thread().enable_all().thread_name("vn100-drawing").max_blocking_threads(1).build();
            if let Ok(runtime) = runtime {
                let _ = runtime.block_on(serve(listener, hosts, drawer, grace, token));
                runtime.shutdown_timeout(grace);
            }
        };
        let thread = Some(thread::Builder::new().name("vn100-serve".into()).spawn(run)?);
        Ok(Self { ending, thread })
    }
}

impl Drop for Server {
    /// Sends the last state to all readers, and ends the thread.
    fn drop(&mut self) {
        self.ending.cancel();
        if let Some(thread) = self.thread.take() {
            // a panic of the thread was reported where it occurred
            let _ = thread.join();
        }
    }
}

async fn serve(
    listener: TcpListener,
    hosts: Vec<String>,
    drawer: Drawer,
    grace: Duration,
    ending: CancellationToken,
) -> io::Result<()> {
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let app = Arc::new(App {
        drawer: Arc::new(Mutex::new(drawer)),
        page: watch::channel(Arc::new(PageState::default())).0,
        streams: Arc::new(Semaphore::new(STREAMS)),
        over: CancellationToken::new(),
        hosts,
    });
    let keeping = tokio::spawn(keep_drawn(Arc::clone(&app), grace, ending));
    connection::accept(listener, routes::router(&app), grace, &app.over).await;
    // a panic of the task was reported where it occurred
    let _ = keeping.await;
    Ok(())
}

/// Draws the page as long as it has readers, and once more at the end. Then all is over.
async fn keep_drawn(app: Arc<App>, grace: Duration, ending: CancellationToken) {
    // after a panic too, as the end of the server is waited for
    let _over = app.over.clone().drop_guard();
    let mut ticks = time::interval(PERIOD);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            _ = ticks.tick() => {}
            () = ending.cancelled() => break,
        }
        app.drawer.lock().unwrap_or_else(PoisonError::into_inner).look(Instant::now());
        if app.page.receiver_count() > 0 {
            app.draw().await;
        } else {
            // a reader who comes meanwhile waits for the next state
            app.page.send_replace(Arc::default());
        }
    }
    if app.page.receiver_count() > 0 {
        let _ = time::timeout(grace, app.draw()).await;
    }
}
