//! What all answers of the server are made from.

use std::sync::{Arc, Mutex, PoisonError};

use axum::http::StatusCode;
use tokio::{
    sync::{Semaphore, watch},
    task::spawn_blocking,
    time::Instant,
};
use tokio_util::sync::CancellationToken;

use crate::serve::drawing::{Drawer, PageState};

pub(crate) struct App {
    pub(crate) drawer: Arc<Mutex<Drawer>>,
    pub(crate) page: watch::Sender<Arc<PageState>>,
    pub(crate) streams: Arc<Semaphore>,
    /// Cancelled when the program ends and every reader has received the last state.
    pub(crate) over: CancellationToken,
    /// The names of this machine, each as a bare host.
    pub(crate) hosts: Vec<String>,
}

impl App {
    /// Calls `what` with the drawer on a thread that may block: drawing takes milliseconds.
    pub(crate) async fn ask<T: Send + 'static>(
        &self,
        what: impl FnOnce(&mut Drawer, Instant) -> T + Send + 'static,
    ) -> Result<T, StatusCode> {
        let drawer = Arc::clone(&self.drawer);
        let asked = move || what(&mut drawer.lock().unwrap_or_else(PoisonError::into_inner), Instant::now());
        spawn_blocking(asked).await.map_err(|_| StatusCode::INTERNAL_SERVER_ERROR)
    }

    /// Draws the page, and publishes it to the readers of its events.
    pub(crate) async fn draw(&self) {
        if let Ok(state) = self.ask(Drawer::draw).await {
            self.page.send_replace(state);
        }
    }
}
