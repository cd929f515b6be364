//! An earlier record whose curve lies below the present one: measured as that is, while the view is
//! shown already.

use std::{path::PathBuf, sync::Arc};

use imu_noise::Deviation;
use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{ChannelResult, Settings, SourceResult};
use vn100_report::{printable, remedies::remedy_words};
use vn100_session::{ReplaySpec, Session};

/// The curves of an earlier record.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    pub(crate) name: String,
    channels: Vec<ReferenceChannel>,
    pub(crate) deviation: Deviation,
}

#[derive(Debug, Clone, PartialEq)]
struct ReferenceChannel {
    name: String,
    unit: String,
    /// Averaging time in seconds and deviation.
    points: Vec<(f64, f64)>,
}

/// The reference, once it is measured; or why it is not.
pub type PendingReference = oneshot::Receiver<Result<Arc<Reference>, String>>;

impl Reference {
    pub(super) fn of(name: String, result: &SourceResult) -> Self {
        let channel = |channel: &ChannelResult| ReferenceChannel {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            points: channel.allan.points.iter().filter_map(|point| Some((point.tau_s, point.deviation?))).collect(),
        };
        Self { name, channels: result.channels.iter().map(channel).collect(), deviation: result.deviation() }
    }

    /// The curve of the same axis, in the same unit; `None` if it has none.
    pub(crate) fn curve(&self, channel: &ChannelResult) -> Option<&[(f64, f64)]> {
        let same = self.channels.iter().find(|other| other.name == channel.name && other.unit == channel.unit)?;
        (!same.points.is_empty()).then_some(&same.points)
    }

    /// Measures a file by these settings, to its own end.
    #[must_use]
    pub fn measure(path: PathBuf, settings: Settings, stop: &CancellationToken) -> PendingReference {
        let settings = Settings { duration: None, until: Vec::new(), recent: false, ..settings };
        let spec = ReplaySpec { settings, stop: stop.child_token(), ..ReplaySpec::of(path) };
        let (sender, measured) = oneshot::channel();
        tokio::spawn(async move {
            let name = printable(&spec.name());
            let measured = match Session::replay(spec).result.await {
                Ok(result) => {
                    let (measured, end) = (&result.measured, &result.end);
                    let error = vn100_report::words::end(&name, end, measured.link.framed_bytes, remedy_words);
                    match measured.timing.samples {
                        0 => Err(error.unwrap_or_else(|| format!("{name}: no valid sample"))),
                        _ => Ok(Arc::new(Self::of(name.clone(), measured))),
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
