//! Metrics of measurements under way, for Prometheus and other programs that read its text format.

use std::{collections::BTreeSet, fmt::Write, time::Duration};

use vn100_analysis::noise::{Term, si_unit};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, LinkStatus, SourceResult};

use crate::{codes::name_of, health::line_load, names::rejected_kinds, printable::printable};

/// The media type of the metrics in HTTP: the text format 0.0.4 of Prometheus.
pub const METRICS_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// The metrics of these sources, each with the time since its last sample; `None` before the first. A
/// metric whose value is not known has no sample; noise parameters have none if the sensor was moved.
///
/// # Examples
/// ```
/// assert_eq!(vn100_report::metrics_text(&[]), "");
/// ```
pub fn metrics_text(sources: &[(&SourceResult, Option<Duration>)]) -> String {
    let mut families = Families(Vec::new());
    for (result, last_sample_age) in sources {
        of_source(&mut families, result, *last_sample_age);
    }
    let text = |Family { name, help, kind, samples }: &Family| {
        format!("# HELP {name} {help}\n# TYPE {name} {kind}\n{samples}")
    };
    families.0.iter().map(text).collect()
}

type Labels<'a> = &'a [(&'a str, &'a str)];

struct Families(Vec<Family>);

struct Family {
    name: &'static str,
    help: &'static str,
    kind: &'static str,
    samples: String,
}

impl Families {
    /// Adds a sample; one of a family that is there already stands behind its others.
    fn add(&mut self, kind: &'static str, name: &'static str, help: &'static str, labels: Labels<'_>, value: f64) {
        let place = self.0.iter().position(|family| family.name == name).unwrap_or_else(|| {
            self.0.push(Family { name, help, kind, samples: String::new() });
            self.0.len() - 1
        });
        let labels: Vec<String> = labels.iter().map(|(key, value)| format!("{key}=\"{}\"", escaped(value))).collect();
        // a String takes everything
        let _ = writeln!(self.0[place].samples, "{name}{{{}}} {value}", labels.join(","));
    }

    fn count(&mut self, name: &'static str, help: &'static str, labels: Labels<'_>, count: u64) {
        self.add("counter", name, help, labels, count as f64);
    }

    fn gauge(&mut self, name: &'static str, help: &'static str, labels: Labels<'_>, value: impl Into<Option<f64>>) {
        if let Some(value) = value.into().filter(|value| value.is_finite()) {
            self.add("gauge", name, help, labels, value);
        }
    }
}

