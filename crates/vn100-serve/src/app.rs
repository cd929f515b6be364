//! What all answers are made of.

use std::sync::{Arc, Mutex, PoisonError};

use axum::http::StatusCode;
use tokio::{
    sync::{Semaphore, watch},
    task::spawn_blocking,
    time::Instant,
};
use tokio_util::sync::CancellationToken;

use crate::{
    drawing::{Drawer, PageState},
    hosts::Hosts,
};

/// What all answers are made of.
pub(crate) struct App {
    pub(crate) drawer: Arc<Mutex<Drawer>>,
    pub(crate) page: watch::Sender<Arc<PageState>>,
    pub(crate) streams: Arc<Semaphore>,
    /// The program ends, and those who read have its last state.
    pub(crate) over: CancellationToken,
    pub(crate) hosts: Hosts,
}

impl App {
    /// Asks the drawer, which may take its time.
    pub(crate) async fn ask<T: Send + 'static>(
        &self,
        what: impl FnOnce(&mut Drawer, Instant) -> T + Send + 'static,
    ) -> Result<T, StatusCode> {
        let drawer = Arc::clone(&self.drawer);
        let asked = move || what(&mut drawer.lock().unwrap_or_else(PoisonError::into_inner), Instant::now());
        spawn_blocking(asked).await.map_err(|_| StatusCode::INTERNAL_SERVER_ERROR)
    }

    /// Draws the page for those who read its events.
    pub(crate) async fn draw(&self) {
        if let Ok(page) = self.ask(Drawer::draw).await {
            self.page.send_replace(page);
        }
    }
}
