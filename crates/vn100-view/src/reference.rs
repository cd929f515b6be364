//! An earlier record whose curve lies below the present one: measured as that is, while the view is
//! shown already.

use std::{path::PathBuf, sync::Arc};

use imu_noise::Deviation;
use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;
use vn100_analysis::Settings;
use vn100_report::{
    printable,
    remedies::remedy_words,
    units::{ChannelValues, channel_values},
};
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
    pub(super) fn of(name: String, values: &[ChannelValues], deviation: Deviation) -> Self {
        let channel = |channel: &ChannelValues| ReferenceChannel {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            points: channel.deviations.iter().filter_map(|point| Some((point.tau_s, point.deviation?))).collect(),
        };
        Self { name, channels: values.iter().map(channel).collect(), deviation }
    }

    /// The curve of the same axis, in the same unit; `None` if it has none.
    pub(crate) fn curve(&self, channel: &ChannelValues) -> Option<&[(f64, f64)]> {
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
                    let values = channel_values(&result.snapshot, &result.assessment);
                    let reference = Self::of(name.clone(), &values, result.snapshot.deviation);
                    match vn100_report::words::end(&name, &result.end.plain(), &result.snapshot, remedy_words) {
                        Some(error) if result.snapshot.timing.samples == 0 => Err(error),
                        None if result.snapshot.timing.samples == 0 => Err(format!("{name}: no valid sample")),
                        _ => Ok(Arc::new(reference)),
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
