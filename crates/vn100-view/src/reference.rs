//! An earlier record whose curve lies below the present one: measured as that is, while the view is
//! shown already.

use std::{path::PathBuf, sync::Arc};

use imu_noise::Deviation;
use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{ChannelResult, Settings, SourceResult};
use vn100_report::{printable, remedies::remedy_words};
use vn100_session::{ReplaySpec, Session};

/// An earlier record.
#[derive(Debug, Clone)]
pub struct Reference {
    pub(crate) name: String,
    pub(crate) result: SourceResult,
}

/// The reference, once it is measured; or why it is not.
pub type PendingReference = oneshot::Receiver<Result<Arc<Reference>, String>>;

impl Reference {
    /// Averaging times in seconds and deviations of the same axis, in the same unit and of the same kind;
    /// `None` if it has none.
    pub(crate) fn curve(&self, channel: &ChannelResult, deviation: Deviation) -> Option<Vec<(f64, f64)>> {
        let mut channels = self.result.channels.iter().filter(|_| self.result.settings().deviation == deviation);
        let same = channels.find(|other| other.name == channel.name && other.unit == channel.unit)?;
        let points = same.allan.points.iter().filter_map(|point| Some((point.tau_s, point.deviation?)));
        Some(points.collect()).filter(|points: &Vec<_>| !points.is_empty())
    }

    /// Measures a file by these settings, to its own end.
    pub fn measure(path: PathBuf, settings: Settings, stop: &CancellationToken) -> PendingReference {
        let settings = Settings { duration: None, until: Vec::new(), recent: false, ..settings };
        let spec = ReplaySpec { settings, stop: stop.child_token(), ..ReplaySpec::of(path) };
        let (sender, measured) = oneshot::channel();
        tokio::spawn(async move {
            let name = printable(&spec.name());
            let measured = match Session::replay(spec).result.await {
                Ok(result) => {
                    let (measured, end) = (result.measured, &result.end);
                    let error = vn100_report::words::end(&name, end, measured.link.framed_bytes, remedy_words);
                    match measured.timing.samples {
                        0 => Err(error.unwrap_or_else(|| format!("{name}: no valid sample"))),
                        _ => Ok(Arc::new(Self { name: name.clone(), result: measured })),
                    }
                }
                Err(_) => Err(format!("{name}: internal error: the measurement stopped")),
            };
            // the view may have ended
            let _ = sender.send(measured.map_err(|error| format!("no reference: {}", printable(&error))));
        });
        measured
    }
}