/// The value of a label; what steers a terminal is replaced, as everywhere.
fn escaped(value: &str) -> String {
    printable(value).replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

fn of_source(out: &mut Families, result: &SourceResult, last_sample_age: Option<Duration>) {
    let (facts, timing, link) = (&result.source, &result.timing, &result.link);
    let port = ("port", facts.name.as_str());
    let of_port = &[port];
    let device = facts.device.clone().unwrap_or_default();
    let identity = [
        port,
        ("model", device.model.as_deref().unwrap_or_default()),
        ("serial", device.serial_number.as_deref().unwrap_or_default()),
        ("firmware", device.firmware.as_deref().unwrap_or_default()),
        ("message", facts.message.as_deref().unwrap_or_default()),
    ];
    out.gauge("vn100_info", "The source: sensor and message.", &identity, 1.0);
    let is_up = facts.end.is_none() && facts.link.as_ref().is_none_or(|link| link.status == LinkStatus::Connected);
    out.gauge("vn100_link_up", "Whether the sensor's output is received.", of_port, f64::from(u8::from(is_up)));
    out.count("vn100_samples_total", "Samples measured.", of_port, timing.samples);
    if let Some(missing) = timing.missing {
        let detected_by = name_of(timing.missing_from);
        let from = [port, ("from", detected_by.as_str())];
        out.count("vn100_missing_samples_total", "Missing samples, and what detects them.", &from, missing);
    }
    for (kind, count) in rejected_kinds(link) {
        out.count("vn100_bad_lines_total", "Rejected sentences, by the reason.", &[port, ("kind", kind)], count);
    }
    out.count("vn100_damaged_packets_total", "Packets that fail their checksum.", of_port, link.damaged_packets);
    out.count("vn100_bytes_total", "Bytes read.", of_port, link.bytes);
    out.count(
        "vn100_skipped_bytes_total",
        "Bytes in which no sentence and no packet was.",
        of_port,
        link.skipped_bytes,
    );
    out.count("vn100_reconnects_total", "How often the link was connected again.", of_port, link.reconnects);
    let rate_hz = timing.rate_hz.filter(|_| timing.samples > 0);
    out.gauge("vn100_rate_hertz", "Nominal sample rate.", of_port, rate_hz);
    let offset = timing.offset_ppm.map(|ppm| 1e-6 * ppm);
    out.gauge("vn100_rate_offset_ratio", "Measured over nominal sample rate, less 1.", of_port, offset);
    out.gauge("vn100_measurement_seconds", "Data time measured.", of_port, timing.duration_s);
    let age = last_sample_age.map(|age| age.as_secs_f64());
    out.gauge("vn100_last_sample_age_seconds", "Time since the last sample, to a second.", of_port, age);
    out.gauge("vn100_link_load_ratio", "Part of the baud rate in use.", of_port, line_load(result));
    let temperature = temperature_now(result).or_else(|| result.polled_temperature_c());
    out.gauge("vn100_temperature_celsius", "Temperature of the sensor now.", of_port, temperature);
    result.channels.iter().for_each(|channel| of_channel(out, port, channel));
    for kind in result.warnings.iter().map(|warning| warning.kind.name()).collect::<BTreeSet<_>>() {
        out.gauge("vn100_warning", "A warning that holds now, by its kind.", &[port, ("kind", kind)], 1.0);
    }
}

fn of_channel(out: &mut Families, port: (&str, &str), channel: &ChannelResult) {
    let labels = [port, ("channel", channel.name.as_str()), ("unit", channel.unit.as_str())];
    out.gauge("vn100_channel_mean", "Mean of all samples.", &labels, channel.statistics.mean);
    out.gauge("vn100_channel_std", "Standard deviation of all samples.", &labels, channel.statistics.std);
    let Some(noise) = &channel.noise else { return };
    for (term, name, help) in [
        (Term::White, "vn100_white_noise", "N, angle or velocity random walk, with its interval."),
        (Term::BiasInstability, "vn100_bias_instability", "B, with its interval, or an upper bound alone."),
        (Term::RateRandomWalk, "vn100_rate_random_walk", "K, with its interval, or an upper bound alone."),
    ] {
        let Some(parameter) = noise.parameter(term) else { continue };
        let unit = si_unit(noise.sensor, term);
        for (bound, value) in [("lower", parameter.lower), ("value", parameter.value), ("upper", parameter.upper)] {
            let labels = [port, ("channel", channel.name.as_str()), ("unit", unit), ("bound", bound)];
            out.gauge(name, help, &labels, value);
        }
    }
}

/// The latest half second of the temperature; `None` if the stream does not carry it.
fn temperature_now(result: &SourceResult) -> Option<f64> {
    let place = result.channels.iter().position(|channel| channel.quantity == Quantity::Temperature)?;
    let history = result.history(place, 2, 1)?;
    history.columns.last().copied().flatten().map(|column| column.mean)
}

#[cfg(test)]
mod tests {
    use vn100_analysis::{LinkFacts, SourceFacts, protocol::Register};

    use super::*;
    use crate::tests::fixture::{facts, nothing, result};

    fn text(name: &str) -> String {
        let link = Some(LinkFacts { status: LinkStatus::Connected, baud: Some(115_200), ..LinkFacts::default() });
        let result = result(SourceFacts { link, ..facts(name) }, nothing());
        metrics_text(&[(&result, Some(Duration::from_millis(1500)))])
    }

    #[test]
    fn counters_have_their_suffix() {
        let text = text("imu");
        assert!(text.contains("# TYPE vn100_samples_total counter\nvn100_samples_total{port=\"imu\"} 0\n"), "{text}");
    }

    #[test]
    fn what_is_not_known_has_no_sample() {
        let text = text("imu");
        for absent in ["vn100_rate_hertz", "vn100_missing_samples", "vn100_white_noise", "vn100_link_load_ratio", "NaN"]
        {
            assert!(!text.contains(absent), "{absent} in {text}");
        }
        assert!(text.contains("vn100_link_up{port=\"imu\"} 1\n"), "{text}");
    }

    #[test]
    fn a_temperature_that_was_asked_for_is_that_of_the_latest_answer() {
        let mut snapshot = nothing();
        let mut latest = |celsius: &str| {
            let fields = format!(
                "+00.1000,+00.2000,+00.4000,+00.100,+00.100,-09.800,+00.010000,+00.020000,+00.030000,{celsius},+099.700"
            );
            snapshot.registers.insert(Register::IMU.0, fields);
            snapshot.polled_temperature_c()
        };
        assert_eq!(latest("+21.6"), Some(21.6));
        assert_eq!(latest("+21.8"), Some(21.8));
        assert_eq!(latest("warm"), None);
        latest("+22.1");
        let result = result(facts(""), snapshot);
        let source = (&result, None);
        let text = metrics_text(&[source]);
        assert!(text.contains("vn100_temperature_celsius{port=\"\"} 22.1\n"), "{text}");
    }

    #[test]
    fn the_name_of_a_source_cannot_end_its_label() {
        let text = text("a\"} 1\nb\\");
        assert!(text.contains("vn100_link_up{port=\"a\\\"} 1\u{fffd}b\\\\\"} 1\n"), "{text}");
    }
}
